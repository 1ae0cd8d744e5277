// Computes the camera of each preset and the initial camera, and writes the current camera as text.

#include <algorithm>
#include <cmath>

#include "viewer/window/scenery.h"

namespace scanmill {

namespace {

// Moves the camera until the picture of the box is centred and nearly fills the canvas. Starts with frame() and
// improves the result in steps, since in perspective near parts of the box appear larger than far parts.
void fillWith(OrbitCamera& camera, const Box& box, int width, int height) {
  constexpr int kSteps = 16;
  constexpr double kFilled = 0.9;
  camera.frame(box);
  for (int step = 0; step < kSteps; ++step) {
    const ViewCamera view = camera.camera(width, height);
    double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
    for (int corner = 0; corner < 8; ++corner) {
      const Projected p = view.project({corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                                        corner & 4 ? box.high.z : box.low.z});
      if (!(p.depth >= view.nearest)) return;
      left = std::min(left, p.x);
      right = std::max(right, p.x);
      top = std::min(top, p.y);
      bottom = std::max(bottom, p.y);
    }
    camera.pan((width - left - right) / 2, (height - top - bottom) / 2, width, height);
    const double share = std::max((right - left) / width, (bottom - top) / height) / kFilled;
    camera.distance *= std::clamp(share, 0.8, 1.25);
  }
}

}  // namespace

OrbitCamera Scenery::preset(View view) const {
  OrbitCamera chosen = presetCamera(view);
  if (context_.source->isScene()) {
    // The view from above shows the complete scene, or only ViewMesh::core if the scene is much larger than its core.
    constexpr double kFarAway = 3;
    if (!mesh) return chosen;
    const auto longest = [](const Box& box) { return box.empty() ? 0 : length(box.high - box.low); };
    const bool whole = view == View::Above && longest(mesh->bounds) < kFarAway * longest(mesh->core);
    fillWith(chosen, whole ? mesh->bounds : mesh->core, context_.canvas.width(), context_.canvas.height());
  } else if (world && worldFromAnchor) {
    chosen.moveBy(canvasFromWorld * toAffine(*worldFromAnchor));
  }
  return chosen;
}

OrbitCamera Scenery::firstCamera() const {
  const CameraChoice& choice = context_.options.camera;
  if (!context_.source->isScene()) return choice.camera;
  if (choice.view) return preset(*choice.view);
  OrbitCamera chosen = choice.camera;
  if (choice.placed) chosen.target = canvasFromWorld * chosen.target;
  return chosen;
}

void Scenery::lookAtCloseUp() {
  const std::optional<CloseUp>& closeUp = context_.options.closeUp;
  if (!closeUp || framed_ || clouds_.list.empty()) return;
  framed_ = true;
  constexpr double kFilled = 0.85;  // fraction of the picture's shorter side that the ball fills; panels need the rest
  const int width = context_.canvas.width();
  const int height = context_.canvas.height();
  OrbitCamera chosen = camera;
  chosen.orthographic = false;
  chosen.target = clouds_.list.front().canvasFromScan * closeUp->at;
  // Slope of the tangents from the eye to the ball, relative to the line of sight.
  const double slope = kFilled * std::min(width, height) / 2 / chosen.camera(width, height).focal;
  chosen.distance = closeUp->within * std::hypot(1, 1 / slope);
  setCamera(chosen);
}

std::string Scenery::cameraText() const {
  OrbitCamera told = camera;
  if (context_.source->isScene()) told.target = inverse(canvasFromWorld) * told.target;
  return told.text();
}

void Scenery::setCamera(const OrbitCamera& newCamera) {
  if (newCamera == camera) return;
  camera = newCamera;
  context_.changes.views = context_.changes.panels = context_.changes.hover = true;
}

}  // namespace scanmill
