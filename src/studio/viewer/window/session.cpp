#include "viewer/window/session.h"

#include <fmt/core.h>

#include <algorithm>
#include <limits>

#include "viewer/window/session_state.h"

namespace scanmill {

namespace {

// Returns the source. Throws InputError if it has no frame.
std::shared_ptr<const FrameSource> notEmpty(std::shared_ptr<const FrameSource> source) {
  if (source->keys().empty()) throw InputError(fmt::format("{}: holds no sample", source->title()));
  return source;
}

// Throws InputError if no point of the frame's scans is in the close-up. The message states the nearest point.
void requirePoints(const ViewFrame& frame, const CloseUp& closeUp) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  double distance = kNone;
  Vec3d nearest;
  for (const ViewScan& viewed : frame.scans) {
    for (const Vec3f& p : viewed.scan.position) {
      const double here = length(Vec3d(p) - closeUp.at);
      if (!(here < distance)) continue;
      distance = here;
      nearest = Vec3d(p);
    }
  }
  if (distance <= closeUp.within) return;
  const auto text = [](const Vec3d& v) { return fmt::format("{:.4g},{:.4g},{:.4g}", v.x, v.y, v.z); };
  throw InputError(fmt::format(
      "no point is within {:.4g} m of {}: {}", closeUp.within, text(closeUp.at),
      distance == kNone ? std::string("there is none at all")
                        : fmt::format("the nearest is {:.4g} m from there, at {}; take another --at or a larger "
                                      "--within",
                                      distance, text(nearest))));
}

}  // namespace

ViewSession::State::State(std::shared_ptr<const FrameSource> frames, std::unique_ptr<FrameLoader> loader,
                          Canvas& canvas, const ViewOptions& chosen)
    : context(notEmpty(std::move(frames)), canvas, chosen),
      playback(context.source, std::move(loader), chosen.sample),
      clouds(context),
      scenery(context, clouds),
      pointer(context, clouds, scenery),
      panels(context, playback, clouds, scenery, pointer) {
  if (context.source->isScene() && !chosen.colors.empty()) {
    const ColorBy& by = chosen.colors.front();
    if (const std::string why = sceneLacks(by); !why.empty()) {
      throw InputError(fmt::format("{}: {}", context.source->title(), why));
    }
    chooseColor(by);
  }
  takeWhatIsLoaded();
}

ViewSession::ViewSession(const std::shared_ptr<const FrameSource>& source, Canvas& canvas, const ViewOptions& options)
    : ViewSession(source, std::make_unique<FrameLoader>(source), canvas, options) {}

ViewSession::ViewSession(std::shared_ptr<const FrameSource> source, std::unique_ptr<FrameLoader> loader, Canvas& canvas,
                         const ViewOptions& options)
    : state_(std::make_unique<State>(std::move(source), std::move(loader), canvas, options)) {}

ViewSession::~ViewSession() = default;

bool ViewSession::handle(const CanvasEvent& event) {
  return state_->handle(event);
}

void ViewSession::settle() {
  State& s = *state_;
  if (auto loaded = s.playback.take(s.context.drawing.now(), true)) s.showFrame(std::move(loaded));
  if (s.scenery.meshOn() && s.scenery.meshWanted) {
    auto loaded = s.playback.loader().waitMesh(*s.scenery.meshWanted);
    if (loaded != s.scenery.mesh) s.takeMesh(std::move(loaded));
  }
  s.playback.clearBusy();
  s.context.notices.clear();
  s.context.changes.panels = true;
  s.flush(true);
}

void ViewSession::check() const {
  const State& s = *state_;
  if (s.clouds.columnMissing) throw InputError(*s.clouds.columnMissing);
  const auto& frame = s.context.frame;
  const auto& mesh = s.scenery.mesh;
  const bool nothing =
      s.context.source->isScene() ? mesh == nullptr || mesh->size() == 0 : !frame || frame->scans.empty();
  if (!nothing && s.context.filter.closeUp) return requirePoints(*frame, *s.context.filter.closeUp);
  if (!nothing) return;
  const auto all = s.problems();
  throw Error(all.empty() ? "nothing could be loaded" : all.front());
}

Image ViewSession::picture() {
  return state_->context.canvas.read();
}

const OrbitCamera& ViewSession::camera() const {
  return state_->scenery.camera;
}

void ViewSession::setCamera(const OrbitCamera& camera) {
  state_->scenery.setCamera(camera);
}

std::optional<PickedThing> ViewSession::pick(int x, int y) const {
  state_->refresh();
  auto thing = state_->pointer.pick(x, y);
  if (thing) thing = state_->pointer.inFull(std::move(*thing));
  return thing;
}

void ViewSession::pin(const PickedThing& thing) {
  state_->pointer.pinned = thing;
  state_->context.changes.panels = true;
}

std::vector<std::string> ViewSession::problems() const {
  return state_->problems();
}

const std::vector<std::string>& ViewSession::hints() const {
  return state_->context.hints;
}

void ViewSession::State::goTo(std::size_t target, int step) {
  playback.goTo(target, step);
  context.changes.panels = true;
  takeWhatIsLoaded();
}

void ViewSession::State::stepBy(std::ptrdiff_t count) {
  if (!playback.stepBy(count)) return context.say(count > 0 ? "this is the last frame" : "this is the first frame");
  context.changes.panels = true;
  takeWhatIsLoaded();
}

void ViewSession::State::togglePlaying() {
  if (!playback.playing() && playback.count() < 2) return context.say("there is one frame only");
  playback.togglePlaying(context.drawing.now());
  context.changes.panels = true;
  takeWhatIsLoaded();
}

void ViewSession::State::changeSpeed(int step) {
  if (playback.count() < 2) return context.say("there is one frame only");
  playback.changeSpeed(step);
  context.say("playing speed: " + playback.speedText());
}

void ViewSession::State::hintAtNames() {
  if (context.source->ontology() != nullptr) return;
  const bool labelled =
      std::ranges::any_of(context.frame->scans, [](const ViewScan& scan) { return !scan.scan[kLabel].empty(); });
  if (!labelled) return;
  context.hint(
      "the classes have no names here: a scan or shard away from its dataset does not know them; "
      "open it with --ontology labels/scanmill.yaml, or the file of its own classes");
}

void ViewSession::State::takeWhatIsLoaded() {
  if (auto loaded = playback.take(context.drawing.now())) showFrame(std::move(loaded));
  if (scenery.meshOn() && scenery.meshWanted) {
    auto loaded = playback.loader().mesh(*scenery.meshWanted);
    if (loaded && loaded != scenery.mesh) takeMesh(std::move(loaded));
  }
}

void ViewSession::State::showFrame(std::shared_ptr<const ViewFrame> loaded) {
  context.frame = std::move(loaded);
  if (!playback.substituted().empty()) context.hint(playback.substituted());
  hintAtNames();
  pointer.leaveFrame();
  scenery.takeFrame(*playback.current());
  arrange();
  scenery.lookAtFirstPoints();
  if (scenery.meshOn()) wantMesh();
  if (scenery.meshItem.there() != scenery.meshSeen()) placeMesh();
}

// Updates everything that depends on the frame and the layout.
void ViewSession::State::arrange() {
  clouds.arrange();
  scenery.placeClouds();
  applyFilter();
  scenery.placeGuides();
  pointer.placeMeasure();
  scenery.placeMeshLook();
}

void ViewSession::State::applyFilter() {
  clouds.applyFilter();
  scenery.applyFilter();
  scenery.placeBoxes();
  pointer.hover.reset();
}

void ViewSession::State::wantMesh() {
  if (!playback.current()) return;
  std::string why;
  const auto choice = context.source->scene(*playback.current(), why);
  scenery.meshProblem.clear();
  if (!choice) {
    scenery.meshWanted.reset();
    if (scenery.mesh) takeMesh(nullptr);
    scenery.meshProblem = context.source->isScene() ? why : "no mesh: " + why;
    return;
  }
  scenery.meshWanted = choice;
  playback.loader().wantMesh(*choice);
  takeWhatIsLoaded();
}

void ViewSession::State::takeMesh(std::shared_ptr<const ViewMesh> loaded) {
  scenery.takeMesh(std::move(loaded));
  pointer.hover.reset();
}

void ViewSession::State::placeMesh() {
  scenery.placeMesh();
  pointer.hover.reset();
}

std::vector<std::string> ViewSession::State::problems() const {
  std::vector<std::string> all;
  if (context.frame) all = context.frame->problems;
  for (const std::string* one :
       {&clouds.colorProblem, &scenery.meshProblem, &clouds.stripProblem, &clouds.instanceProblem}) {
    if (!one->empty() && std::ranges::find(all, *one) == all.end()) all.push_back(*one);
  }
  return all;
}

void ViewSession::State::refresh() {
  panels.arrange();
  context.drawing.setViews(panels.views());
}

void ViewSession::State::updateHover() {
  const bool covered = panels.help || panels.toolkit.hasPointer();
  pointer.updateHover(covered, panels.overStrip && !panels.help ? std::optional(panels.stripRect()) : std::nullopt);
}

void ViewSession::State::flush(bool whole) {
  const double began = context.drawing.now();
  const Changes& changes = context.changes;
  if (changes.views || changes.items || changes.panels) refresh();
  if (changes.items && pointer.pinned && !pointer.isShown(*pointer.pinned)) pointer.pinned.reset();
  // When the picture changes, another point may be under the pointer, even if the pointer rests.
  if (changes.hover || changes.views || changes.items) {
    const bool held = panels.toolkit.hasPointer();
    runPanels();
    if (held || panels.toolkit.hasPointer())
      context.changes.panels = true;  // panels highlight their parts under the pointer
    updateHover();
  }
  pointer.lightInstance();
  pointer.placeBeam();
  if (changes.views || changes.items || changes.panels || changes.light) {
    panels.addLabels();
    runPanels();
    runPanels();  // sizes that depend on contents are known in the second run
  }
  std::uint64_t points = 0;
  for (const ShownCloud& cloud : clouds.list) points += cloud.visible;
  context.drawing.draw(whole, points, clouds.list.size(), began);
}

}  // namespace scanmill
