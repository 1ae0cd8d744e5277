#include "viewer/window/session.h"

#include <fmt/core.h>

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

}  // namespace scanmill
