// Handles events, and executes the actions of keys.

#include <fmt/core.h>

#include <algorithm>

#include "viewer/window/save_picture.h"
#include "viewer/window/session_state.h"

namespace scanmill {

namespace {

constexpr std::array<Rgb, 3> kBackgrounds{{{13, 15, 20}, {104, 108, 116}, {255, 255, 255}}};

}  // namespace

bool ViewSession::State::handle(const CanvasEvent& event) {
  constexpr double kBetweenPictures = 0.012;  // s: moves that come in quicker succession are drawn together
  switch (event.kind) {
    case CanvasEvent::Kind::Close:
      return false;
    case CanvasEvent::Kind::Key:
      if (prompt || toolkit.hasKeys()) {
        toolkit.take(event);
        runPanels();
        hudChanged = true;
      } else {
        key(event);
      }
      break;
    case CanvasEvent::Kind::Down:
    case CanvasEvent::Kind::Up:
    case CanvasEvent::Kind::Wheel:
      // Panels get the event first; the views get it only if no panel uses it.
      toolkit.take(event);
      runPanels();
      hudChanged = true;
      if (event.kind == CanvasEvent::Kind::Up) {
        release(event);
      } else if (toolkit.hasPointer()) {
        break;
      } else if (event.kind == CanvasEvent::Kind::Down) {
        press(event);
      } else if (std::isfinite(event.amount)) {
        OrbitCamera zoomed = camera;
        zoomed.zoom(std::clamp(event.amount, -20.0, 20.0));
        setCamera(zoomed);
      }
      break;
    case CanvasEvent::Kind::Move:
      toolkit.take(event);
      moveTo(event);
      break;
    case CanvasEvent::Kind::Resize:
      viewsChanged = true;
      placeClouds();
      break;
    case CanvasEvent::Kind::Redraw:
      itemsChanged = hudChanged = true;
      break;
    case CanvasEvent::Kind::Tick:
      tick();
      break;
  }
  if (quit) return false;
  const bool passing = event.kind == CanvasEvent::Kind::Move || event.kind == CanvasEvent::Kind::Wheel;
  if (!passing || clock.seconds() - lastPicture > std::max(kBetweenPictures, pictureSeconds)) {
    flush(false);
    for (const std::string& problem : problems()) warn(problem);  // warns of each only once
    for (const std::string& text : hints) warn(text);
  }
  return true;
}

void ViewSession::State::tick() {
  const double now = clock.seconds();  // before takeWhatIsLoaded(): a frame that arrives now is drawn at any speed
  takeWhatIsLoaded();
  if (!readsAhead && at == wanted && lastPicture > 0) {  // reading ahead must not delay the first picture
    readsAhead = true;
    loader->want(wanted, 1);
  }
  if (playing && at == wanted && now - lastStep >= frameSeconds()) {
    if (wanted + 1 < source->keys().size()) {
      goTo(wanted + 1, 1);
    } else {
      playing = false;
      hudChanged = true;
    }
  }
  const auto expired =
      std::remove_if(notices.begin(), notices.end(), [&](const ViewNotice& n) { return n.until < now; });
  if (expired != notices.end()) {
    notices.erase(expired, notices.end());
    hudChanged = true;
  }
  if (std::string loading = loader->busy(); loading != busy) {
    busy = std::move(loading);
    hudChanged = true;
  }
  // The longer a picture of all points takes, the longer the view must be at rest before it is drawn.
  const double rest = 0.15 + 0.5 * wholeSeconds;
  if (partial && !playing && drag.button == 0 && now - lastChange > rest) flush(true);
}

void ViewSession::State::key(const CanvasEvent& event) {
  const auto meaning = keyMeaning(event.key, event.shift);
  if (!meaning) return;
  acting = meaning->action;
  act(*meaning);
  acting.reset();
}

// Returns the option that the action switches on and off, and the option's name.
std::pair<bool*, const char*> ViewSession::State::switchOf(KeyAction action) {
  switch (action) {
    case KeyAction::ToggleAxes:
      return {&options.axes, "axes"};
    case KeyAction::ToggleRangeRings:
      return {&options.rangeRings, "range rings"};
    case KeyAction::ToggleBoxes:
      if (frame && frame->objects.empty()) return {&instanceBoxes, "boxes about instances' points"};
      return {&options.boxes, "boxes of objects"};
    case KeyAction::ToggleTrajectory:
      if (trajectory.size() < 2) return {};
      return {&options.trajectory, "trajectory"};
    case KeyAction::ToggleDepthEdges:
      return {&options.depthEdges, "depth edges"};
    case KeyAction::ToggleLegends:
      return {&options.legends, "legends"};
    default:
      return {};
  }
}

void ViewSession::State::act(const KeyMeaning& meaning) {
  const auto setLayout = [&](ViewLayout wantedLayout) {
    options.layout = options.layout == wantedLayout ? ViewLayout::One : wantedLayout;
    activeView.reset();
    if (options.layout == ViewLayout::Split && frame && frame->scans.size() == 1) activeView = 1;
    hover.reset();
    arrange();
  };
  const auto resizePoints = [&](double by) {
    options.pointSize = std::clamp(pointSize() + by, 1.0, 20.0);
    placeClouds();
    say(fmt::format("points of {:.0f} px", options.pointSize));
  };
  if (source->isScene()) {
    if (const std::string why = sceneLacks(meaning); !why.empty()) return say(why);
  }
  if (const auto [option, name] = switchOf(meaning.action); option != nullptr) {
    *option = !*option;
    placeGuides();
    viewsChanged = true;
    return say(fmt::format("{} {}", name, *option ? "on" : "off"));
  }
  switch (meaning.action) {
    case KeyAction::NextColor:
      return cycleColor(1);
    case KeyAction::PreviousColor:
      return cycleColor(-1);
    case KeyAction::ColorByNumber:
      return chooseColor(ColorBy(colorNames()[meaning.number]));
    case KeyAction::LowerHighEnd:
    case KeyAction::RaiseHighEnd:
    case KeyAction::LowerLowEnd:
    case KeyAction::RaiseLowEnd:
    case KeyAction::AutomaticScale:
      return changeScale(meaning.action);
    case KeyAction::LargerPoints:
      return resizePoints(1);
    case KeyAction::SmallerPoints:
      return resizePoints(-1);
    case KeyAction::NextBackground: {
      const auto is = std::find(kBackgrounds.begin(), kBackgrounds.end(), options.background);
      options.background = is == kBackgrounds.end() || is + 1 == kBackgrounds.end() ? kBackgrounds.front() : is[1];
      viewsChanged = hudChanged = true;
      return;
    }
    case KeyAction::ToggleTrajectory:
      return say("there is no trajectory");
    case KeyAction::ToggleMesh:
      options.mesh = !options.mesh;
      meshProblem.clear();
      hudChanged = true;
      if (options.mesh) wantMesh();
      return placeMesh();
    case KeyAction::ToggleProjection: {
      OrbitCamera other = camera;
      other.orthographic = !other.orthographic;
      setCamera(other);
      return say(other.orthographic ? "orthographic" : "perspective");
    }
    case KeyAction::ChaseView:
      return setCamera(preset(View::Chase));
    case KeyAction::DriverView:
      return setCamera(preset(View::Driver));
    case KeyAction::AboveView:
      setCamera(preset(View::Above));
      if (source->isScene()) tellWhatEncloses();
      return;
    case KeyAction::NextPreset:
      if (camera == preset(View::Chase)) return setCamera(preset(View::Driver));
      return setCamera(preset(camera == preset(View::Driver) ? View::Above : View::Chase));
    case KeyAction::TurnAbout:
      return turnAbout();
    case KeyAction::ResetView:
      return setCamera(firstCamera());
    case KeyAction::NextFrame:
      return stepBy(1);
    case KeyAction::PreviousFrame:
      return stepBy(-1);
    case KeyAction::TenFramesOn:
      return stepBy(10);
    case KeyAction::TenFramesBack:
      return stepBy(-10);
    case KeyAction::FirstFrame:
      return goTo(0, 1);
    case KeyAction::LastFrame:
      return goTo(source->keys().size() - 1, -1);
    case KeyAction::Play:
      return togglePlaying();
    case KeyAction::Slower:
      return changeSpeed(-1);
    case KeyAction::Faster:
      return changeSpeed(1);
    case KeyAction::GoTo:
      if (options.bare) return;  // there is no panel to type into
      help = false;              // the help window would receive the keys
      prompt = "";
      hudChanged = true;
      return;
    case KeyAction::ToggleOverlay:
      if (frame && frame->scans.size() < 2) return say("the sample has no other scan to lay over it");
      return setLayout(ViewLayout::Overlay);
    case KeyAction::ToggleSplit:
      return setLayout(ViewLayout::Split);
    case KeyAction::NextView:
      if (viewCount() < 2) return say("there is one view only; s splits it");
      // Goes through the views one by one, then selects all of them.
      activeView = activeView ? *activeView + 1 : 0;
      if (*activeView >= viewCount()) activeView.reset();
      if (!activeView && frame->scans.size() == 1) activeView = 0;
      itemsChanged = hudChanged = true;
      return makeStrip();
    case KeyAction::NextScan:
      if (!frame || frame->scans.size() < 2) return say("the sample has no other scan");
      scanName = frame->scans[(shownScan() + 1) % frame->scans.size()].name;
      if (options.layout != ViewLayout::One) options.layout = ViewLayout::One;
      return arrange();
    case KeyAction::ToggleWorld:
      return toggleWorld();
    case KeyAction::ShowAllClasses:
      filter.showAll();
      aloneInstances.clear();
      hiddenScans.clear();
      return applyFilter();
    case KeyAction::InstanceAlone:
      return toggleAlone();
    case KeyAction::Measure:
      return toggleMeasuring();
    case KeyAction::ToggleRangeImage:
      options.rangeImage = !options.rangeImage;
      viewsChanged = true;
      return makeStrip();
    case KeyAction::ToggleStripOrder:
      options.stripOrder = options.stripOrder == StripOrder::Outward ? StripOrder::Sensor : StripOrder::Outward;
      options.rangeImage = true;
      viewsChanged = true;
      return makeStrip();
    case KeyAction::SavePicture:
      return savePicture();
    case KeyAction::ToggleHelp:
      help = !help;
      hudChanged = hoverChanged = true;
      return;
    case KeyAction::Escape:
      return escape();
    case KeyAction::Quit:
      quit = true;
      return;
    case KeyAction::ToggleAxes:
    case KeyAction::ToggleRangeRings:
    case KeyAction::ToggleBoxes:
    case KeyAction::ToggleDepthEdges:
    case KeyAction::ToggleLegends:
      return;  // handled by switchOf() above
  }
}

void ViewSession::State::escape() {
  hudChanged = true;
  if (toolkit.closeMenus()) return;
  if (help) {
    help = false;
  } else if (measuring || !ends.empty()) {
    toggleMeasuring();
  } else if (pinned) {
    pinned.reset();
  } else if (!aloneInstances.empty()) {
    toggleAlone();
  } else if (playing) {
    playing = false;
  } else {
    say("q quits");
  }
}

void ViewSession::State::savePicture() {
  notices.clear();
  hudChanged = true;
  flush(true);
  try {
    say(fmt::format("saved {}; its camera: {}", savePictureOf(canvas).string(), cameraText()));
  } catch (const Error& e) {
    say(e.what());
    warn(e.what());
  }
}

}  // namespace scanmill
