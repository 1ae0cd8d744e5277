// Computes the camera of each preset and the initial camera, and writes the current camera as text.

#include <algorithm>
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
    chosen.fillWith(pointsIn(*mesh, shown), shown.center(), view, context_.canvas.width(), context_.canvas.height());
    return chosen;
  }
  if (world && worldFromAnchor) chosen.moveBy(canvasFromWorld * toAffine(*worldFromAnchor));
  return chosen.seeing(placesOnCanvas(), view, context_.canvas.width(), context_.canvas.height());
}

// Returns the places of the shown scans' finite points, or of some of them if they are many.
std::vector<Vec3d> Scenery::placesOnCanvas() const {
  constexpr std::size_t kEnough = 50'000;
  std::vector<Vec3d> places;
  for (const ShownCloud& cloud : clouds_.list) {
    const std::vector<Vec3f>& all = context_.frame->scans[cloud.scan].places();
    for (std::size_t i = 0; i < all.size(); i += all.size() / kEnough + 1) {
      if (isFinite(all[i])) places.push_back(cloud.canvasFromScan * Vec3d(all[i]));
    }
  }
  return places;
}

OrbitCamera Scenery::firstCamera() const {
  const CameraChoice& choice = context_.options.camera;
  if (choice.view && !context_.options.closeUp) return preset(*choice.view);
  OrbitCamera chosen = choice.camera;
  if (choice.placed && context_.source->isScene()) chosen.target = canvasFromWorld * chosen.target;
  return chosen;
}

void Scenery::lookAtFirstPoints() {
  const std::optional<CloseUp>& closeUp = context_.options.closeUp;
  if (framed_ || clouds_.list.empty()) return;
  framed_ = !placesOnCanvas().empty();
  if (!closeUp) return setCamera(firstCamera());
  constexpr double kFilled = 0.85;  // fraction of the picture's shorter side that the ball fills; panels need the rest
  const int width = context_.canvas.width();
  const int height = context_.canvas.height();
  OrbitCamera chosen = camera;
  chosen.orthographic = false;
  // The ball is in the frames of the points' own columns. The camera looks at where its points are on the canvas.
  const ViewScan& scan = context_.frame->scans[clouds_.list.front().scan];
  Vec3d moved;
  double held = 0;
  for (std::size_t i = 0; i < scan.placed.size(); ++i) {
    if (!closeUp->holds(Vec3d(scan.scan.position[i]))) continue;
    moved += Vec3d(scan.placed[i]) - Vec3d(scan.scan.position[i]);
    held += 1;
  }
  chosen.target = clouds_.list.front().canvasFromScan * (closeUp->at + moved * (held > 0 ? 1 / held : 0));
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
