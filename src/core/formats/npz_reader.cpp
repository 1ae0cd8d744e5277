#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#include "base/error.h"
#include "formats/cloud_columns.h"
#include "formats/column_value.h"
#include "formats/npy.h"
#include "formats/readers.h"

namespace scanmill {

namespace {

// Calls visit(values) with the array's numbers as a vector of their own type.
template <class Visit>
void visitNumbers(const NpyArray& array, const std::string& what, const Visit& visit) {
  const auto as = [&](auto sample) {
    std::vector<decltype(sample)> values(array.bytes.size() / sizeof(sample));
    if (!values.empty()) std::memcpy(values.data(), array.bytes.data(), array.bytes.size());
    visit(std::move(values));
  };
  const std::string_view kind = array.type.size() == 3 ? std::string_view(array.type).substr(1) : "";
  if (kind == "f4") return as(float{});
  if (kind == "f8") return as(double{});
  if (kind == "u1") return as(std::uint8_t{});
  if (kind == "u2") return as(std::uint16_t{});
  if (kind == "u4") return as(std::uint32_t{});
  if (kind == "u8") return as(std::uint64_t{});
  if (kind == "i1") return as(std::int8_t{});
  if (kind == "i2") return as(std::int16_t{});
  if (kind == "i4") return as(std::int32_t{});
  if (kind == "i8") return as(std::int64_t{});
  throw InputError({what}, fmt::format("{} is of no type of numbers that is read", array.name));
}

// Reads the positions, and the fourth and fifth numbers as those of the columns intensity and ring that the scan lacks.
void addPositions(const NpyArray& array, const std::string& what, Scan& scan) {
  const std::size_t wide = array.shape.back();
  const bool intensity = wide > 3 && !scan.has(kIntensity);
  const bool ring = wide == 5 && !scan.has(kRing);
  visitNumbers(array, what, [&](const auto& values) {
    for (std::size_t i = 0; i + wide <= values.size(); i += wide) {
      scan.position.push_back(
          {static_cast<float>(values[i]), static_cast<float>(values[i + 1]), static_cast<float>(values[i + 2])});
      if (intensity) scan[kIntensity].push_back(static_cast<float>(values[i + 3]));
      if (ring) scan[kRing].push_back(columnValue<std::uint16_t>(values[i + 4], "ring", i / wide, {what}));
    }
  });
}

}  // namespace

const FormatSupport& npzFormat() {
  using enum FormatElements::Use;
  static const FormatSupport format{
      "NumPy",
      ".npz",
      {{Read, "xyz points", "positions, of shape (N, 3) to (N, 5) or (rings, columns, 3)"},
       {Read, "", "arrays of one number a point: see the columns of point clouds"},
       {Unused, "world_from_sensor boxes box_pose box_class box_instance box_velocity box_points box_visibility",
        "poses and boxes, as `export --to npz` writes them"},
       {LeftOut, "", "all other arrays, by their names"}}};
  return format;
}

Cloud readNpz(std::string_view bytes, const std::string& what) {
  const std::vector<NpyArray> arrays = readNpzArrays(bytes, what);
  const auto positions = std::find_if(arrays.begin(), arrays.end(), [](const NpyArray& a) {
    return (a.name == "xyz" || a.name == "points") && (a.shape.size() == 2 || a.shape.size() == 3) &&
           a.shape.back() >= 3 && a.shape.back() <= 5;
  });
  if (positions == arrays.end()) {
    std::vector<std::string> names;
    names.reserve(arrays.size());
    for (const NpyArray& a : arrays) names.push_back(a.name);
    throw InputError({what},
                     fmt::format("has no array `xyz` or `points` of shape (N, 3), (N, 4) or (rings, columns, 3); "
                                 "it has {}",
                                 names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
  }
  Cloud cloud;
  Scan& scan = cloud.scan;
  std::vector<std::size_t> shape = positions->shape;
  shape.pop_back();
  for (const NpyArray& array : arrays) {
    const bool column = columnIndex(array.name) < kColumnCount;
    if (column && array.shape != shape) {
      throw InputError({what}, fmt::format("{} has the shape ({}), the points ({})", array.name,
                                           fmt::join(array.shape, ", "), fmt::join(shape, ", ")));
    }
    if (&array == &*positions) continue;
    if (array.shape != shape || npyNumberBytes(array.type) == 0) {
      cloud.leftOut.addKeyword(npzFormat(), array.name);
      continue;
    }
    visitNumbers(array, what, [&](auto values) { scan.foreign.push_back({array.name, std::move(values)}); });
  }
  adoptColumns(cloud, {what});
  addPositions(*positions, what, scan);
  const auto most = [](const std::vector<std::uint16_t>& values) {
    return values.empty() ? 0u : *std::max_element(values.begin(), values.end()) + 1u;
  };
  scan.rings = most(scan[kRing]);
  scan.columns = most(scan[kColumn]);
  if (shape.size() == 2) {  // an image: planes (one per return) one below the other, each with all rings
    const auto rows = static_cast<std::uint32_t>(shape[0]);
    scan.organised = true;
    scan.planes = scan.rings > 0 && rows % scan.rings == 0 ? rows / scan.rings : 1;
    scan.rings = scan.planes == 0 ? 0 : rows / scan.planes;
    scan.columns = static_cast<std::uint32_t>(shape[1]);
  }
  return cloud;
}

}  // namespace scanmill
