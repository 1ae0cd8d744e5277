#pragma once

// The header of a LAS 1.4 file with point format 6, and the records between header and points.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "base/vec.h"
#include "scan/columns.h"
#include "scene/ontology.h"

namespace scanmill {

constexpr std::uint16_t kMostLasClass = 255;

// The values of the header that describe the points.
struct LasPoints {
  static constexpr std::uint8_t kMostReturns = 15;
  static constexpr std::uint16_t kBytes = 30;  // bytes of a point, without extra bytes

  double step = 0;  // m; coordinates are stored as multiples of the step, relative to the offset
  Vec3d offset;     // m, world: subtracted from coordinates before they are stored as steps
  std::uint64_t count = 0;
  std::array<std::uint64_t, kMostReturns> byReturn{};  // number of points that are first returns, second returns, ...
  std::array<std::int32_t, 3> least{}, greatest{};     // bounds of the coordinates (steps); zero if there are no points
  bool returnsAreMadeUp = false;                       // true if return numbers do not come from the sensor
};

// A column that is stored after the fields of the point format.
struct LasExtra {
  std::string_view name;  // at most 32 characters
  ColumnType type;
  std::string_view unit;  // may be empty
};

// Returns the header and its records: the coordinate system, the names of classes with ids up to 255, and the columns
// in `extra`.
std::string lasHead(const LasPoints& points, std::span<const LasExtra> extra, const Ontology& classes);

}  // namespace scanmill
