#include "viewer/window/scene_view.h"

#include <algorithm>
#include <cmath>

namespace scanmill {

namespace {

constexpr Rgb kRingColor{120, 130, 150};
constexpr Rgb kTrackColor{255, 214, 64};

// Returns the corners of the boxes of parts that are in the box, or its own corners if there are hardly any.
std::vector<Vec3d> pointsIn(const ViewMesh& mesh, const Box& box) {
  std::vector<Vec3d> points;
  const auto addCorners = [&](const Box& of) {
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3d p{corner & 1 ? of.high.x : of.low.x, corner & 2 ? of.high.y : of.low.y,
                    corner & 4 ? of.high.z : of.low.z};
      Box grown = box;
      grown.add(p);
      if (grown.low == box.low && grown.high == box.high) points.push_back(p);
    }
  };
  for (const Box& part : mesh.partBoxes) addCorners(part);
  if (points.size() < 8) addCorners(box);
  return points;
}

}  // namespace

SceneView::SceneView(SessionContext& context, ShownClouds& clouds)
    : camera(context.options.camera.camera),
      meshItem(context.canvas, kMeshItem),
      vehicleItem(context.canvas, kVehicleItem),
      context_(context),
      clouds_(clouds) {
  findRoadUsers();
}

void SceneView::takeFrame(std::size_t index) {
  worldFromAnchor.reset();
  for (const ViewScan& scan : context_.frame->scans) {
    if (scan.worldFromSensor && !worldFromAnchor) worldFromAnchor = scan.worldFromSensor;
  }
  trajectory = context_.source->trajectory(index);
  computeCanvasFrame();
}

// Computes canvasFromWorld.
void SceneView::computeCanvasFrame() {
  instancesOf_.reset();  // the cached boxes of instances are in the old canvas frame
  if (context_.source->isScene()) {
    canvasFromWorld = mesh ? Affine{{}, -mesh->origin} : Affine{};
  } else if (!worldFromAnchor) {
    canvasFromWorld = {};
  } else if (world) {
    canvasFromWorld = {{}, -(trajectory.empty() ? worldFromAnchor->translation : trajectory.front().translation)};
  } else {
    // The z axis of the canvas frame is vertical, even if the sensor is tilted.
    const Vec3d ahead = toMatrix(worldFromAnchor->rotation).x;
    const double yaw = std::hypot(ahead.x, ahead.y) > 1e-6 ? std::atan2(ahead.y, ahead.x) : 0;
    canvasFromWorld = inverse(toAffine(Pose{fromYawPitchRoll(yaw, 0, 0), worldFromAnchor->translation}));
  }
}

// Returns the pose of a scan in the canvas frame. A scan without a pose, such as a single file that is shown with a
// dataset, gets the pose worldFromAnchor.
Affine SceneView::canvasFromScan(const ViewScan& scan) const {
  if (!worldFromAnchor) return {};
  return canvasFromWorld * toAffine(scan.worldFromSensor.value_or(*worldFromAnchor));
}

void SceneView::placeClouds() {
  content_.clear();
  ground = {};
  for (std::size_t k = 0; k < clouds_.list.size(); ++k) {
    ShownCloud& cloud = clouds_.list[k];
    const ViewScan& viewed = clouds_.scanOf(cloud);
    cloud.canvasFromScan = canvasFromScan(viewed);
    context_.canvas.setLook(cloudItem(k),
                            {.canvasFromItem = cloud.canvasFromScan, .size = pointSize(), .views = 1U << cloud.view});
    double radius = 0;
    for (const Vec3f& p : viewed.drawnPositions()) {
      if (isFinite(p)) radius = std::max(radius, double{dot(p, p)});
    }
    content_.push_back({cloud.canvasFromScan.translation, std::sqrt(radius)});
  }
  if (!clouds_.list.empty()) {
    const ShownCloud& first = clouds_.list.front();
    ground = first.canvasFromScan.translation;
    ground.z = groundHeight(clouds_.scanOf(first).drawnPositions(), first.canvasFromScan);
  }
  context_.changes.items = context_.changes.panels = true;
}

void SceneView::placeGuides() {
  LineSet axes;
  if (context_.options.axes && context_.source->isScene()) addAxes(axes, canvasFromWorld, 2);
  if (context_.options.axes) {
    for (const ShownCloud& cloud : clouds_.list) addAxes(axes, cloud.canvasFromScan, 1);
  }
  setLines(kAxesItem, axes, 2);
  placeVehicle();
  LineSet rings;
  if (context_.options.rangeRings && !clouds_.list.empty()) addRangeRings(rings, ground, kRingColor);
  setLines(kRangeRingsItem, rings, 1);
  LineSet track;
  if (context_.options.trajectory && worldFromAnchor && trajectory.size() > 1) {
    std::vector<Vec3d> places;
    std::size_t current = 0;
    for (const Pose& pose : trajectory) {
      const auto away = [&](std::size_t i) { return length(trajectory[i].translation - worldFromAnchor->translation); };
      if (away(places.size()) < away(current)) current = places.size();
      places.push_back(canvasFromWorld * pose.translation);
    }
    addTrack(track, places, current, kTrackColor);
  }
  setLines(kTrackItem, track, 2);
  placeBoxes();
  context_.changes.items = context_.changes.panels = true;
}

void SceneView::setLines(ItemId item, const LineSet& lines, double width) {
  context_.canvas.setLines(item, lines.ends, lines.colors);
  context_.canvas.setLook(item, {.size = width, .views = (1U << clouds_.viewCount()) - 1});
}

std::optional<Affine> SceneView::toggleWorld() {
  if (!worldFromAnchor) return {};
  const Affine before = canvasFromWorld;
  world = !world;
  computeCanvasFrame();
  const Affine newFromOld = canvasFromWorld * inverse(before);
  OrbitCamera moved = camera;
  moved.moveBy(newFromOld);
  setCamera(moved);
  placeClouds();
  placeGuides();
  placeMeshLook();
  return newFromOld;
}

double SceneView::farthest(const Vec3d& eye) const {
  constexpr double kLeast = 20;
  double far = kLeast;
  const auto reach = [&](const Vec3d& center, double radius) { far = std::max(far, length(center - eye) + radius); };
  for (const ContentBall& ball : content_) reach(ball.center, ball.radius + 1);
  if (context_.options.rangeRings && !content_.empty()) reach(ground, kRingRadii.back());
  if (context_.options.trajectory && worldFromAnchor) {
    for (const Pose& pose : trajectory) reach(canvasFromWorld * pose.translation, 1);
  }
  if (mesh && meshOn() && !mesh->bounds.empty()) {
    const Box& box = mesh->bounds;
    reach(canvasFromWorld * (mesh->origin + box.center()), length(box.high - box.low) / 2);
  }
  return far;
}

double SceneView::pointSize() const {
  if (context_.options.pointSize > 0) return context_.options.pointSize;
  return std::max(2.0, std::round(context_.canvas.height() / 450.0));
}

OrbitCamera SceneView::preset(View view) const {
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
  return chosen.seeing(pointsOnCanvas(), view, context_.canvas.width(), context_.canvas.height());
}

// Returns the places of the shown scans' finite points, or of some of them if they are many.
std::vector<Vec3d> SceneView::pointsOnCanvas() const {
  constexpr std::size_t kEnough = 50'000;
  std::vector<Vec3d> places;
  for (const ShownCloud& cloud : clouds_.list) {
    const std::vector<Vec3f>& all = clouds_.scanOf(cloud).drawnPositions();
    for (std::size_t i = 0; i < all.size(); i += all.size() / kEnough + 1) {
      if (isFinite(all[i])) places.push_back(cloud.canvasFromScan * Vec3d(all[i]));
    }
  }
  return places;
}

OrbitCamera SceneView::firstCamera() const {
  const CameraChoice& choice = context_.options.camera;
  if (choice.view && !context_.options.closeUp) return preset(*choice.view);
  OrbitCamera chosen = choice.camera;
  if (choice.placed && context_.source->isScene()) chosen.target = canvasFromWorld * chosen.target;
  return chosen;
}

void SceneView::lookAtFirstPoints() {
  const std::optional<CloseUp>& closeUp = context_.options.closeUp;
  if (framed_ || clouds_.list.empty()) return;
  framed_ = !pointsOnCanvas().empty();
  if (!closeUp) return setCamera(firstCamera());
  constexpr double kFilled = 0.85;  // fraction of the picture's shorter side that the ball fills; panels need the rest
  const int width = context_.canvas.width();
  const int height = context_.canvas.height();
  OrbitCamera chosen = camera;
  chosen.orthographic = false;
  // The ball is in the frames of the points' own columns. The camera looks at where its points are on the canvas.
  const ViewScan& scan = clouds_.scanOf(clouds_.list.front());
  Vec3d moved;
  double held = 0;
  for (std::size_t i = 0; i < scan.placed.size(); ++i) {
    if (!closeUp->contains(Vec3d(scan.scan.position[i]))) continue;
    moved += Vec3d(scan.placed[i]) - Vec3d(scan.scan.position[i]);
    held += 1;
  }
  chosen.target = clouds_.list.front().canvasFromScan * (closeUp->at + moved * (held > 0 ? 1 / held : 0));
  // Slope of the tangents from the eye to the ball, relative to the line of sight.
  const double slope = kFilled * std::min(width, height) / 2 / chosen.camera(width, height).focal;
  if (context_.options.camera.view) chosen.distance = closeUp->within * std::hypot(1, 1 / slope);
  setCamera(chosen);
}

std::string SceneView::cameraText() const {
  OrbitCamera shown = camera;
  if (context_.source->isScene()) shown.target = inverse(canvasFromWorld) * shown.target;
  return shown.text();
}

void SceneView::setCamera(const OrbitCamera& newCamera) {
  if (newCamera == camera) return;
  camera = newCamera;
  context_.changes.views = context_.changes.panels = context_.changes.hover = true;
}

}  // namespace scanmill
