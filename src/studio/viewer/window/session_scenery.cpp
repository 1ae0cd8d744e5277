// Places everything except points on the canvas: frames of reference, axes, rings, trajectory, the scene's mesh,
// cameras.

#include <fmt/core.h>

#include <algorithm>

#include "viewer/color_map.h"
#include "viewer/window/session_items.h"
#include "viewer/window/session_state.h"

namespace scanmill {

namespace {

constexpr Rgb kRingColor{120, 130, 150};
constexpr Rgb kTrackColor{255, 214, 64};
constexpr Rgb kMeasureColor{255, 240, 90};

// Frames the box, then moves the camera aside and nearer until the box fills the picture, since in perspective its near
// parts appear larger than its far parts.
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

void ViewSession::State::place() {
  instancesOf.reset();  // the boxes of instances are in the canvas frame
  if (source->isScene()) {
    canvasFromWorld = mesh ? Affine{{}, -mesh->origin} : Affine{};
  } else if (!worldFromAnchor) {
    canvasFromWorld = {};
  } else if (world) {
    canvasFromWorld = {{}, -(trajectory.empty() ? worldFromAnchor->translation : trajectory.front().translation)};
  } else {
    // The canvas frame is level, however the sensor is mounted.
    const Vec3d ahead = toMatrix(worldFromAnchor->rotation).x;
    const double yaw = std::hypot(ahead.x, ahead.y) > 1e-6 ? std::atan2(ahead.y, ahead.x) : 0;
    canvasFromWorld = inverse(toAffine(Pose{fromYawPitchRoll(yaw, 0, 0), worldFromAnchor->translation}));
  }
}

// Returns the pose of a scan. A scan without a pose, such as a file over a dataset, gets the pose of the frame's first
// scan.
Affine ViewSession::State::canvasFromScan(const ViewScan& scan) const {
  if (!worldFromAnchor) return {};
  return canvasFromWorld * toAffine(scan.worldFromSensor.value_or(*worldFromAnchor));
}

void ViewSession::State::placeClouds() {
  content.clear();
  ground = {};
  for (std::size_t k = 0; k < clouds.size(); ++k) {
    ShownCloud& cloud = clouds[k];
    const ViewScan& viewed = frame->scans[cloud.scan];
    cloud.canvasFromScan = canvasFromScan(viewed);
    ItemLook look;
    look.canvasFromItem = cloud.canvasFromScan;
    look.size = pointSize();
    look.views = 1U << cloud.view;
    canvas.setLook(cloudItem(k), look);
    double radius = 0;
    for (const Vec3f& p : viewed.scan.position) {
      if (isFinite(p)) radius = std::max(radius, double{dot(p, p)});
    }
    content.push_back({cloud.canvasFromScan.translation, std::sqrt(radius)});
  }
  if (!clouds.empty()) {
    const ShownCloud& first = clouds.front();
    ground = first.canvasFromScan.translation;
    ground.z = groundHeight(frame->scans[first.scan].scan.position, first.canvasFromScan);
  }
  itemsChanged = hudChanged = true;
}

void ViewSession::State::placeGuides() {
  LineSet axes;
  if (options.axes && source->isScene()) addAxes(axes, canvasFromWorld, 2);
  if (options.axes) {
    for (const ShownCloud& cloud : clouds) addAxes(axes, cloud.canvasFromScan, 1);
  }
  setLines(kAxesItem, axes, 2);
  LineSet rings;
  if (options.rangeRings && !clouds.empty()) addRangeRings(rings, ground, kRingColor);
  setLines(kRangeRingsItem, rings, 1);
  LineSet track;
  if (options.trajectory && worldFromAnchor && trajectory.size() > 1) {
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
  itemsChanged = hudChanged = true;
  placeMeasure();
}

void ViewSession::State::setLines(ItemId item, const LineSet& lines, double width) {
  canvas.setLines(item, lines.ends, lines.colors);
  ItemLook look;
  look.size = width;
  look.views = (1U << viewCount()) - 1;
  canvas.setLook(item, look);
}

void ViewSession::State::placeMeasure() {
  LineSet line;
  if (ends.size() == 2) line.add(ends[0], ends[1], kMeasureColor);
  setLines(kMeasureItem, line, 2);
  itemsChanged = hudChanged = true;
}

void ViewSession::State::placeMesh() {
  itemsChanged = hudChanged = true;
  if (!meshSeen()) {
    meshItem.drop();
    meshShown.clear();
    if (mesh && mesh->size() > 0 && meshOn()) say("no mesh: the pose of the scan is not known");
    return;
  }
  place();
  meshColoring = colorMesh(*mesh, meshColor);
  meshItem.setTriangles(mesh->corners, meshColoring.colors);
  placeMeshLook();
  applyFilter();
  if (source->isScene()) placeGuides();
  if (source->isScene() && !sceneFramed) {
    sceneFramed = true;
    setCamera(firstCamera());
    for (const std::string& warning : mesh->warnings) hint(warning);
    tellWhatEncloses();
  }
}

// Hints at a part that encloses the rest of the scene, such as a closed sky box, if nothing else is seen, from inside
// or outside.
void ViewSession::State::tellWhatEncloses() {
  constexpr int kAcross = 7;
  constexpr double kEnough = 0.1;  // share of the lines of sight that must hit the part
  const ViewCamera view = camera.camera(canvas.width(), canvas.height());
  std::optional<std::size_t> first;  // the first triangle that a line of sight hits
  int met = 0;
  for (int line = 0; line < kAcross * kAcross; ++line) {
    const int column = line % kAcross;
    const int row = line / kAcross;
    const double x = (column + 0.5) * canvas.width() / kAcross;
    const double y = (row + 0.5) * canvas.height() / kAcross;
    const auto thing = pickMesh(sightLine(view, x, y));
    if (!thing) continue;
    ++met;
    if (!first) first = thing->point;
    if (mesh->surfaceOf(thing->point).part != mesh->surfaceOf(*first).part) return;
  }
  if (met < kEnough * kAcross * kAcross) return;
  const std::uint32_t part = mesh->surfaceOf(*first).part;
  Box own, others;
  for (std::size_t t = 0; t < mesh->size(); ++t) {
    if (!meshShown.empty() && meshShown[t] == 0) continue;
    Box& box = mesh->surfaceOf(t).part == part ? own : others;
    for (std::size_t corner = 3 * t; corner < 3 * t + 3; ++corner) box.add(Vec3d(mesh->corners[corner]));
  }
  const auto within = [](const Vec3d& low, const Vec3d& high) {
    return low.x <= high.x && low.y <= high.y && low.z <= high.z;
  };
  if (others.empty() || !within(own.low, others.low) || !within(others.high, own.high)) return;
  hint(
      fmt::format("nothing but '{}' is seen from here, which encloses all the rest: hide its class ({}), or look from "
                  "another place",
                  mesh->parts[part], className(&mesh->ontology, mesh->semantic[*first])));
}

void ViewSession::State::toggleWorld() {
  if (!worldFromAnchor) return say("the poses of the scans are not known");
  const Affine before = canvasFromWorld;
  world = !world;
  place();
  const Affine newFromOld = canvasFromWorld * inverse(before);
  OrbitCamera moved = camera;
  moved.moveBy(newFromOld);
  setCamera(moved);
  for (Vec3d& end : ends) end = newFromOld * end;
  if (pinned) pinned->place = newFromOld * pinned->place;
  hover.reset();
  placeClouds();
  placeGuides();
  placeMeshLook();
  say(world ? "standing in the world" : "following the sensor");
}

OrbitCamera ViewSession::State::preset(View view) const {
  OrbitCamera chosen = presetCamera(view);
  if (source->isScene()) {
    // The view from above shows the whole scene, unless a part of it is far away from the rest.
    constexpr double kFarAway = 3;
    if (!mesh) return chosen;
    const auto longest = [](const Box& box) { return box.empty() ? 0 : length(box.high - box.low); };
    const bool whole = view == View::Above && longest(mesh->bounds) < kFarAway * longest(mesh->core);
    fillWith(chosen, whole ? mesh->bounds : mesh->core, canvas.width(), canvas.height());
  } else if (world && worldFromAnchor) {
    chosen.moveBy(canvasFromWorld * toAffine(*worldFromAnchor));
  }
  return chosen;
}

OrbitCamera ViewSession::State::firstCamera() const {
  const CameraChoice& choice = options.camera;
  if (!source->isScene()) return choice.camera;
  if (choice.view) return preset(*choice.view);
  OrbitCamera chosen = choice.camera;
  if (choice.placed) chosen.target = canvasFromWorld * chosen.target;
  return chosen;
}

std::string ViewSession::State::cameraText() const {
  OrbitCamera told = camera;
  if (source->isScene()) told.target = inverse(canvasFromWorld) * told.target;
  return told.text();
}

void ViewSession::State::setCamera(const OrbitCamera& newCamera) {
  if (newCamera == camera) return;
  camera = newCamera;
  viewsChanged = hudChanged = hoverChanged = true;
}

double ViewSession::State::farthest(const Vec3d& eye) const {
  constexpr double kLeast = 20;
  double far = kLeast;
  const auto reach = [&](const Vec3d& center, double radius) { far = std::max(far, length(center - eye) + radius); };
  for (const ContentBall& ball : content) reach(ball.center, ball.radius + 1);
  if (options.rangeRings && !content.empty()) reach(ground, kRingRadii.back());
  if (options.trajectory && worldFromAnchor) {
    for (const Pose& pose : trajectory) reach(canvasFromWorld * pose.translation, 1);
  }
  if (mesh && meshOn() && !mesh->bounds.empty()) {
    const Box& box = mesh->bounds;
    reach(canvasFromWorld * (mesh->origin + box.center()), length(box.high - box.low) / 2);
  }
  return far;
}

double ViewSession::State::pointSize() const {
  if (options.pointSize > 0) return options.pointSize;
  return std::max(2.0, std::round(canvas.height() / 450.0));
}

void ViewSession::State::placeMeshLook() {
  if (!meshItem.there()) return;
  constexpr double kFaint = 0.25;
  ItemLook look;
  look.canvasFromItem = canvasFromWorld * Affine{{}, mesh->origin};
  look.opacity = source->isScene() ? 1 : kFaint;
  look.views = (1U << viewCount()) - 1;
  meshItem.setLook(look);
  itemsChanged = true;
}

}  // namespace scanmill
