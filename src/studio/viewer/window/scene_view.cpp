#include "viewer/window/scene_view.h"

namespace scanmill {

namespace {

constexpr Rgb kRingColor{120, 130, 150};
constexpr Rgb kTrackColor{255, 214, 64};

// Returns the corners of the mesh's part boxes that are in `box`; if they are fewer than 8, also the corners of `box`.
std::vector<Vec3d> cornersIn(const ViewMesh& mesh, const Box& box) {
  std::vector<Vec3d> corners;
  const auto addCorners = [&](const Box& part) {
    std::ranges::copy_if(part.corners(), std::back_inserter(corners),
                         [&](const Vec3d& corner) { return box.distanceTo(corner) == 0; });
  };
  for (const Box& part : mesh.partBoxes) addCorners(part);
  if (corners.size() < 8) addCorners(box);
  return corners;
}

}  // namespace

SceneView::SceneView(SessionContext& context, ShownClouds& clouds)
    : camera(context.options.camera.camera), context_(context), clouds_(clouds) {
  findRoadUsers();
}

void SceneView::takeFrame(std::size_t index) {
  worldFromAnchor.reset();
  for (const ViewScan& scan : context_.frame->scans) {
    if (!worldFromAnchor) worldFromAnchor = scan.worldFromSensor;
  }
  trajectory = context_.source->trajectory(index);
  computeCanvasFrame();
}

// Computes canvasFromWorld. The origin of the canvas is the mesh's origin for a scene without scans, the start of the
// trajectory if `staysInWorld` is true, otherwise the sensor.
void SceneView::computeCanvasFrame() {
  summarized_.reset();  // the cached boxes of instances are in the old canvas frame
  if (context_.source->isScene()) {
    canvasFromWorld = mesh ? Affine{{}, -mesh->origin} : Affine{};
  } else if (!worldFromAnchor) {
    canvasFromWorld = {};
  } else if (staysInWorld) {
    canvasFromWorld = {{}, -(trajectory.empty() ? worldFromAnchor->translation : trajectory.front().translation)};
  } else {
    // The z axis of the canvas frame is vertical, even if the sensor is tilted.
    const Vec3d ahead = toMatrix(worldFromAnchor->rotation).x;
    const double yaw = std::hypot(ahead.x, ahead.y) > 1e-6 ? std::atan2(ahead.y, ahead.x) : 0;
    canvasFromWorld = inverse(toAffine(Pose{fromYawPitchRoll(yaw, 0, 0), worldFromAnchor->translation}));
  }
}

void SceneView::placeClouds() {
  contents_.clear();
  ground = {};
  for (std::size_t k = 0; k < clouds_.list.size(); ++k) {
    ShownCloud& cloud = clouds_.list[k];
    const ViewScan& viewed = clouds_.scanOf(cloud);
    cloud.canvasFromScan = {};
    // A scan without a pose, such as a single file that is shown with a dataset, gets the pose worldFromAnchor.
    if (worldFromAnchor) {
      cloud.canvasFromScan = canvasFromWorld * toAffine(viewed.worldFromSensor.value_or(*worldFromAnchor));
    }
    context_.canvas.setLook(cloudItem(k),
                            {.canvasFromItem = cloud.canvasFromScan, .size = pointSize(), .views = 1U << cloud.view});
    double radius2 = 0;
    for (const Vec3f& p : viewed.drawnPositions()) {
      if (isFinite(p)) radius2 = std::max(radius2, double{dot(p, p)});
    }
    contents_.push_back({.center = cloud.canvasFromScan.translation, .radius = std::sqrt(radius2)});
  }
  if (!clouds_.list.empty()) {
    const ShownCloud& first = clouds_.list.front();
    ground = first.canvasFromScan.translation;
    ground.z = groundHeight(clouds_.scanOf(first).drawnPositions(), first.canvasFromScan);
  }
  context_.changes.items = context_.changes.panels = true;
}

void SceneView::placeGuides() {
  constexpr double kThin = 1, kThick = 2;  // widths of lines (pixels)
  LineSet axes;
  if (context_.options.axes && context_.source->isScene()) addAxes(axes, canvasFromWorld, 2);
  if (context_.options.axes) {
    for (const ShownCloud& cloud : clouds_.list) addAxes(axes, cloud.canvasFromScan, 1);
  }
  setLines(kAxesItem, axes, kThick);
  placeVehicle();
  LineSet rings;
  if (context_.options.rangeRings && !clouds_.list.empty()) addRangeRings(rings, ground, kRingColor);
  setLines(kRangeRingsItem, rings, kThin);
  LineSet track;
  if (context_.options.trajectory && worldFromAnchor && trajectory.size() > 1) {
    std::vector<Vec3d> positions;
    for (const Pose& pose : trajectory) positions.push_back(canvasFromWorld * pose.translation);
    const auto nearest = std::ranges::min_element(
        trajectory, {}, [&](const Pose& pose) { return length(pose.translation - worldFromAnchor->translation); });
    addTrack(track, positions, static_cast<std::size_t>(nearest - trajectory.begin()), kTrackColor);
  }
  setLines(kTrackItem, track, kThick);
  placeBoxes();
  context_.changes.items = context_.changes.panels = true;
}

void SceneView::setLines(ItemId item, const LineSet& lines, double width) {
  context_.canvas.set(item, ItemKind::Segments, lines.ends, lines.colors);
  context_.canvas.setLook(item, {.size = width, .views = allViews()});
}

std::optional<Affine> SceneView::toggleWorld() {
  if (!worldFromAnchor) return {};
  const Affine before = canvasFromWorld;
  staysInWorld = !staysInWorld;
  computeCanvasFrame();
  const Affine newFromOld = canvasFromWorld * inverse(before);
  changeCamera([&](OrbitCamera& moved) { moved.moveBy(newFromOld); });
  placeClouds();
  placeGuides();
  placeMeshLook();
  return newFromOld;
}

double SceneView::farthest(const Vec3d& eye) const {
  double distance = 20;  // least bound (m)
  const auto include = [&](const Vec3d& center, double radius) {
    distance = std::max(distance, length(center - eye) + radius);
  };
  for (const ContentBall& ball : contents_) include(ball.center, ball.radius + 1);  // 1 m for the axes
  if (context_.options.rangeRings && !contents_.empty()) include(ground, kRingRadii.back());
  if (context_.options.trajectory && worldFromAnchor) {
    for (const Pose& pose : trajectory) include(canvasFromWorld * pose.translation, 1);
  }
  if (mesh && isMeshOn() && !mesh->bounds.empty()) {
    const Box& box = mesh->bounds;
    include(canvasFromWorld * (mesh->origin + box.center()), length(box.high - box.low) / 2);
  }
  return distance;
}

double SceneView::pointSize() const {
  if (context_.options.pointSize > 0) return context_.options.pointSize;
  return std::max(2.0, std::round(context_.canvas.height() / 450.0));
}

OrbitCamera SceneView::preset(View view) const {
  OrbitCamera fitted = presetCamera(view);
  if (context_.source->isScene()) {
    // Shows the complete scene, or only ViewMesh::core if the scene is much larger than its core. Scenes often have
    // ground around them, which only the view from above shows.
    const double largestRatio = view == View::Above ? 3 : 1.2;  // ratio of scene to core (diagonals); chosen by eye
    if (!mesh) return fitted;
    const auto diagonal = [](const Box& box) { return box.empty() ? 0 : length(box.high - box.low); };
    const bool showsAll = diagonal(mesh->bounds) < largestRatio * diagonal(mesh->core);
    const Box& shown = showsAll ? mesh->bounds : mesh->core;
    fitted.fillWith(cornersIn(*mesh, shown), shown.center(), view, context_.canvas.width(), context_.canvas.height());
    return fitted;
  }
  if (staysInWorld && worldFromAnchor) fitted.moveBy(canvasFromWorld * toAffine(*worldFromAnchor));
  const double least = context_.source->samples() ? 1 : kLeastSeen;  // a map is shown in full
  return fitted.seeing(pointsOnCanvas(), view, context_.canvas.width(), context_.canvas.height(), least);
}

// Returns the positions of the shown scans' finite points, or of evenly chosen points if there are many.
std::vector<Vec3d> SceneView::pointsOnCanvas() const {
  constexpr std::size_t kEnough = 50'000;
  std::vector<Vec3d> points;
  for (const ShownCloud& cloud : clouds_.list) {
    const std::vector<Vec3f>& positions = clouds_.scanOf(cloud).drawnPositions();
    for (std::size_t i = 0; i < positions.size(); i += positions.size() / kEnough + 1) {
      if (isFinite(positions[i])) points.push_back(cloud.canvasFromScan * Vec3d(positions[i]));
    }
  }
  return points;
}

OrbitCamera SceneView::firstCamera() const {
  const CameraChoice& choice = context_.options.camera;
  if (choice.view && !context_.options.closeUp) return preset(*choice.view);
  OrbitCamera first = choice.camera;
  if (choice.placed && context_.source->isScene()) first.target = canvasFromWorld * first.target;
  return first;
}

void SceneView::lookAtFirstPoints() {
  const std::optional<CloseUp>& closeUp = context_.options.closeUp;
  if (isFitted || clouds_.list.empty()) return;
  isFitted = !pointsOnCanvas().empty();
  setCamera(closeUp ? closeUpCamera(*closeUp) : firstCamera());
}

// Returns a camera that looks at the ball of the close-up from the direction of `camera`. Unless the user has chosen
// the distance, the ball fills most of the picture.
OrbitCamera SceneView::closeUpCamera(const CloseUp& closeUp) const {
  constexpr double kFilled = 0.85;  // fraction of the picture's shorter side that the ball fills; panels need the rest
  const int width = context_.canvas.width();
  const int height = context_.canvas.height();
  OrbitCamera moved = camera;
  moved.orthographic = false;
  // The ball is in the frame of Scan::position. If points are drawn at ViewScan::placed, the target is the ball's
  // centre, displaced by the mean displacement of the ball's points.
  const ViewScan& scan = clouds_.scanOf(clouds_.list.front());
  Vec3d motionSum;
  double points = 0;
  for (std::size_t i = 0; i < scan.placed.size(); ++i) {
    if (!closeUp.contains(Vec3d(scan.scan.position[i]))) continue;
    motionSum += Vec3d(scan.placed[i]) - Vec3d(scan.scan.position[i]);
    points += 1;
  }
  moved.target = clouds_.list.front().canvasFromScan * (closeUp.center + motionSum * (points > 0 ? 1 / points : 0));
  // Slope of the tangents from the eye to the ball, relative to the line of sight.
  const double slope = kFilled * std::min(width, height) / 2 / moved.camera(width, height).focal;
  if (context_.options.camera.view) moved.distance = closeUp.radius * std::hypot(1, 1 / slope);
  return moved;
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
