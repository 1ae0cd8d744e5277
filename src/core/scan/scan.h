#pragma once

// A scan: what the sensor reports in one revolution and what is written, a row per point.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "base/vec.h"
#include "scan/columns.h"

namespace scanmill {

// A column of a recorded file that the table of columns does not know (near_ir, ambient, ...), in the type that it was
// stored in.
struct ForeignColumn {
  using Values = std::variant<std::vector<float>, std::vector<std::uint8_t>, std::vector<std::uint16_t>,
                              std::vector<std::uint32_t>, std::vector<std::uint64_t>, std::vector<std::int8_t>,
                              std::vector<std::int16_t>, std::vector<std::int32_t>, std::vector<std::int64_t>,
                              std::vector<double>>;
  std::string name;
  Values values;
};

// A scan is dense or organised. A dense one leaves misses out; its points are ordered by column, then ring, then
// return. An organised one is an image of `columns` x (planes * rings) pixels, row by row: plane n holds the (n + 1)th
// return of each beam. Its misses have a NaN position and each column's value for "none".
//
// A point is known by its beam, ring * columns + column, and the number of its return. This key joins a noisy scan to
// its noise-free reference, but for the beams that have lost or gained returns: their others are counted anew, the
// nearest first. Columns that nobody asked for are empty.
class Scan {
 public:
  std::uint32_t rings = 0;    // of the sensor
  std::uint32_t columns = 0;  // of the sensor
  bool organised = false;
  std::uint32_t planes = 1;  // of an organised scan; 1 in dense ones

  std::vector<Vec3f> position;         // m, sensor frame
  std::vector<ForeignColumn> foreign;  // each as long as the scan

  // What became of each beam of the sensor, ring * columns + column: values of Reason (scan/reasons.h). Empty where
  // nobody asked. It is no column: beams without a return have one too.
  std::vector<std::uint8_t> reasonOfBeam;

  std::size_t size() const { return position.size(); }
  std::uint32_t width() const { return organised ? columns : static_cast<std::uint32_t>(size()); }
  std::uint32_t height() const { return organised ? planes * rings : 1; }

  // The values of a column of the table, one per point; empty where the scan does not have it.
  template <std::size_t Index>
  std::vector<typename ColumnKey<Index>::Value>& operator[](ColumnKey<Index>) {
    return std::get<Index>(values_);
  }
  template <std::size_t Index>
  const std::vector<typename ColumnKey<Index>::Value>& operator[](ColumnKey<Index>) const {
    return std::get<Index>(values_);
  }

 private:
  template <std::size_t... Index>
  static auto columnsOfTable(std::index_sequence<Index...>)
      -> std::tuple<std::vector<typename ColumnKey<Index>::Value>...>;

  decltype(columnsOfTable(std::make_index_sequence<kColumnCount>())) values_;
};

// Calls visit(key, values) for every row of the table, the columns that the scan does not have (empty) included.
template <class ScanType, class Visit>
void visitTable(ScanType& scan, Visit&& visit) {
  forEachColumn([&](auto key) { visit(key, scan[key]); });
}

// Calls visit(name, values) for the columns that the scan has besides its position, those of the table first.
template <class ScanType, class Visit>
void visitColumns(ScanType& scan, Visit&& visit) {
  visitTable(scan, [&](auto key, auto& values) {
    if (!values.empty()) visit(key.row.name, values);
  });
  for (auto& column : scan.foreign) {
    std::visit([&](auto& values) { visit(std::string_view(column.name), values); }, column.values);
  }
}

// The columns of the table that the scan has.
ColumnSet columnsOf(const Scan& scan);

// "x", "y", "z", then the names of the columns that the scan has, in the order of visitColumns().
std::vector<std::string> columnNames(const Scan& scan);

// Throws Error where a column is neither empty nor as long as the scan, or an organised scan is not planes * rings *
// columns long.
void requireConsistent(const Scan& scan);

// The points whose position is finite; the sensor's rings and columns stay.
Scan withoutMisses(const Scan& scan);

// Which beam a point belongs to, and which of the beam's returns it is, counted from 0.
struct PointKey {
  std::uint32_t ring = 0;
  std::uint32_t column = 0;
  std::uint32_t number = 0;
  bool operator==(const PointKey&) const = default;
};

// Whether the scan says which beam each of its points belongs to. An organised scan says it by its order, a dense one
// by its columns ring and column. True for a scan without points.
bool knowsBeams(const Scan& scan);

// The key of a point of a scan that knows its beams. Where a dense scan has no column `return`, every point is taken
// for a first return.
PointKey keyOf(const Scan& scan, std::size_t point);

// How far the keys of a scan reach: one more than the largest ring, column and number.
PointKey extentOf(const Scan& scan);

}  // namespace scanmill
