#include "viewer/window/view_options.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

namespace scanmill {

namespace {

// Reasons why commands do nothing for a scene without scans.
constexpr std::string_view kNoFrames = "a scene has no frames: a dataset of it has";
constexpr std::string_view kNoScans = "a scene has no scans: a dataset of it has";
constexpr std::string_view kNoRangeImage = "a scene has no range image: a dataset of it has";
constexpr std::string_view kNoTrajectory = "a scene has no trajectory: a dataset of it has";
constexpr std::string_view kNoRangeRings = "a scene has no sensor to draw range rings about";

// Each row: menu, action with number or option, label, keys, and why the command does nothing in a scene without scans.
std::vector<ViewCommand> listCommands() {
  using A = KeyAction;
  std::vector<ViewCommand> commands{
      {"Frames", {A::StepFrames, 1}, "next", {"Right", "."}, kNoFrames},
      {"Frames", {A::StepFrames, -1}, "previous", {"Left", ","}, kNoFrames},
      {"Frames", {A::StepFrames, 10}, "ten on", {"Page_Down"}, kNoFrames},
      {"Frames", {A::StepFrames, -10}, "ten back", {"Page_Up"}, kNoFrames},
      {"Frames", {A::FirstFrame}, "first", {"<"}, kNoFrames},
      {"Frames", {A::LastFrame}, "last", {">", "End"}, kNoFrames},
      {"Frames", {A::Play}, "play, pause", {" "}, kNoFrames},
      {"Frames", {A::GoTo}, "go to a key or index", {"g"}, kNoFrames},
      {"Scans", {A::NextScan}, "next of the sample", {"n"}, kNoScans},
      {"Scans", {A::ToggleOverlay}, "all over one another, each in a colour", {"l"}, kNoScans},
      {"Scans", {A::ToggleSplit}, "side by side, or one in several colours", {"s"}, kNoScans},
      {"Scans", {A::NextView}, "next view that colours are chosen for", {"Tab"}, kNoScans},
      {"Scans", {A::Switch, 0, &ViewOptions::rangeImage}, "range image", {"i"}, kNoRangeImage},
  };
  for (int i = 0; i < 10; ++i) {  // the keys 1 to 9, then 0
    const std::string& name = colorNames()[static_cast<std::size_t>(i)];
    commands.push_back({"Colours", {A::ColorByNumber, i}, "by " + name, {std::to_string((i + 1) % 10)}});
  }
  const std::vector<ViewCommand> othersOfMenus{
      {"Colours", {A::StepColor, 1}, "by the next column", {"c"}},
      {"Colours", {A::StepColor, -1}, "by the previous column", {"C"}},
      {"Colours", {A::AutomaticScale}, "the scale that the values give", {"\\"}},
      {"Show", {A::ShowAllClasses}, "all points", {"A"}},
      {"Show", {A::InstanceAlone}, "the instance that is pointed at alone", {"x"}},
      {"Show", {A::Switch, 0, &ViewOptions::legends}, "what colours mean", {"k"}},
      {"Show", {A::Switch, 0, &ViewOptions::mesh}, "mesh of the scene", {"m"}, "the scene's mesh is all that there is"},
      {"Show",
       {A::ToggleBoxes},
       "boxes of road users, of all objects, or none; or about the points of instances",
       {"O"},
       "a scene has no list of objects: a dataset of it may have"},
      {"Show", {A::Switch, 0, &ViewOptions::trajectory}, "trajectory", {"t"}, kNoTrajectory},
      {"Show",
       {A::Switch, 0, &ViewOptions::axes},
       "axes of the sensors (x red, y green, z blue), and the ego vehicle",
       {"a"}},
      {"Show", {A::Switch, 0, &ViewOptions::rangeRings}, "range rings on the ground", {"r"}, kNoRangeRings},
      {"Show", {A::Switch, 0, &ViewOptions::depthEdges}, "dark depth edges", {"e"}},
      {"Show", {A::ResizePoints, 1}, "larger points", {"+", "="}, "a scene has no points"},
      {"Show", {A::ResizePoints, -1}, "smaller points", {"-"}, "a scene has no points"},
      {"Show", {A::NextBackground}, "background dark, grey, white", {"b"}},
      {"Camera", {A::PresetView, static_cast<int>(View::Chase)}, "chase", {"F1"}},
      {"Camera", {A::PresetView, static_cast<int>(View::Driver)}, "driver's", {"F2"}},
      {"Camera", {A::PresetView, static_cast<int>(View::Above)}, "from above", {"F3"}},
      {"Camera", {A::ResetView}, "the first view again", {"Home"}},
      {"Camera", {A::TurnAbout}, "turn about what is pointed at", {"f"}},
      {"Camera", {A::ToggleProjection}, "perspective, orthographic", {"o"}},
      {"Camera", {A::ToggleWorld}, "stand in the world, follow the sensor", {"w"}, "a scene has no sensor to follow"},
      {"Tools", {A::Measure}, "distance between two clicks", {"d"}},
      {"Tools", {A::SavePicture}, "save a picture", {"P"}},
      {"Tools", {A::ToggleHelp}, "keys", {"h", "?"}},
      {"Tools", {A::Quit}, "quit", {"q"}},
      {"", {A::Escape}, "close what is open: help, distance, pin, instance alone", {"Escape"}},
  };
  commands.insert(commands.end(), othersOfMenus.begin(), othersOfMenus.end());
  return commands;
}

}  // namespace

const std::vector<ViewCommand>& viewCommands() {
  static const std::vector<ViewCommand> all = listCommands();
  return all;
}

std::optional<KeyMeaning> keyMeaning(std::string_view key) {
  for (const ViewCommand& command : viewCommands()) {
    if (std::ranges::find(command.keys, key) != command.keys.end()) return command.meaning;
  }
  return {};
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
  for (const ViewCommand& command : viewCommands()) {
    const std::string menu(command.menu);
    rows.emplace_back(keysText(command), menu.empty() ? command.label : menu + ": " + command.label);
  }
  return rows;
}

}  // namespace scanmill
