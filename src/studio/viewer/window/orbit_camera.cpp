#include "viewer/window/orbit_camera.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <charconv>
#include <iterator>

#include "base/error.h"
#include "evaluate/spread.h"

namespace scanmill {

namespace {

constexpr double kLeastDistance = 0.1;   // least distance from the eye to the target (m)
constexpr double kMostDistance = 1e4;    // largest distance from the eye to the target (m)
constexpr double kFarthestTarget = 1e5;  // largest absolute coordinate of the target along each axis (m)
constexpr double kUsualFocal = 1.15;     // default of OrbitCamera::focal

// Returns the height (pixels) of the largest 16 : 9 rectangle in the picture. Focal lengths are multiples of this
// height, so that a picture of any shape shows at least the contents of a 16 : 9 picture.
double sideOf(int width, int height) {
  return std::min(width / 16.0 * 9.0, static_cast<double>(height));
}

// Unit vectors in the canvas frame: forwardOf() along the line of sight, rightOf() to the right of the picture.
Vec3d forwardOf(double yaw, double pitch) {
  return {std::cos(pitch) * std::cos(yaw), std::cos(pitch) * std::sin(yaw), -std::sin(pitch)};
}

Vec3d rightOf(double yaw) {
  return {std::sin(yaw), -std::cos(yaw), 0};
}

Vec3d limitedTarget(const Vec3d& position) {
  const auto limited = [](double v) { return std::clamp(v, -kFarthestTarget, kFarthestTarget); };
  return {limited(position.x), limited(position.y), limited(position.z)};
}

[[noreturn]] void refuse(const std::string& text) {
  throw InputError(fmt::format(
      "a camera is one of {}, or YAW,PITCH,DISTANCE[,X,Y,Z[,FOCAL]][,ortho]: where it looks (deg; yaw from x "
      "towards y, pitch downwards from -90 to 90), from how far (m, {} to {}) at which place (m), such as "
      "30,20,25 or 0,90,50,10,0,0; not '{}'",
      fmt::join(kViewNames, ", "), kLeastDistance, kMostDistance, text));
}

enum class FilledSide { Width, Height };

// Moves the camera, without turning it, so that the points are centred and nearly fill the picture. Returns the side of
// the picture that the points fill. `middle`: see OrbitCamera::fillWith().
FilledSide fillPicture(OrbitCamera& camera, const std::vector<Vec3d>& points, const Vec3d& middle, int width,
                       int height) {
  constexpr double kFilled = 0.9;  // fraction of the picture's side
  const ViewCamera view = camera.camera(width, height);
  // An axis of the picture. `slope`: the distance (m) by which each end of the filled part moves outward per metre of
  // depth; 0 if the camera is orthographic. Two planes with these slopes enclose the points closely; at depth 0 they
  // cross the axis at the coordinates `low` and `high` (m).
  struct PictureAxis {
    Vec3d direction;
    int pixels;
    double slope;
    double low = 1e30, high = -1e30;
  };
  const double slopePerPixel = view.orthographic ? 0 : kFilled / (2 * view.focal);
  PictureAxis x{view.right, width, slopePerPixel * width}, y{view.down, height, slopePerPixel * height};
  for (const Vec3d& point : points) {
    for (PictureAxis* axis : {&x, &y}) {
      const double reach = axis->slope * dot(point, view.forward);
      axis->low = std::min(axis->low, dot(point, axis->direction) + reach);
      axis->high = std::max(axis->high, dot(point, axis->direction) - reach);
    }
  }
  const double depth = dot(middle, view.forward);
  camera.target = x.direction * ((x.low + x.high) / 2) + y.direction * ((y.low + y.high) / 2) + view.forward * depth;
  if (view.orthographic) {
    const auto metresPerPixel = [](const PictureAxis& axis) { return (axis.high - axis.low) / axis.pixels; };
    camera.distance *= std::max(metresPerPixel(x), metresPerPixel(y)) * view.focal / kFilled;
    return metresPerPixel(y) > metresPerPixel(x) ? FilledSide::Height : FilledSide::Width;
  }
  // The planes of an axis intersect at the eye's depth.
  const auto eyeDepth = [](const PictureAxis& axis) { return (axis.low - axis.high) / (2 * axis.slope); };
  camera.distance = depth - std::min(eyeDepth(x), eyeDepth(y));
  return eyeDepth(y) < eyeDepth(x) ? FilledSide::Height : FilledSide::Width;
}

// Returns the box from the 1st to the 99th percentile of the points' coordinates along each axis.
Box boxOfMost(const std::vector<Vec3d>& points) {
  Box box{};
  for (double Vec3d::*const axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
    std::vector<double> coordinates(points.size());
    std::ranges::transform(points, coordinates.begin(), [&](const Vec3d& p) { return p.*axis; });
    box.low.*axis = quantileOf(coordinates, 0.01);
    box.high.*axis = quantileOf(std::move(coordinates), 0.99);
  }
  return box;
}

}  // namespace

Vec3d OrbitCamera::eye() const {
  return target - forwardOf(yaw, pitch) * distance;
}

ViewCamera OrbitCamera::camera(int width, int height) const {
  // Least distance of an orthographic camera from the target (m). LiDAR reaches less: no point is behind the camera.
  constexpr double kOrthographicDistance = 1000;
  constexpr double kNearestShare = 0.05;  // depth of the nearest drawn points divided by the target's distance
  ViewCamera view;
  view.orthographic = orthographic;
  view.forward = forwardOf(yaw, pitch);
  view.right = rightOf(yaw);
  view.down = cross(view.forward, view.right);
  view.focal = focal * sideOf(width, height);
  if (orthographic) view.focal /= distance;
  view.eye = target - view.forward * (orthographic ? std::max(distance, kOrthographicDistance) : distance);
  view.centerX = width / 2.0;
  view.centerY = height / 2.0;
  view.nearest = orthographic ? 0.5 : std::clamp(kNearestShare * distance, 0.01, 0.5);
  return view;
}

void OrbitCamera::orbit(double right, double down, int height) {
  const double perPixel = kPi / std::max(height, 1);
  yaw = wrapped(yaw - right * perPixel);
  pitch = std::clamp(pitch + down * perPixel, -kPi / 2, kPi / 2);
}

void OrbitCamera::pan(double right, double down, int width, int height) {
  const double metresPerPixel = distance / (focal * std::max(sideOf(width, height), 1.0));
  const ViewCamera view = camera(width, height);
  target = limitedTarget(target - view.right * (right * metresPerPixel) - view.down * (down * metresPerPixel));
}

void OrbitCamera::zoom(double steps) {
  distance = std::clamp(distance * std::pow(0.9, steps), kLeastDistance, kMostDistance);
}

void OrbitCamera::lookAt(const Vec3d& position) {
  const Vec3d sight = position - eye();
  target = limitedTarget(position);
  if (orthographic || !(length(sight) > 0)) return;
  if (sight.x != 0 || sight.y != 0) yaw = std::atan2(sight.y, sight.x);
  pitch = std::atan2(-sight.z, std::hypot(sight.x, sight.y));
  distance = std::clamp(length(sight), kLeastDistance, kMostDistance);
}

void OrbitCamera::fillWith(const std::vector<Vec3d>& points, const Vec3d& middle, View view, int width, int height) {
  while (fillPicture(*this, points, middle, width, height) == FilledSide::Width && view == View::Chase &&
         pitch < radians(45)) {
    pitch += radians(5);
  }
  distance = std::clamp(distance, kLeastDistance, kMostDistance);
}

OrbitCamera OrbitCamera::seeing(const std::vector<Vec3d>& points, View view, int width, int height,
                                double least) const {
  const ViewCamera projection = camera(width, height);
  const auto visible = std::ranges::count_if(points, [&](const Vec3d& point) {
    const Projected p = projection.project(point);
    return p.depth >= projection.nearest && p.x >= 0 && p.x < width && p.y >= 0 && p.y < height;
  });
  const bool enough = static_cast<double>(visible) >= least * static_cast<double>(points.size());
  if (enough || view == View::Driver) return *this;
  const Box box = boxOfMost(points);
  std::vector<Vec3d> inBox;
  std::ranges::copy_if(points, std::back_inserter(inBox), [&](const Vec3d& p) { return box.distanceTo(p) == 0; });
  OrbitCamera moved = *this;
  moved.fillWith(inBox, box.center(), view, width, height);
  return moved;
}

void OrbitCamera::moveBy(const Affine& newFromOld) {
  target = limitedTarget(newFromOld * target);
  yaw = wrapped(yaw + std::atan2(newFromOld.linear.x.y, newFromOld.linear.x.x));
}

std::string OrbitCamera::text() const {
  const auto toMillimetres = [](double m) { return std::round(m * 1000) / 1000 + 0.0; };  // never -0
  std::string text = fmt::format("{:.6g},{:.6g},{:.6g},{:.12g},{:.12g},{:.12g}", degrees(yaw), degrees(pitch), distance,
                                 toMillimetres(target.x), toMillimetres(target.y), toMillimetres(target.z));
  if (focal != kUsualFocal) text += fmt::format(",{:.6g}", focal);
  if (orthographic) text += ",ortho";
  return text;
}

OrbitCamera presetCamera(View view) {
  switch (view) {
    case View::Driver:  // the horizontal field of view is 89 degrees
      return {.target = {10, 0, 0}, .distance = 10, .focal = 0.9};
    case View::Above:  // the y axis points up in the picture, whose height is 50 m
      return {.yaw = kPi / 2, .pitch = kPi / 2, .distance = 50 * kUsualFocal, .orthographic = true};
    case View::Chase:
      break;
  }
  const Vec3d eye{-12, 0, 6.5}, target{12, 0, -2.1};
  const Vec3d sight = target - eye;
  return {.target = target, .pitch = std::atan2(-sight.z, sight.x), .distance = length(sight)};
}

CameraChoice parseCamera(const std::string& text) {
  constexpr double kFarthestPlace = 1e8;  // largest coordinate of the target (m); UTM coordinates are smaller
  for (std::size_t i = 0; i < kViewNames.size(); ++i) {
    const auto view = static_cast<View>(i);
    if (kViewNames[i] == text) return {presetCamera(view), view};
  }
  constexpr std::string_view kOrtho = ",ortho";
  std::string_view numbers = text;
  OrbitCamera camera;
  if (numbers.ends_with(kOrtho)) {
    camera.orthographic = true;
    numbers.remove_suffix(kOrtho.size());
  }
  std::vector<double> values;
  const char* next = numbers.data();
  const char* const end = next + numbers.size();
  while (true) {
    double value = 0;
    const auto [stop, error] = std::from_chars(next, end, value);
    if (error != std::errc() || !std::isfinite(value)) refuse(text);
    values.push_back(value);
    if (stop == end) break;
    if (*stop != ',') refuse(text);
    next = stop + 1;
  }
  const bool isComplete = values.size() == 3 || values.size() == 6 || values.size() == 7;
  if (!isComplete || std::abs(values[1]) > 90 || values[2] < kLeastDistance || values[2] > kMostDistance) refuse(text);
  camera.yaw = wrapped(radians(values[0]));
  camera.pitch = radians(values[1]);
  camera.distance = values[2];
  if (values.size() >= 6) {
    camera.target = {values[3], values[4], values[5]};
    for (std::size_t i = 3; i < 6; ++i) {
      if (std::abs(values[i]) > kFarthestPlace) refuse(text);
    }
  }
  if (values.size() == 7) {
    camera.focal = values[6];
    if (!(camera.focal >= 0.05 && camera.focal <= 20)) refuse(text);
  }
  return {camera, std::nullopt, values.size() >= 6};
}

}  // namespace scanmill
