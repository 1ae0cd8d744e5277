#pragma once

// Places that a path leads through.

#include <vector>

#include "base/vec.h"
#include "config/value.h"

namespace scanmill {

// Whether a path may lead up and down.
enum class Climbs { Yes, No };

// [[x, y, z], ...], two at least, in metres. Throws InputError with the place for a point that repeats the one before
// it, for a stretch that is too steep to have a heading, and for a path that goes straight back. Where the path does
// not climb all are as high as the first.
std::vector<Vec3d> readWaypoints(const Value& value, Climbs climbs = Climbs::Yes);

// Throws InputError where the position is farther away than coordinates are exact.
Vec3d checkedPosition(const Vec3d& position, const Location& where);

}  // namespace scanmill
