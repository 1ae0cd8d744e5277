// Computes the camera of each preset and the initial camera, and writes the current camera as text.

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "viewer/window/scenery.h"

namespace scanmill {

namespace {

// Returns points that have the extent of the mesh's part in the box: corners of triangles or, if they are many, of
// boxes about some triangles each. Returns the corners of the box if hardly any point is in it, as if it cuts large
// triangles.
std::vector<Vec3d> pointsIn(const ViewMesh& mesh, const Box& box) {
  constexpr std::size_t kMany = 3'000'000;
  std::vector<Vec3d> points;
  const auto within = [](double low, double at, double high) { return low <= at && at <= high; };
  const auto add = [&](const Vec3d& p) {
    const bool inside = within(box.low.x, p.x, box.high.x) && within(box.low.y, p.y, box.high.y);
    if (inside && within(box.low.z, p.z, box.high.z)) points.push_back(p);
  };
  const auto addCorners = [&](const Box& of) {
    for (int corner = 0; corner < 8; ++corner) {
      add({corner & 1 ? of.high.x : of.low.x, corner & 2 ? of.high.y : of.low.y, corner & 4 ? of.high.z : of.low.z});
    }
  };
  if (mesh.corners.size() > kMany) {
    for (const Box& part : mesh.boxes) addCorners(part);
  } else {
    for (const Vec3f& corner : mesh.corners) add(Vec3d(corner));
  }
  if (points.size() < 8) addCorners(box);
  return points;
}

// Moves the camera, without turning it, so that the points are centred and nearly fill the canvas. Returns true if they
// fill its height, and false if they fill its width. `middle`: the point at whose depth the camera's target is.
bool fillWith(OrbitCamera& camera, const std::vector<Vec3d>& points, const Vec3d& middle, int width, int height) {
  constexpr double kFilled = 0.9;
  const ViewCamera view = camera.camera(width, height);
  // Slopes of the lines of sight to the sides of the filled part of the picture, to the right and downwards (m per m of
  // depth); 0 if the camera is orthographic.
  const double slope = view.orthographic ? 0 : kFilled / (2 * view.focal);
  const std::array<Vec3d, 2> axes{view.right, view.down};
  const std::array<double, 2> slopes{slope * width, slope * height};
  // The planes through the sides of the filled part that touch the points, as places on the axes at depth 0.
  std::array<double, 2> first{1e30, 1e30};
  std::array<double, 2> last{-1e30, -1e30};
  for (const Vec3d& point : points) {
    for (std::size_t k = 0; k < 2; ++k) {
      const double spread = slopes[k] * dot(point, view.forward);
      first[k] = std::min(first[k], dot(point, axes[k]) + spread);
      last[k] = std::max(last[k], dot(point, axes[k]) - spread);
    }
  }
  const double depth = dot(middle, view.forward);
  camera.target = axes[0] * ((first[0] + last[0]) / 2) + axes[1] * ((first[1] + last[1]) / 2) + view.forward * depth;
  if (view.orthographic) {
    const std::array<double, 2> shares{(last[0] - first[0]) / width, (last[1] - first[1]) / height};
    camera.distance *= std::max(shares[0], shares[1]) * view.focal / kFilled;
    return shares[1] > shares[0];
  }
  // Opposite planes intersect at the eye's depth.
  const std::array<double, 2> eyes{(first[0] - last[0]) / (2 * slopes[0]), (first[1] - last[1]) / (2 * slopes[1])};
  camera.distance = depth - std::min(eyes[0], eyes[1]);
  return eyes[1] < eyes[0];
}

}  // namespace

OrbitCamera Scenery::preset(View view) const {
  OrbitCamera chosen = presetCamera(view);
  if (context_.source->isScene()) {
    // Shows the complete scene, or only ViewMesh::core if the scene is much larger than its core. Scenes often have
    // ground around them, which only the view from above shows.
    const double kFarAway = view == View::Above ? 3 : 1.2;
    if (!mesh) return chosen;
    const auto longest = [](const Box& box) { return box.empty() ? 0 : length(box.high - box.low); };
    const bool whole = longest(mesh->bounds) < kFarAway * longest(mesh->core);
    const Box& shown = whole ? mesh->bounds : mesh->core;
    const std::vector<Vec3d> points = pointsIn(*mesh, shown);
    const auto fill = [&] {
      return fillWith(chosen, points, shown.center(), context_.canvas.width(), context_.canvas.height());
    };
    // A flat place leaves much of the picture empty unless the camera looks down steeply.
    while (!fill() && view == View::Chase && chosen.pitch < radians(45)) chosen.pitch += radians(5);
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
  if (context_.options.camera.view) chosen.distance = closeUp->within * std::hypot(1, 1 / slope);
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
