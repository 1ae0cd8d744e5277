#include "models/occupancy.h"

#include <algorithm>

namespace scanmill::models {
namespace {

// True if the two rectangles overlap when projected onto each of the two axes of `a`.
bool overlapOnAxes(const Footprint& a, const Footprint& b) {
  const double c = std::cos(b.yaw - a.yaw);
  const double s = std::sin(b.yaw - a.yaw);
  const double dx = b.center.x - a.center.x;
  const double dy = b.center.y - a.center.y;
  const double x = dx * std::cos(a.yaw) + dy * std::sin(a.yaw);
  const double y = -dx * std::sin(a.yaw) + dy * std::cos(a.yaw);
  return std::abs(x) < a.halfX + b.halfX * std::abs(c) + b.halfY * std::abs(s) &&
         std::abs(y) < a.halfY + b.halfX * std::abs(s) + b.halfY * std::abs(c);
}

}  // namespace

Footprint footprint(const Model& m, const Spot& s, double grow) {
  const Vec3d c = m.bounds.center() * s.scale;
  const double cy = std::cos(s.yaw);
  const double sy = std::sin(s.yaw);
  return {{s.at.x + cy * c.x - sy * c.y, s.at.y + sy * c.x + cy * c.y},
          (m.bounds.high.x - m.bounds.low.x) / 2 * s.scale + grow,
          (m.bounds.high.y - m.bounds.low.y) / 2 * s.scale + grow,
          s.yaw};
}

Affine poseOf(const Spot& s, double z) {
  Affine pose = at({s.at.x, s.at.y, z}, s.yaw);
  pose.linear = pose.linear * toMatrix(fromYawPitchRoll(0, 0, s.lean)) * Mat3::scale(Vec3d{1, 1, 1} * s.scale);
  return pose;
}

// Two rectangles overlap if their projections overlap on all four axes (separating axis theorem).
bool Occupancy::isFree(const Footprint& f) const {
  bool free = true;
  forCells(f.center, f.center, std::hypot(f.halfX, f.halfY), kCell, [&](std::uint64_t key) {
    free = free && std::ranges::none_of(cells_.of(key), [&](std::uint32_t index) {
             return overlapOnAxes(f, taken_[index]) && overlapOnAxes(taken_[index], f);
           });
  });
  return free;
}

void Occupancy::add(const Footprint& f) {
  cells_.add(f.center, f.center, std::hypot(f.halfX, f.halfY), static_cast<std::uint32_t>(taken_.size()));
  taken_.push_back(f);
}

}  // namespace scanmill::models
