#pragma once

// What stands before the points of a file of LAS 1.4 with point format 6.

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

// What the header says of the points.
struct LasPoints {
  static constexpr std::uint8_t kMostReturns = 15;
  static constexpr std::uint16_t kBytes = 30;  // a point, without extra bytes

  double step = 0;  // m: coordinates are stored as steps from the offset
  Vec3d offset;     // m
  std::uint64_t count = 0;
  std::array<std::uint64_t, kMostReturns> byReturn{};  // the first is that of first returns
  std::array<std::int32_t, 3> least{}, greatest{};     // in steps; of no points zero
  bool returnsAreMadeUp = false;                       // their numbers are not the sensor's own
};

// A column behind the fields of the point format.
struct LasExtra {
  std::string_view name;  // 32 characters at most
  ColumnType type;
  std::string_view unit;  // may be empty
};

// The header and its records: the coordinate system, the names of the classes up to 255, the columns in `extra`.
std::string lasHead(const LasPoints& points, std::span<const LasExtra> extra, const Ontology& classes);

}  // namespace scanmill
