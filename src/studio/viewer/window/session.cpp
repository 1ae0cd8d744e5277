#include "viewer/window/session.h"

#include <fmt/core.h>

#include <algorithm>

#include "viewer/window/session_state.h"

namespace scanmill {

ViewSession::State::State(std::shared_ptr<const FrameSource> frames, std::unique_ptr<FrameLoader> frameLoader,
                          Canvas& drawnOn, const ViewOptions& chosen)
    : source(std::move(frames)),
      canvas(drawnOn),
      options(chosen),
      camera(chosen.camera.camera),
      loader(std::move(frameLoader)),
      filter(chosen.hidden, chosen.only, source->ontology()),
      aloneInstances(chosen.instances.begin(), chosen.instances.end()),
      toolkit(canvas,
              chosen.still ? letterOfPicture(canvas.width(), canvas.height()) : letterOfWindow(canvas.scale())) {
  for (std::size_t v = 0; v < std::min(options.colors.size(), colors.size()); ++v) colors[v] = options.colors[v];
  for (std::size_t v = 0; v < scales.size(); ++v) {
    if (options.scale && v < options.colors.size() && isNumeric(options.colors[v])) scales[v] = options.scale;
  }
  if (options.scale && options.colors.size() == 1) scales.fill(options.scale);
  if (source->keys().empty()) throw InputError(fmt::format("{}: holds no sample", source->title()));
  if (source->isScene() && !options.colors.empty()) {
    const ColorBy& by = options.colors.front();
    if (const std::string why = sceneLacks(by); !why.empty()) {
      throw InputError(fmt::format("{}: {}", source->title(), why));
    }
    chooseColor(by);
  }
  for (const std::uint16_t id : source->classes()) presentClasses.insert(id);
  classesKnown = !presentClasses.empty();
  seeking = options.sample.empty() && !source->isScene();
  firstWanted = findFrame(*source, options.sample);
  wantFrame(firstWanted, 0);
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
  while (s.at != s.wanted) s.adopt(s.loader->wait(s.wanted));  // adopt() wants another frame if this is unreadable
  if (s.meshOn() && s.meshWanted) {
    auto loaded = s.loader->waitMesh(*s.meshWanted);
    if (loaded != s.mesh) s.takeMesh(std::move(loaded));
  }
  s.busy.clear();
  s.notices.clear();
  s.hudChanged = true;
  s.flush(true);
}

void ViewSession::check() const {
  const State& s = *state_;
  if (s.columnMissing) throw InputError(*s.columnMissing);
  const bool nothing =
      s.source->isScene() ? s.mesh == nullptr || s.mesh->size() == 0 : !s.frame || s.frame->scans.empty();
  if (!nothing) return;
  const auto all = s.problems();
  throw Error(all.empty() ? "nothing could be loaded" : all.front());
}

Image ViewSession::picture() {
  return state_->canvas.read();
}

const OrbitCamera& ViewSession::camera() const {
  return state_->camera;
}

void ViewSession::setCamera(const OrbitCamera& camera) {
  state_->setCamera(camera);
}

std::optional<PickedThing> ViewSession::pick(int x, int y) const {
  state_->refresh();
  auto thing = state_->pick(x, y);
  if (thing) thing = state_->inFull(std::move(*thing));
  return thing;
}

void ViewSession::pin(const PickedThing& thing) {
  state_->pinned = thing;
  state_->hudChanged = true;
}

std::vector<std::string> ViewSession::problems() const {
  return state_->problems();
}

const std::vector<std::string>& ViewSession::hints() const {
  return state_->hints;
}

}  // namespace scanmill
