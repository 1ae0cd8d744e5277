#include "viewer/window/canvas_items.h"

#include <algorithm>

namespace scanmill {

namespace {

void addCircle(LineSet& lines, const Vec3d& center, double radius, const Rgb& color) {
  constexpr int kSegments = 128;
  const auto at = [&](int i) {
    const double angle = 2 * kPi * i / kSegments;
    return center + Vec3d{radius * std::cos(angle), radius * std::sin(angle), 0};
  };
  for (int i = 0; i < kSegments; ++i) lines.add(at(i), at(i + 1), color);
}

}  // namespace

void LineSet::add(const Vec3d& from, const Vec3d& to, const Rgb& color) {
  ends.push_back(Vec3f(from));
  ends.push_back(Vec3f(to));
  colors.push_back(color);
}

void addAxes(LineSet& lines, const Affine& pose, double length) {
  lines.add(pose.translation, pose * Vec3d{length, 0, 0}, {235, 64, 52});
  lines.add(pose.translation, pose * Vec3d{0, length, 0}, {64, 200, 80});
  lines.add(pose.translation, pose * Vec3d{0, 0, length}, {70, 130, 255});
}

void addRangeRings(LineSet& lines, const Vec3d& center, const Rgb& color) {
  for (const double radius : kRingRadii) addCircle(lines, center, radius, color);
}

void addTrack(LineSet& lines, std::span<const Vec3d> places, std::size_t current, const Rgb& color) {
  constexpr double kMarkRadius = 0.5;  // radius of the circle at the current place (m)
  for (std::size_t i = 0; i + 1 < places.size(); ++i) {
    lines.add(places[i], places[i + 1], i < current ? mix(color, {0, 0, 0}, 0.5) : color);
  }
  if (current < places.size()) addCircle(lines, places[current], kMarkRadius, color);
}

void addBox(LineSet& lines, const Affine& pose, const Vec3d& size, bool front, const Rgb& color) {
  const auto corner = [&](int k) {
    return pose * Vec3d{(k & 1 ? 0.5 : -0.5) * size.x, (k & 2 ? 0.5 : -0.5) * size.y, (k & 4 ? 0.5 : -0.5) * size.z};
  };
  for (int k = 0; k < 8; ++k) {
    for (const int along : {1, 2, 4}) {
      if ((k & along) == 0) lines.add(corner(k), corner(k | along), color);
    }
  }
  if (!front) return;
  const double nose = std::max(0.5, size.x / 4);  // length of the line at the front (m)
  const Vec3d low{size.x / 2, 0, -size.z / 2};
  lines.add(pose * low, pose * (low + Vec3d{nose, 0, 0}), color);
}

double groundHeight(std::span<const Vec3f> points, const Affine& pose) {
  constexpr double kShare = 0.05;
  std::vector<double> heights;
  heights.reserve(points.size());
  for (const Vec3f& p : points) {
    if (isFinite(p)) heights.push_back((pose * Vec3d(p)).z);
  }
  if (heights.empty()) return 0;
  const auto place = heights.begin() + static_cast<std::ptrdiff_t>(kShare * static_cast<double>(heights.size() - 1));
  std::nth_element(heights.begin(), place, heights.end());
  return *place;
}

}  // namespace scanmill
