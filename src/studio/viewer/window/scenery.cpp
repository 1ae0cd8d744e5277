#include "viewer/window/scenery.h"

#include <algorithm>
#include <cmath>

namespace scanmill {

namespace {

constexpr Rgb kRingColor{120, 130, 150};
constexpr Rgb kTrackColor{255, 214, 64};

}  // namespace

Scenery::Scenery(SessionContext& context, Clouds& clouds)
    : camera(context.options.camera.camera),
      meshItem(context.canvas, kMeshItem),
      vehicleItem(context.canvas, kVehicleItem),
      context_(context),
      clouds_(clouds) {
  findRoadUsers();
}

void Scenery::takeFrame(std::size_t index) {
  worldFromAnchor.reset();
  for (const ViewScan& scan : context_.frame->scans) {
    if (scan.worldFromSensor && !worldFromAnchor) worldFromAnchor = scan.worldFromSensor;
  }
  trajectory = context_.source->trajectory(index);
  place();
}

// Computes canvasFromWorld.
void Scenery::place() {
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
Affine Scenery::canvasFromScan(const ViewScan& scan) const {
  if (!worldFromAnchor) return {};
  return canvasFromWorld * toAffine(scan.worldFromSensor.value_or(*worldFromAnchor));
}

void Scenery::placeClouds() {
  content_.clear();
  ground = {};
  for (std::size_t k = 0; k < clouds_.list.size(); ++k) {
    ShownCloud& cloud = clouds_.list[k];
    const ViewScan& viewed = context_.frame->scans[cloud.scan];
    cloud.canvasFromScan = canvasFromScan(viewed);
    context_.canvas.setLook(cloudItem(k),
                            {.canvasFromItem = cloud.canvasFromScan, .size = pointSize(), .views = 1U << cloud.view});
    double radius = 0;
    for (const Vec3f& p : viewed.places()) {
      if (isFinite(p)) radius = std::max(radius, double{dot(p, p)});
    }
    content_.push_back({cloud.canvasFromScan.translation, std::sqrt(radius)});
  }
  if (!clouds_.list.empty()) {
    const ShownCloud& first = clouds_.list.front();
    ground = first.canvasFromScan.translation;
    ground.z = groundHeight(context_.frame->scans[first.scan].places(), first.canvasFromScan);
  }
  context_.changes.items = context_.changes.panels = true;
}

void Scenery::placeGuides() {
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

void Scenery::setLines(ItemId item, const LineSet& lines, double width) {
  context_.canvas.setLines(item, lines.ends, lines.colors);
  context_.canvas.setLook(item, {.size = width, .views = (1U << clouds_.viewCount()) - 1});
}

std::optional<Affine> Scenery::toggleWorld() {
  if (!worldFromAnchor) return {};
  const Affine before = canvasFromWorld;
  world = !world;
  place();
  const Affine newFromOld = canvasFromWorld * inverse(before);
  OrbitCamera moved = camera;
  moved.moveBy(newFromOld);
  setCamera(moved);
  placeClouds();
  placeGuides();
  placeMeshLook();
  return newFromOld;
}

double Scenery::farthest(const Vec3d& eye) const {
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

double Scenery::pointSize() const {
  if (context_.options.pointSize > 0) return context_.options.pointSize;
  return std::max(2.0, std::round(context_.canvas.height() / 450.0));
}

}  // namespace scanmill
