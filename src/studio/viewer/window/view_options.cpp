#include "viewer/window/view_options.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include "viewer/window/session.h"

namespace scanmill {

namespace {

// Reasons why commands do nothing for a scene without scans.
constexpr const char* kNoFrames = "a scene has no frames: a dataset of it has";
constexpr const char* kNoScans = "a scene has no scans: a dataset of it has";

}  // namespace

const std::vector<ViewCommand>& ViewSession::commands() {
  static const std::vector<ViewCommand> all = [] {
    using S = ViewSession;
    const auto switchOf = [](std::string_view menu, const std::string& label, const std::string& key,
                             bool ViewOptions::*option, const std::string& whyNotInScene = "") {
      return ViewCommand{menu,          label,
                         {key},         [=](S& s) { s.switchOption(option); },
                         whyNotInScene, [=](const S& s) { return s.context_.options.*option; }};
    };
    const auto presetView = [](const std::string& label, const std::string& key, View view) {
      return ViewCommand{"Camera", label, {key}, [=](S& s) { s.sceneView_.setCamera(s.sceneView_.preset(view)); }};
    };
    std::vector<ViewCommand> commands{
        {"Frames", "next", {"Right", "."}, [](S& s) { s.stepBy(1); }, kNoFrames},
        {"Frames", "previous", {"Left", ","}, [](S& s) { s.stepBy(-1); }, kNoFrames},
        {"Frames", "ten on", {"Page_Down"}, [](S& s) { s.stepBy(10); }, kNoFrames},
        {"Frames", "ten back", {"Page_Up"}, [](S& s) { s.stepBy(-10); }, kNoFrames},
        {"Frames", "first", {"<"}, [](S& s) { s.goTo(0, 1); }, kNoFrames},
        {"Frames", "last", {">", "End"}, [](S& s) { s.goTo(s.playback_.count() - 1, -1); }, kNoFrames},
        {"Frames", "play, pause", {" "}, [](S& s) { s.togglePlaying(); }, kNoFrames},
        {"Frames", "go to a key or index", {"g"}, [](S& s) { s.openPrompt(); }, kNoFrames},
        {"Frames",
         "all of the sequence in one map",
         {"M"},
         [](S& s) { s.toggleMap(); },
         kNoFrames,
         [](const S& s) { return s.context_.source->samples() != nullptr; }},
        {"Scans", "next of the sample", {"n"}, [](S& s) { s.nextScan(); }, kNoScans},
        {"Scans",
         "all over one another, each in a colour",
         {"l"},
         [](S& s) { s.toggleLayout(ViewLayout::Overlay); },
         kNoScans,
         [](const S& s) { return s.clouds_.overlaid(); }},
        {"Scans",
         "side by side, or one in several colours",
         {"s"},
         [](S& s) { s.toggleLayout(ViewLayout::Split); },
         kNoScans,
         [](const S& s) { return s.context_.options.layout == ViewLayout::Split; }},
        {"Scans", "next view that colours are chosen for", {"Tab"}, [](S& s) { s.nextView(); }, kNoScans},
        switchOf("Scans", "range image", "i", &ViewOptions::rangeImage,
                 "a scene has no range image: a dataset of it has"),
    };
    for (int i = 0; i < 10; ++i) {  // the keys 1 to 9, then 0
      const ColorBy by(colorNames()[static_cast<std::size_t>(i)]);
      const std::string key = std::to_string((i + 1) % 10);
      commands.push_back({"Colours", "by " + by.name(), {key}, [=](S& s) { s.chooseColor(by); }, whyNoMeshColor(by)});
    }
    const std::vector<ViewCommand> othersOfMenus{
        {"Colours", "by the next column", {"c"}, [](S& s) { s.cycleColor(1); }},
        {"Colours", "by the previous column", {"C"}, [](S& s) { s.cycleColor(-1); }},
        {"Colours", "the scale that the values give", {"\\"}, [](S& s) { s.clouds_.resetScales(); }},
        {"Show", "all points", {"A"}, [](S& s) { s.showAll(); }},
        {"Show",
         "the instance that is pointed at alone",
         {"x"},
         [](S& s) { s.toggleInstanceAlone(); },
         "",
         [](const S& s) { return !s.context_.filter.instances.empty(); }},
        switchOf("Show", "what colours mean", "k", &ViewOptions::legends),
        switchOf("Show", "mesh of the scene", "m", &ViewOptions::mesh, "the scene's mesh is all that there is"),
        {"Show",
         "boxes of road users, of all objects, or none; or about the points of instances",
         {"O"},
         [](S& s) { s.nextBoxes(); },
         "a scene has no list of objects: a dataset of it may have",
         [](const S& s) { return s.sceneView_.instanceBoxes; }},
        switchOf("Show", "trajectory", "t", &ViewOptions::trajectory, "a scene has no trajectory: a dataset of it has"),
        switchOf("Show", "axes of the sensors (x red, y green, z blue), and the ego vehicle", "a", &ViewOptions::axes),
        switchOf("Show", "range rings on the ground", "r", &ViewOptions::rangeRings,
                 "a scene has no sensor to draw range rings about"),
        switchOf("Show", "dark depth edges", "e", &ViewOptions::depthEdges),
        {"Show", "larger points", {"+", "="}, [](S& s) { s.resizePoints(1); }, "a scene has no points"},
        {"Show", "smaller points", {"-"}, [](S& s) { s.resizePoints(-1); }, "a scene has no points"},
        {"Show", "background dark, grey, white", {"b"}, [](S& s) { s.nextBackground(); }},
        presetView("chase", "F1", View::Chase),
        presetView("driver's", "F2", View::Driver),
        presetView("from above", "F3", View::Above),
        {"Camera", "the first view again", {"Home"}, [](S& s) { s.sceneView_.setCamera(s.sceneView_.firstCamera()); }},
        {"Camera", "turn about what is pointed at", {"f"}, [](S& s) { s.pointer_.turnAbout(); }},
        {"Camera", "perspective, orthographic", {"o"}, [](S& s) { s.toggleProjection(); }},
        {"Camera",
         "stand in the world, follow the sensor",
         {"w"},
         [](S& s) { s.toggleWorld(); },
         "a scene has no sensor to follow",
         [](const S& s) { return s.sceneView_.staysInWorld; }},
        {"Tools", "distance between two clicks", {"d"}, [](S& s) { s.pointer_.toggleMeasuring(); }},
        {"Tools", "save a picture", {"P"}, [](S& s) { s.savePicture(); }},
        {"Tools", "keys", {"h", "?"}, [](S& s) { s.toggleHelp(); }},
        {"Tools", "quit", {"q"}, [](S& s) { s.quit_ = true; }},
        {"", "close what is open: help, distance, pin, instance alone", {"Escape"}, [](S& s) { s.escape(); }},
    };
    commands.insert(commands.end(), othersOfMenus.begin(), othersOfMenus.end());
    return commands;
  }();
  return all;
}

std::string keysText(const ViewCommand& command) {
  std::vector<std::string> names = command.keys;
  std::replace(names.begin(), names.end(), std::string(" "), std::string("space"));
  return fmt::format("{}", fmt::join(names, " or "));
}

std::vector<std::pair<std::string, std::string>> viewKeys() {
  std::vector<std::pair<std::string, std::string>> rows{
      {"left drag", "turn"},
      {"right drag, shift + left drag", "move"},
      {"wheel", "nearer, farther"},
      {"click", "pin what lies there; among what colours mean: hide or show"},
      {"double click, shift + click", "turn about what lies there; among what colours mean: show that alone"},
  };
  for (const ViewCommand& command : ViewSession::commands()) {
    const std::string menu(command.menu);
    rows.emplace_back(keysText(command), menu.empty() ? command.label : menu + ": " + command.label);
  }
  return rows;
}

}  // namespace scanmill
