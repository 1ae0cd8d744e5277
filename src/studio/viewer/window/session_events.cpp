// Handles events, and executes the commands of keys and menus.

#include <fmt/core.h>

#include "viewer/window/session.h"

namespace scanmill {

namespace {

constexpr std::array<Rgb, 3> kBackgrounds{{kBackground, {104, 108, 116}, {255, 255, 255}}};

}  // namespace

bool ViewSession::handle(const CanvasEvent& event) {
  switch (event.kind) {
    case CanvasEvent::Kind::Close:
      return false;
    case CanvasEvent::Kind::Key:
      if (panels_.prompt || panels_.imgui.hasKeys()) {
        panels_.imgui.take(event);
        runPanels();
        context_.changes.panels = true;
        break;
      }
      for (const ViewCommand& command : commands()) {
        if (std::ranges::find(command.keys, event.key) == command.keys.end()) continue;
        context_.executing = &command;
        execute(command);
        context_.executing = nullptr;
      }
      break;
    case CanvasEvent::Kind::Down:
    case CanvasEvent::Kind::Up:
    case CanvasEvent::Kind::Wheel:
      handleButtonOrWheel(event);
      break;
    case CanvasEvent::Kind::Move:
      panels_.imgui.take(event);
      pointer_.moveTo(event);
      break;
    case CanvasEvent::Kind::Resize:
      context_.changes.views = true;
      sceneView_.placeClouds();
      break;
    case CanvasEvent::Kind::Redraw:
      context_.changes.items = context_.changes.panels = true;
      break;
    case CanvasEvent::Kind::Tick:
      tick();
      break;
  }
  if (quit_) return false;
  const bool comesInSeries = event.kind == CanvasEvent::Kind::Move || event.kind == CanvasEvent::Kind::Wheel;
  if (!comesInSeries || context_.redraw.mayFollowPointer()) {
    flush(Detail::Fast);
    for (const std::string& problem : problems()) warn(problem);  // warn() prints each text only once
    for (const std::string& text : context_.hints) warn(text);
  }
  return true;
}

// Handles a press, a release or a turn of the wheel. Panels receive the event first. Views receive every release, but
// presses and the wheel only if no panel uses them.
void ViewSession::handleButtonOrWheel(const CanvasEvent& event) {
  panels_.imgui.take(event);
  runPanels();
  context_.changes.panels = true;
  if (event.kind == CanvasEvent::Kind::Up) return pointer_.release(event);
  if (panels_.imgui.hasPointer()) return;
  if (event.kind == CanvasEvent::Kind::Down) return pointer_.press(event);
  if (!std::isfinite(event.amount)) return;
  sceneView_.changeCamera([&](OrbitCamera& camera) { camera.zoom(std::clamp(event.amount, -20.0, 20.0)); });
}

// Handles a tick: shows what is loaded, plays frames, removes old notices, and draws all points after a pause.
void ViewSession::tick() {
  // Reads the time before takeWhatIsLoaded(), so that playback_.tick() does not replace a new frame before it is drawn.
  const double now = context_.redraw.now();
  takeWhatIsLoaded();
  // Reading ahead must not delay the first picture.
  if (playback_.isUpToDate() && context_.redraw.drawnOnce()) playback_.readAhead();
  if (playback_.tick(now)) {
    context_.changes.panels = true;
    takeWhatIsLoaded();
  }
  const auto removed = std::erase_if(context_.notices, [&](const ViewNotice& notice) { return notice.until < now; });
  if (removed > 0) context_.changes.panels = true;
  if (!playback_.playing() && pointer_.drag.button == 0 && context_.redraw.allPointsDue()) flush(Detail::AllPoints);
}

// Executes a command, or tells the user why it does nothing for a scene without scans.
void ViewSession::execute(const ViewCommand& command) {
  const bool works = !context_.source->isScene() || command.whyNotInScene.empty();
  works ? command.run(*this) : context_.notify(command.whyNotInScene);
}

void ViewSession::resizePoints(int pixels) {
  context_.options.pointSize = std::clamp(sceneView_.pointSize() + pixels, 1.0, 20.0);
  sceneView_.placeClouds();
  context_.notify(fmt::format("points of {:.0f} px", context_.options.pointSize));
}

void ViewSession::toggleProjection() {
  sceneView_.changeCamera([](OrbitCamera& camera) { camera.orthographic = !camera.orthographic; });
  context_.notify(sceneView_.camera.orthographic ? "orthographic" : "perspective");
}

// Asks the user for a frame. Closes the help, which would otherwise receive the keys.
void ViewSession::openPrompt() {
  if (context_.options.bare) return;  // there is no panel to type into
  panels_.help = false;
  panels_.prompt = "";
  context_.changes.panels = true;
}

void ViewSession::nextScan() {
  if (context_.scanCount() < 2) return context_.notify("the sample has no other scan");
  clouds_.scanName = context_.frame->scans[(clouds_.shownScan() + 1) % context_.scanCount()].name;
  context_.options.layout = ViewLayout::One;
  arrange();
}

// Shows the map of the current sample's sequence or, if a map is shown, the sample that was shown before.
void ViewSession::toggleMap() {
  std::shared_ptr<const FrameSource> next = context_.source->samples();
  std::string& sample = context_.options.sample;
  if (!next) {
    sample = context_.source->keys()[playback_.requested()];
    next = mapOf(context_.source, sample);
  }
  context_.source = next;
  playback_ = Playback(next, std::make_unique<FrameLoader>(next), sample);
  sceneView_.isFitted = false;
  context_.changes.panels = true;
  takeWhatIsLoaded();
}

// Chooses a layout; chooses the layout One if `layout` is chosen already.
void ViewSession::toggleLayout(ViewLayout layout) {
  if (layout == ViewLayout::Overlay && context_.frame && context_.frame->scans.size() < 2) {
    return context_.notify("the sample has no other scan to lay over it");
  }
  context_.options.layout = context_.options.layout == layout ? ViewLayout::One : layout;
  clouds_.activeView.reset();
  if (context_.options.layout == ViewLayout::Split && context_.scanCount() == 1) clouds_.activeView = 1;
  arrange();
}

void ViewSession::nextBackground() {
  const auto current = std::ranges::find(kBackgrounds, context_.options.background);
  const bool isLast = current == kBackgrounds.end() || current + 1 == kBackgrounds.end();
  context_.options.background = isLast ? kBackgrounds.front() : current[1];
  context_.changes.views = context_.changes.panels = true;
}

// Chooses the next value of BoxChoice; if the frame lists no objects, switches the boxes of instances on or off.
void ViewSession::nextBoxes() {
  context_.changes.views = true;
  if (context_.frame && context_.frame->objects.empty()) {
    sceneView_.instanceBoxes = !sceneView_.instanceBoxes;
    sceneView_.placeGuides();
    return context_.notify(fmt::format("boxes about instances' points {}", sceneView_.instanceBoxes ? "on" : "off"));
  }
  constexpr std::size_t kChoices = kBoxChoiceNames.size();
  context_.options.boxes = static_cast<BoxChoice>((static_cast<std::size_t>(context_.options.boxes) + 1) % kChoices);
  sceneView_.placeGuides();
  constexpr std::array<const char*, kChoices> kBoxTexts{"of road users", "of all objects", "off"};
  return context_.notify(fmt::format("boxes {}", kBoxTexts[static_cast<std::size_t>(context_.options.boxes)]));
}

// Activates the next view. After the last view, activates all views or, if they show the same scan, the first view.
void ViewSession::nextView() {
  if (clouds_.viewCount() < 2) return context_.notify("there is one view only; s splits it");
  clouds_.activeView = clouds_.activeView ? *clouds_.activeView + 1 : 0;
  if (*clouds_.activeView >= clouds_.viewCount()) clouds_.activeView.reset();
  if (!clouds_.activeView && context_.scanCount() == 1) clouds_.activeView = 0;
  context_.changes.items = context_.changes.panels = true;
  clouds_.makeStrip();
}

// Switches an option on or off (see KeyMeaning::option), and draws what depends on the option.
void ViewSession::switchOption(bool ViewOptions::*option) {
  if (option == &ViewOptions::trajectory && sceneView_.trajectory.size() < 2) {
    return context_.notify("there is no trajectory");
  }
  bool& on = context_.options.*option;
  on = !on;
  context_.changes.views = true;
  sceneView_.placeGuides();
  if (option == &ViewOptions::rangeImage) clouds_.makeStrip();
  if (option != &ViewOptions::mesh) return;
  sceneView_.meshProblem.clear();
  if (on) wantMesh();
  sceneView_.placeMesh();
}

// Ends the first of these that is on: menus, help, measuring, selection, one instance alone, playing.
void ViewSession::escape() {
  context_.changes.panels = true;
  if (panels_.imgui.closeMenus()) return;
  if (panels_.help) {
    panels_.help = false;
  } else if (pointer_.measuring || !pointer_.ends.empty()) {
    pointer_.toggleMeasuring();
  } else if (pointer_.pinned) {
    pointer_.pinned.reset();
  } else if (!context_.filter.instances.empty()) {
    toggleInstanceAlone();
  } else if (playback_.playing()) {
    playback_.stop();
  } else {
    context_.notify("q quits");
  }
}

void ViewSession::chooseColor(const ColorBy& by) {
  if (!context_.source->isScene()) return clouds_.chooseColor(by);
  const auto name = std::ranges::find(kMeshColorNames, by.name());
  if (name == kMeshColorNames.end()) return;
  sceneView_.chooseMeshColor(static_cast<MeshColor>(name - kMeshColorNames.begin()));
}

void ViewSession::cycleColor(int step) {
  if (!context_.source->isScene()) return clouds_.cycleColor(step);
  constexpr auto kColors = static_cast<int>(kMeshColorNames.size());
  sceneView_.chooseMeshColor(
      static_cast<MeshColor>((static_cast<int>(sceneView_.meshColor) + step + kColors) % kColors));
}

void ViewSession::toggleWorld() {
  const auto newFromOld = sceneView_.toggleWorld();
  if (!newFromOld) return context_.notify("the poses of the scans are not known");
  pointer_.moveBy(*newFromOld);
  context_.notify(sceneView_.staysInWorld ? "standing in the world" : "following the sensor");
}

// Shows only the instance under the pointer, else the clicked one. If an instance is shown alone, shows all.
void ViewSession::toggleInstanceAlone() {
  if (!context_.filter.instances.empty()) {
    context_.filter.instances.clear();
    applyFilter();
    return context_.notify("all instances");
  }
  refresh();  // the last moves of the pointer may not have been processed yet
  updateHover();
  const PickedElement* const picked = pointer_.hoveredOrPinned();
  if (picked == nullptr) return context_.notify("nothing lies there: point at an instance");
  const auto id = pointer_.instanceOf(*picked);
  if (!id) return context_.notify("what lies there is of no instance");
  context_.filter.instances = {*id};
  applyFilter();
}

// Shows all points. Legends count all points again, not only those of a close-up.
void ViewSession::showAll() {
  context_.filter = {};
  arrange();
}

void ViewSession::toggleHelp() {
  panels_.help = !panels_.help;
  context_.changes.panels = context_.changes.hover = true;
}

void ViewSession::savePicture() {
  context_.notices.clear();
  context_.changes.panels = true;
  flush(Detail::AllPoints);
  try {
    context_.notify(
        fmt::format("saved {}; its camera: {}", savePictureOf(context_.canvas).string(), sceneView_.cameraText()));
  } catch (const Error& e) {
    context_.notify(e.what());
    warn(e.what());
  }
}

}  // namespace scanmill
