#include "models/occupancy.h"

#include <algorithm>

namespace scanmill::models {
namespace {

// True if the projections of the two rectangles onto each of the two axes of `a` overlap.
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

Footprint footprint(const Model& model, const Spot& spot, double margin) {
  const Vec3d center = model.bounds.center() * spot.scale;
  const double halfX = model.length() / 2 * spot.scale + margin;
  const double halfY = model.width() / 2 * spot.scale + margin;
  return {Footprint{spot.at, halfX, halfY, spot.yaw}.at(center.x, center.y), halfX, halfY, spot.yaw};
}

Affine poseOf(const Spot& spot, double z) {
  Affine pose = at({spot.at.x, spot.at.y, z}, spot.yaw);
  pose.linear = pose.linear * toMatrix(fromYawPitchRoll(0, 0, spot.lean)) * Mat3::scale(Vec3d{1, 1, 1} * spot.scale);
  return pose;
}

// Two rectangles overlap if their projections overlap on all four axes (separating axis theorem).
bool Occupancy::isFree(const Footprint& f) const {
  bool free = true;
  forCells(f.center, f.center, std::hypot(f.halfX, f.halfY), kCell, [&](std::uint64_t key) {
    free = free && std::ranges::none_of(cells_.inCell(key), [&](std::uint32_t index) {
             return overlapOnAxes(f, rectangles_[index]) && overlapOnAxes(rectangles_[index], f);
           });
  });
  return free;
}

void Occupancy::add(const Footprint& f) {
  cells_.add(f.center, f.center, std::hypot(f.halfX, f.halfY), static_cast<std::uint32_t>(rectangles_.size()));
  rectangles_.push_back(f);
}

}  // namespace scanmill::models
