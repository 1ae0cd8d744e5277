#pragma once

// Reads the waypoints of a path.

#include <vector>

#include "base/vec.h"
#include "config/value.h"

namespace scanmill {

// Whether the height of a path may change.
enum class Climbs { Yes, No };

// Reads [[x, y, z], ...], at least two points, in metres. Throws an InputError with the place of a point that repeats
// the point before it, of a segment that is too steep to have a heading, or of a turn straight back. If the path may
// not climb, all points get the height of the first point.
std::vector<Vec3d> readWaypoints(const Value& value, Climbs climbs = Climbs::Yes);

// Returns the position (m). Throws InputError if a coordinate is so large that doubles are no longer exact enough.
Vec3d checkedPosition(const Vec3d& position, const Location& where);

}  // namespace scanmill
