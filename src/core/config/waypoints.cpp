
#include <fmt/format.h>

#include <cmath>

#include "config/fields.h"

namespace scanmill {

namespace {

constexpr double kFarthest = 1e9;  // m, largest coordinate
constexpr double kNearest = 1e-6;  // m, least distance between successive waypoints
constexpr double kSteepest = 85;   // deg, largest slope; a vertical path has no yaw
constexpr double kSharpest = 175;  // deg, largest turn at a waypoint; a path must not turn straight back

}  // namespace

Vec3d checkedPosition(const Vec3d& position, const Location& where) {
  if (std::fabs(position.x) > kFarthest || std::fabs(position.y) > kFarthest || std::fabs(position.z) > kFarthest) {
    throw InputError(where, fmt::format("position [{:g}, {:g}, {:g}] is farther than {:g} m from the origin",
                                        position.x, position.y, position.z, kFarthest));
  }
  return position;
}

std::vector<Vec3d> readWaypoints(const Value& value, Climbs climbs) {
  if (value.kind != Value::Kind::Sequence || value.items.size() < 2) {
    throw InputError(
        value.where,
        "waypoints must be a list of at least two positions such as [[0, 0, 0], [50, 0, 0]]; for a vehicle "
        "that stands still use poses");
  }
  std::vector<Vec3d> points;
  points.reserve(value.items.size());
  for (const Value& item : value.items) {
    points.push_back(checkedPosition(readVec3(item, "waypoint"), item.where));
    if (climbs == Climbs::No) points.back().z = points.front().z;
    const std::size_t last = points.size() - 1;
    if (last < 1) continue;
    const Vec3d chord = points[last] - points[last - 1];
    if (length(chord) < kNearest) {
      throw InputError(item.where, fmt::format("waypoint {} repeats the one before it; remove one of them", last + 1));
    }
    if (std::fabs(chord.z) > length(chord) * std::sin(radians(kSteepest))) {
      throw InputError(item.where, fmt::format("the path to waypoint {} is steeper than {} deg: a vehicle that heads "
                                               "along it would have no yaw; use poses",
                                               last + 1, kSteepest));
    }
    if (last < 2) continue;
    const Vec3d before = normalized(points[last - 1] - points[last - 2]);
    if (dot(before, normalized(chord)) < std::cos(radians(kSharpest))) {
      throw InputError(
          value.items[last - 1].where,
          fmt::format("the path goes straight back at waypoint {}; add waypoints that make the turn", last));
    }
  }
  return points;
}

}  // namespace scanmill
