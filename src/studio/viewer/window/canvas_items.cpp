#include "viewer/window/canvas_items.h"

#include "evaluate/spread.h"

namespace scanmill {

namespace {

void addCircle(LineSet& lines, const Vec3d& center, double radius, const Rgb& color) {
  constexpr int kSegments = 128;
  const auto corner = [&](int i) {
    const double angle = 2 * kPi * i / kSegments;
    return center + Vec3d{radius * std::cos(angle), radius * std::sin(angle), 0};
  };
  for (int i = 0; i < kSegments; ++i) lines.add(corner(i), corner(i + 1), color);
}

}  // namespace

void addAxes(LineSet& lines, const Affine& pose, double length) {
  lines.add(pose.translation, pose * Vec3d{length, 0, 0}, {235, 64, 52});
  lines.add(pose.translation, pose * Vec3d{0, length, 0}, {64, 200, 80});
  lines.add(pose.translation, pose * Vec3d{0, 0, length}, {70, 130, 255});
}

void addRangeRings(LineSet& lines, const Vec3d& center, const Rgb& color) {
  for (const double radius : kRingRadii) addCircle(lines, center, radius, color);
}

void addTrack(LineSet& lines, std::span<const Vec3d> positions, std::size_t current, const Rgb& color) {
  constexpr double kMarkRadius = 0.5;  // radius of the circle at the current position (m)
  for (std::size_t i = 0; i + 1 < positions.size(); ++i) {
    lines.add(positions[i], positions[i + 1], i < current ? mix(color, {0, 0, 0}, 0.5) : color);
  }
  if (current < positions.size()) addCircle(lines, positions[current], kMarkRadius, color);
}

void addBox(LineSet& lines, const Affine& pose, const Vec3d& size, const Rgb& color) {
  const std::array<Vec3d, 8> corners = Box{size * -0.5, size * 0.5}.corners();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    for (const std::size_t axisBit : {1, 2, 4}) {
      if ((i & axisBit) == 0) lines.add(pose * corners[i], pose * corners[i | axisBit], color);
    }
  }
}

double groundHeight(std::span<const Vec3f> points, const Affine& pose) {
  constexpr double kGroundPercentile = 0.05;
  std::vector<double> heights;
  heights.reserve(points.size());
  for (const Vec3f& p : points) {
    if (isFinite(p)) heights.push_back((pose * Vec3d(p)).z);
  }
  return heights.empty() ? 0 : quantileOf(std::move(heights), kGroundPercentile);
}

}  // namespace scanmill
