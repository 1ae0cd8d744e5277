#pragma once

// A scan: the points that the sensor reports in one revolution, one row per point, as files store them.
//
//   for (std::size_t i = 0; i < scan.size(); ++i) {
//     if (scan[kLabel][i] == 10) std::printf("%g m ahead\n", static_cast<double>(scan.position[i].x));
//   }

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "base/vec.h"
#include "scan/columns.h"

namespace scanmill {

// A column of a recorded file that is not in the table of columns (near_ir, ambient, ...), in its stored type.
struct ForeignColumn {
  using Values = std::variant<std::vector<float>, std::vector<std::uint8_t>, std::vector<std::uint16_t>,
                              std::vector<std::uint32_t>, std::vector<std::uint64_t>, std::vector<std::int8_t>,
                              std::vector<std::int16_t>, std::vector<std::int32_t>, std::vector<std::int64_t>,
                              std::vector<double>>;
  std::string name;
  Values values;
};

// A scan is dense or organised. A dense scan has no misses; its points are ordered by column, then ring, then return.
// An organised scan is an image of `columns` x (planes * rings) pixels, row by row: plane n holds the (n + 1)th return
// of each beam. Its misses have NaN as position and Column::none in each column.
//
// A point is identified by its beam, ring * columns + column, and the number of its return. This key joins a noisy scan
// to its noise-free reference. If a beam has lost or gained returns, its keys no longer match, since each scan numbers
// the returns by range. Columns that were not asked for are empty.
class Scan {
 public:
  std::uint32_t rings = 0;    // number of the sensor's rings
  std::uint32_t columns = 0;  // number of the sensor's columns
  bool organised = false;
  std::uint32_t planes = 1;  // number of images in an organised scan, one per return; 1 in a dense scan

  std::vector<Vec3f> position;         // m, sensor frame
  std::vector<ForeignColumn> foreign;  // each has one value per point
  ColumnSet columnsIfEmpty;            // columns of a scan without points; unused if the scan has points

  // The reason of each beam (a Reason, scan/reasons.h), indexed by ring * columns + column; empty unless
  // ScanLayout::reasons is true. It is not a column, since beams without a return have a reason but no point.
  std::vector<std::uint8_t> reasonOfBeam;

  std::size_t size() const { return position.size(); }
  std::uint32_t width() const { return organised ? columns : static_cast<std::uint32_t>(size()); }
  std::uint32_t height() const { return organised ? planes * rings : 1; }

  // Returns the values of a column of the table, one per point; empty if the scan does not have the column.
  template <std::size_t Index>
  std::vector<typename ColumnKey<Index>::Value>& operator[](ColumnKey<Index>) {
    return std::get<Index>(values_);
  }
  template <std::size_t Index>
  const std::vector<typename ColumnKey<Index>::Value>& operator[](ColumnKey<Index>) const {
    return std::get<Index>(values_);
  }

  // True if the scan has a column of the table, also if the scan has no points.
  template <std::size_t Index>
  bool has(ColumnKey<Index> key) const {
    return !(*this)[key].empty() || (position.empty() && columnsIfEmpty.has(key));
  }

 private:
  template <std::size_t... Index>
  static auto columnsOfTable(std::index_sequence<Index...>)
      -> std::tuple<std::vector<typename ColumnKey<Index>::Value>...>;

  decltype(columnsOfTable(std::make_index_sequence<kColumnCount>())) values_;
};

// Calls visit(key, values) for every column in the table of columns (scan/columns.h); the values are empty if the scan
// does not have the column.
template <class ScanType, class Visit>
void visitTable(ScanType& scan, Visit&& visit) {
  forEachColumn([&](auto key) { visit(key, scan[key]); });
}

// Calls visit(name, values) for the columns that the scan has besides its positions: first the columns of the table,
// then the foreign columns.
template <class ScanType, class Visit>
void visitColumns(ScanType& scan, Visit&& visit) {
  visitTable(scan, [&](auto key, auto& values) {
    if (scan.has(key)) visit(key.row.name, values);
  });
  for (auto& column : scan.foreign) {
    std::visit([&](auto& values) { visit(std::string_view(column.name), values); }, column.values);
  }
}

// Returns the columns of the table that the scan has.
ColumnSet columnsOf(const Scan& scan);

// Returns "x", "y", "z", then the names of the columns that the scan has, in the order of visitColumns().
std::vector<std::string> columnNames(const Scan& scan);

// Throws Error if a column is neither empty nor as long as the scan, or if an organised scan does not have planes *
// rings * columns points.
void requireConsistent(const Scan& scan);

// Returns a dense scan of the points with a finite position, with the same rings and columns, and without reasonOfBeam.
[[nodiscard]] Scan withoutMisses(const Scan& scan);

// The beam of a point (ring, column), and which of the beam's returns the point is (number, counted from 0).
struct PointKey {
  std::uint32_t ring = 0;
  std::uint32_t column = 0;
  std::uint32_t number = 0;
  bool operator==(const PointKey&) const = default;
};

// True if the beam of each point is known: in an organised scan from the order of its points, in a dense scan from its
// columns ring and column. True for a dense scan without points.
[[nodiscard]] bool knowsBeams(const Scan& scan);

// Returns the key of a point; knowsBeams(scan) must be true. In a dense scan without a column `return`, `number` is 0.
PointKey keyOf(const Scan& scan, std::size_t point);

// Returns the largest ring, column and number in the keys of a scan, each plus one; zeros if there are no points.
PointKey extentOf(const Scan& scan);

}  // namespace scanmill
