#include "viewer/window/orbit_camera.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <iterator>
#include <string_view>

#include "base/error.h"

namespace scanmill {

namespace {

constexpr double kLeastDistance = 0.1;   // least distance from the eye to the target (m)
constexpr double kMostDistance = 1e4;    // largest distance from the eye to the target (m)
constexpr double kFarthestTarget = 1e5;  // largest absolute coordinate of the target along each axis (m)
constexpr double kUsualFocal = 1.15;

// Returns the height (pixels) of the largest 16 : 9 rectangle in the picture. Focal lengths are multiples of this
// height, so that a picture of any shape shows at least the contents of a 16 : 9 picture.
double sideOf(int width, int height) {
  return std::min(width / 16.0 * 9.0, static_cast<double>(height));
}

Vec3d forwardOf(double yaw, double pitch) {
  return {std::cos(pitch) * std::cos(yaw), std::cos(pitch) * std::sin(yaw), -std::sin(pitch)};
}

Vec3d rightOf(double yaw) {
  return {std::sin(yaw), -std::cos(yaw), 0};
}

Vec3d within(const Vec3d& place) {
  const auto limited = [](double v) { return std::clamp(v, -kFarthestTarget, kFarthestTarget); };
  return {limited(place.x), limited(place.y), limited(place.z)};
}

[[noreturn]] void refuse(const std::string& text) {
  throw InputError(fmt::format(
      "a camera is one of {}, or YAW,PITCH,DISTANCE[,X,Y,Z[,FOCAL]][,ortho]: where it looks (deg; yaw from x "
      "towards y, pitch downwards from -90 to 90), from how far (m, {} to {}) at which place (m), such as "
      "30,20,25 or 0,90,50,10,0,0; not '{}'",
      fmt::join(kViewNames, ", "), kLeastDistance, kMostDistance, text));
}

// Moves the camera, without turning it, so that the points are centred and nearly fill the picture. Returns true if
// they fill its height, and false if they fill its width.
bool fill(OrbitCamera& camera, const std::vector<Vec3d>& points, const Vec3d& middle, int width, int height) {
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

// Returns the smallest box that holds all points but the hundredth at each end of each axis.
Box boxOfMost(const std::vector<Vec3d>& points) {
  constexpr double kBeyond = 0.01;
  Box box{};
  for (double Vec3d::*const axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
    std::vector<double> all;
    all.reserve(points.size());
    for (const Vec3d& p : points) all.push_back(p.*axis);
    const auto beyond = static_cast<std::ptrdiff_t>(kBeyond * static_cast<double>(all.size()));
    std::nth_element(all.begin(), all.begin() + beyond, all.end());
    box.low.*axis = all[static_cast<std::size_t>(beyond)];
    std::nth_element(all.begin(), all.end() - 1 - beyond, all.end());
    box.high.*axis = *(all.end() - 1 - beyond);
  }
  return box;
}

}  // namespace

Vec3d OrbitCamera::eye() const {
  return target - forwardOf(yaw, pitch) * distance;
}

ViewCamera OrbitCamera::camera(int width, int height) const {
  // Least distance from an orthographic camera to the target (m). It exceeds the range of any LiDAR, so that no point
  // is behind the camera.
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
  const Vec3d forward = forwardOf(yaw, pitch);
  const Vec3d rightward = rightOf(yaw);
  target = within(target - rightward * (right * metresPerPixel) - cross(forward, rightward) * (down * metresPerPixel));
}

void OrbitCamera::zoom(double steps) {
  distance = std::clamp(distance * std::pow(0.9, steps), kLeastDistance, kMostDistance);
}

void OrbitCamera::lookAt(const Vec3d& place) {
  const Vec3d from = eye();
  const Vec3d line = place - from;
  const double far = length(line);
  target = within(place);
  if (orthographic || !(far > 0)) return;
  yaw = line.x == 0 && line.y == 0 ? yaw : std::atan2(line.y, line.x);
  pitch = std::atan2(-line.z, std::hypot(line.x, line.y));
  distance = std::clamp(far, kLeastDistance, kMostDistance);
}

void OrbitCamera::fillWith(const std::vector<Vec3d>& points, const Vec3d& middle, View view, int width, int height) {
  while (!fill(*this, points, middle, width, height) && view == View::Chase && pitch < radians(45)) pitch += radians(5);
  distance = std::clamp(distance, kLeastDistance, kMostDistance);
}

OrbitCamera OrbitCamera::seeing(const std::vector<Vec3d>& points, View view, int width, int height) const {
  constexpr double kLeastSeen = 0.2;
  const ViewCamera sees = camera(width, height);
  const auto seen = std::ranges::count_if(points, [&](const Vec3d& point) {
    const Projected p = sees.project(point);
    return p.depth >= sees.nearest && p.x >= 0 && p.x < width && p.y >= 0 && p.y < height;
  });
  const bool enough = static_cast<double>(seen) >= kLeastSeen * static_cast<double>(points.size());
  if (enough || view == View::Driver) return *this;
  const Box most = boxOfMost(points);
  std::vector<Vec3d> shown;
  std::ranges::copy_if(points, std::back_inserter(shown), [&](const Vec3d& p) {
    const auto within = [&](double Vec3d::*axis) { return most.low.*axis <= p.*axis && p.*axis <= most.high.*axis; };
    return within(&Vec3d::x) && within(&Vec3d::y) && within(&Vec3d::z);
  });
  OrbitCamera moved = *this;
  moved.fillWith(shown, most.center(), view, width, height);
  return moved;
}

void OrbitCamera::moveBy(const Affine& newFromOld) {
  target = within(newFromOld * target);
  yaw = wrapped(yaw + std::atan2(newFromOld.linear.x.y, newFromOld.linear.x.x));
}

std::string OrbitCamera::text() const {
  const auto millimetres = [](double m) { return std::round(m * 1000) / 1000 + 0.0; };
  std::string out = fmt::format("{:.6g},{:.6g},{:.6g},{:.12g},{:.12g},{:.12g}", degrees(yaw), degrees(pitch), distance,
                                millimetres(target.x), millimetres(target.y), millimetres(target.z));
  if (focal != kUsualFocal) out += fmt::format(",{:.6g}", focal);
  if (orthographic) out += ",ortho";
  return out;
}

OrbitCamera presetCamera(View view) {
  OrbitCamera camera;
  switch (view) {
    case View::Driver:
      camera.target = {10, 0, 0};
      camera.distance = 10;
      camera.focal = 0.9;  // horizontal field of view of 89 degrees
      break;
    case View::Above:
      camera.yaw = kPi / 2;  // the y axis points up in the picture
      camera.pitch = kPi / 2;
      camera.orthographic = true;
      camera.distance = 50 * kUsualFocal;  // the picture's height is 50 m
      break;
    case View::Chase: {
      const Vec3d eye{-12, 0, 6.5};
      camera.target = {12, 0, -2.1};
      camera.distance = length(camera.target - eye);
      camera.pitch = std::atan2(eye.z - camera.target.z, camera.target.x - eye.x);
      break;
    }
  }
  return camera;
}

CameraChoice parseCamera(const std::string& text) {
  constexpr double kFarthestPlace = 1e8;  // largest coordinate of the target (m); UTM coordinates are smaller
  for (std::size_t i = 0; i < kViewNames.size(); ++i) {
    const auto view = static_cast<View>(i);
    if (kViewNames[i] == text) return {presetCamera(view), view};
  }
  constexpr std::string_view kOrtho = ",ortho";
  std::string_view rest = text;
  OrbitCamera camera;
  if (rest.ends_with(kOrtho)) {
    camera.orthographic = true;
    rest.remove_suffix(kOrtho.size());
  }
  std::vector<double> values;
  const char* at = rest.data();
  const char* const end = at + rest.size();
  while (true) {
    double value = 0;
    const auto read = std::from_chars(at, end, value);
    if (read.ec != std::errc() || !std::isfinite(value)) refuse(text);
    values.push_back(value);
    if (read.ptr == end) break;
    if (*read.ptr != ',') refuse(text);
    at = read.ptr + 1;
  }
  const bool counted = values.size() == 3 || values.size() == 6 || values.size() == 7;
  if (!counted || std::abs(values[1]) > 90 || values[2] < kLeastDistance || values[2] > kMostDistance) refuse(text);
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
