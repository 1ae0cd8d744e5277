// Handles events, and executes the actions of keys, or says that a scene without scans has none of what they act on.

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "viewer/window/session_state.h"

namespace scanmill {

namespace {

constexpr std::array<Rgb, 3> kBackgrounds{{{13, 15, 20}, {104, 108, 116}, {255, 255, 255}}};

}  // namespace

bool ViewSession::State::handle(const CanvasEvent& event) {
  switch (event.kind) {
    case CanvasEvent::Kind::Close:
      return false;
    case CanvasEvent::Kind::Key:
      if (panels.prompt || panels.toolkit.hasKeys()) {
        panels.toolkit.take(event);
        runPanels();
        context.changes.panels = true;
      } else {
        key(event);
      }
      break;
    case CanvasEvent::Kind::Down:
    case CanvasEvent::Kind::Up:
    case CanvasEvent::Kind::Wheel:
      // Panels receive the event first. Views receive every release, but presses and the wheel only if no panel uses
      // them.
      panels.toolkit.take(event);
      runPanels();
      context.changes.panels = true;
      if (event.kind == CanvasEvent::Kind::Up) {
        pointer.release(event);
      } else if (panels.toolkit.hasPointer()) {
        break;
      } else if (event.kind == CanvasEvent::Kind::Down) {
        pointer.press(event);
      } else if (std::isfinite(event.amount)) {
        OrbitCamera zoomed = scenery.camera;
        zoomed.zoom(std::clamp(event.amount, -20.0, 20.0));
        scenery.setCamera(zoomed);
      }
      break;
    case CanvasEvent::Kind::Move:
      panels.toolkit.take(event);
      pointer.moveTo(event);
      break;
    case CanvasEvent::Kind::Resize:
      context.changes.views = true;
      scenery.placeClouds();
      break;
    case CanvasEvent::Kind::Redraw:
      context.changes.items = context.changes.panels = true;
      break;
    case CanvasEvent::Kind::Tick:
      tick();
      break;
  }
  if (quit) return false;
  const bool passing = event.kind == CanvasEvent::Kind::Move || event.kind == CanvasEvent::Kind::Wheel;
  if (!passing || context.drawing.mayFollowPointer()) {
    flush(false);
    for (const std::string& problem : problems()) warn(problem);  // warn() prints each text only once
    for (const std::string& text : context.hints) warn(text);
  }
  return true;
}

void ViewSession::State::tick() {
  // The time is read before takeWhatIsLoaded() shows a frame, so that playback.tick() does not replace the frame before
  // it is drawn.
  const double now = context.drawing.now();
  takeWhatIsLoaded();
  // Reading ahead must not delay the first picture.
  if (playback.settled() && context.drawing.drawnOnce()) playback.readAhead();
  if (playback.tick(now)) {
    context.changes.panels = true;
    takeWhatIsLoaded();
  }
  if (context.forgetNotices()) context.changes.panels = true;
  if (!playback.playing() && pointer.drag.button == 0 && context.drawing.wholeIsDue()) flush(true);
}

void ViewSession::State::key(const CanvasEvent& event) {
  const auto meaning = keyMeaning(event.key, event.shift);
  if (!meaning) return;
  context.acting = meaning;
  act(*meaning);
  context.acting.reset();
}

// Returns the option that the action switches on and off, and the option's name; null if the action is not a switch.
std::pair<bool*, const char*> ViewSession::State::switchOf(KeyAction action) {
  using enum KeyAction;
  ViewOptions& options = context.options;
  if (action == ToggleAxes) return {&options.axes, "axes"};
  if (action == ToggleRangeRings) return {&options.rangeRings, "range rings"};
  if (action == ToggleBoxes && context.frame && context.frame->objects.empty())
    return {&scenery.instanceBoxes, "boxes about instances' points"};
  if (action == ToggleTrajectory && scenery.trajectory.size() > 1) return {&options.trajectory, "trajectory"};
  if (action == ToggleDepthEdges) return {&options.depthEdges, "depth edges"};
  if (action == ToggleLegends) return {&options.legends, "legends"};
  return {};
}

void ViewSession::State::act(const KeyMeaning& meaning) {
  const auto toggle = [&](KeyAction action) {
    const auto [option, name] = switchOf(action);
    if (option == nullptr) return context.say("there is no trajectory");
    *option = !*option;
    scenery.placeGuides();
    context.changes.views = true;
    context.say(fmt::format("{} {}", name, *option ? "on" : "off"));
  };
  const auto setLayout = [&](ViewLayout wantedLayout) {
    context.options.layout = context.options.layout == wantedLayout ? ViewLayout::One : wantedLayout;
    clouds.activeView.reset();
    if (context.options.layout == ViewLayout::Split && context.frame && context.frame->scans.size() == 1)
      clouds.activeView = 1;
    pointer.hover.reset();
    arrange();
  };
  if (context.source->isScene()) {
    if (const std::string why = sceneLacks(meaning); !why.empty()) return context.say(why);
  }
  switch (meaning.action) {
    case KeyAction::StepColor:
      return cycleColor(meaning.number);
    case KeyAction::ColorByNumber:
      return chooseColor(colorOf(meaning));
    case KeyAction::LowerHighEnd:
    case KeyAction::RaiseHighEnd:
    case KeyAction::LowerLowEnd:
    case KeyAction::RaiseLowEnd:
    case KeyAction::AutomaticScale:
      return clouds.changeScale(meaning.action);
    case KeyAction::ResizePoints:
      context.options.pointSize = std::clamp(scenery.pointSize() + meaning.number, 1.0, 20.0);
      scenery.placeClouds();
      return context.say(fmt::format("points of {:.0f} px", context.options.pointSize));
    case KeyAction::NextBackground: {
      const auto is = std::ranges::find(kBackgrounds, context.options.background);
      context.options.background =
          is == kBackgrounds.end() || is + 1 == kBackgrounds.end() ? kBackgrounds.front() : is[1];
      context.changes.views = context.changes.panels = true;
      return;
    }
    case KeyAction::ToggleAxes:
    case KeyAction::ToggleRangeRings:
    case KeyAction::ToggleBoxes: {
      if (context.frame && context.frame->objects.empty()) return toggle(meaning.action);
      constexpr std::size_t kChoices = kBoxChoiceNames.size();
      context.options.boxes = static_cast<BoxChoice>((static_cast<std::size_t>(context.options.boxes) + 1) % kChoices);
      scenery.placeGuides();
      context.changes.views = true;
      constexpr std::array<const char*, kChoices> kSaid{"of road users", "of all objects", "off"};
      return context.say(fmt::format("boxes {}", kSaid[static_cast<std::size_t>(context.options.boxes)]));
    }
    case KeyAction::ToggleTrajectory:
    case KeyAction::ToggleDepthEdges:
    case KeyAction::ToggleLegends:
      return toggle(meaning.action);
    case KeyAction::ToggleMesh:
      context.options.mesh = !context.options.mesh;
      scenery.meshProblem.clear();
      context.changes.panels = true;
      if (context.options.mesh) wantMesh();
      return placeMesh();
    case KeyAction::ToggleProjection: {
      OrbitCamera other = scenery.camera;
      other.orthographic = !other.orthographic;
      scenery.setCamera(other);
      return context.say(other.orthographic ? "orthographic" : "perspective");
    }
    case KeyAction::PresetView:
      return scenery.setCamera(scenery.preset(static_cast<View>(meaning.number)));
    case KeyAction::NextPreset:
      if (scenery.camera == scenery.preset(View::Chase)) return scenery.setCamera(scenery.preset(View::Driver));
      return scenery.setCamera(
          scenery.preset(scenery.camera == scenery.preset(View::Driver) ? View::Above : View::Chase));
    case KeyAction::TurnAbout:
      return pointer.turnAbout();
    case KeyAction::ResetView:
      return scenery.setCamera(scenery.firstCamera());
    case KeyAction::StepFrames:
      return stepBy(meaning.number);
    case KeyAction::FirstFrame:
      return goTo(0, 1);
    case KeyAction::LastFrame:
      return goTo(playback.count() - 1, -1);
    case KeyAction::Play:
      return togglePlaying();
    case KeyAction::ChangeSpeed:
      return changeSpeed(meaning.number);
    case KeyAction::GoTo:
      if (context.options.bare) return;  // there is no panel to type into
      panels.help = false;               // closes the help, which would otherwise receive the keys
      panels.prompt = "";
      context.changes.panels = true;
      return;
    case KeyAction::ToggleOverlay:
      if (context.frame && context.frame->scans.size() < 2)
        return context.say("the sample has no other scan to lay over it");
      return setLayout(ViewLayout::Overlay);
    case KeyAction::ToggleSplit:
      return setLayout(ViewLayout::Split);
    case KeyAction::NextView:
      if (clouds.viewCount() < 2) return context.say("there is one view only; s splits it");
      // Each press activates the next view; after the last view, all views are active if they show different scans.
      clouds.activeView = clouds.activeView ? *clouds.activeView + 1 : 0;
      if (*clouds.activeView >= clouds.viewCount()) clouds.activeView.reset();
      if (!clouds.activeView && context.frame->scans.size() == 1) clouds.activeView = 0;
      context.changes.items = context.changes.panels = true;
      return clouds.makeStrip();
    case KeyAction::NextScan:
      if (!context.frame || context.frame->scans.size() < 2) return context.say("the sample has no other scan");
      clouds.scanName = context.frame->scans[(clouds.shownScan() + 1) % context.frame->scans.size()].name;
      context.options.layout = ViewLayout::One;
      return arrange();
    case KeyAction::ToggleWorld:
      return toggleWorld();
    case KeyAction::ShowAllClasses:
      context.filter.classes.showAll();
      context.filter.instances.clear();
      context.filter.hiddenScans.clear();
      context.filter.closeUp.reset();
      return applyFilter();
    case KeyAction::InstanceAlone:
      return toggleAlone();
    case KeyAction::Measure:
      return pointer.toggleMeasuring();
    case KeyAction::ToggleRangeImage:
      context.options.rangeImage = !context.options.rangeImage;
      context.changes.views = true;
      return clouds.makeStrip();
    case KeyAction::SavePicture:
      return savePicture();
    case KeyAction::ToggleHelp:
      panels.help = !panels.help;
      context.changes.panels = context.changes.hover = true;
      return;
    case KeyAction::Escape:
      return escape();
    case KeyAction::Quit:
      quit = true;
      return;
  }
}

void ViewSession::State::escape() {
  context.changes.panels = true;
  if (panels.toolkit.closeMenus()) return;
  if (panels.help) {
    panels.help = false;
  } else if (pointer.measuring || !pointer.ends.empty()) {
    pointer.toggleMeasuring();
  } else if (pointer.pinned) {
    pointer.pinned.reset();
  } else if (!context.filter.instances.empty()) {
    toggleAlone();
  } else if (playback.playing()) {
    playback.stop();
  } else {
    context.say("q quits");
  }
}

void ViewSession::State::chooseColor(const ColorBy& by) {
  if (!context.source->isScene()) return clouds.chooseColor(by);
  const auto name = std::ranges::find(kMeshColorNames, by.name());
  if (name != kMeshColorNames.end()) {
    scenery.chooseMeshColor(static_cast<MeshColor>(name - kMeshColorNames.begin()));
  }
}

void ViewSession::State::cycleColor(int step) {
  if (!context.source->isScene()) return clouds.cycleColor(step);
  constexpr auto kColors = static_cast<int>(kMeshColorNames.size());
  scenery.chooseMeshColor(static_cast<MeshColor>((static_cast<int>(scenery.meshColor) + step + kColors) % kColors));
}

void ViewSession::State::toggleWorld() {
  const auto newFromOld = scenery.toggleWorld();
  if (!newFromOld) return context.say("the poses of the scans are not known");
  pointer.moveBy(*newFromOld);
  context.say(scenery.world ? "standing in the world" : "following the sensor");
}

void ViewSession::State::toggleAlone() {
  if (!context.filter.instances.empty()) {
    context.filter.instances.clear();
    applyFilter();
    return context.say("all instances");
  }
  refresh();  // the last moves of the pointer may not have been processed yet
  updateHover();
  const PickedThing* const thing = pointer.shown();
  if (thing == nullptr) return context.say("nothing lies there: point at an instance");
  const auto id = pointer.instanceOf(*thing);
  if (!id) return context.say("what lies there is of no instance");
  context.filter.instances = {*id};
  applyFilter();
}

void ViewSession::State::savePicture() {
  context.notices.clear();
  context.changes.panels = true;
  flush(true);
  try {
    context.say(fmt::format("saved {}; its camera: {}", savePictureOf(context.canvas).string(), scenery.cameraText()));
  } catch (const Error& e) {
    context.say(e.what());
    warn(e.what());
  }
}

std::string ViewSession::State::sceneLacks(const ColorBy& by) const {
  if (std::ranges::find(kMeshColorNames, by.name()) != kMeshColorNames.end()) return {};
  return fmt::format("a scene has no {}: it is coloured by {}", by.name(), fmt::join(kMeshColorNames, ", "));
}

// States which keys do nothing if a scene is shown without scans: it has triangles, but neither points nor frames.
std::string ViewSession::State::sceneLacks(const KeyMeaning& meaning) const {
  using enum KeyAction;
  static const std::vector<std::pair<std::vector<KeyAction>, const char*>> kLacks{
      {{ResizePoints}, "a scene has no points"},
      {{ToggleRangeRings}, "a scene has no sensor to draw range rings about"},
      {{ToggleTrajectory}, "a scene has no trajectory: a dataset of it has"},
      {{ToggleBoxes}, "a scene has no list of objects: a dataset of it may have"},
      {{ToggleMesh}, "the scene's mesh is all that there is"},
      {{StepFrames, FirstFrame, LastFrame, Play, GoTo}, "a scene has no frames: a dataset of it has"},
      {{ToggleOverlay, ToggleSplit, NextView, NextScan}, "a scene has no scans: a dataset of it has"},
      {{ToggleWorld}, "a scene has no sensor to follow"},
      {{ToggleRangeImage}, "a scene has no range image: a dataset of it has"}};
  if (meaning.action == ColorByNumber) return sceneLacks(colorOf(meaning));
  for (const auto& [actions, lack] : kLacks) {
    if (std::ranges::find(actions, meaning.action) != actions.end()) return lack;
  }
  return {};
}

}  // namespace scanmill
