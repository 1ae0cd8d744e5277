#include "scan/scan.h"

#include <algorithm>

#include "base/error.h"

namespace scanmill {

ColumnSet columnsOf(const Scan& scan) {
  ColumnSet columns;
  visitTable(scan, [&](auto key, const auto&) {
    if (scan.has(key)) columns.add(key.index);
  });
  return columns;
}

std::vector<std::string> columnNames(const Scan& scan) {
  std::vector<std::string> names{"x", "y", "z"};
  visitColumns(scan, [&](std::string_view name, const auto&) { names.emplace_back(name); });
  return names;
}

void requireConsistent(const Scan& scan) {
  visitColumns(scan, [&](std::string_view name, const auto& values) {
    if (values.size() == scan.size()) return;
    throw Error("a scan of {} points has {} values of {}", scan.size(), values.size(), name);
  });
  const std::size_t beams = std::size_t{scan.rings} * scan.columns;
  if (!scan.organised || scan.size() == scan.planes * beams) return;
  throw Error("an organised scan of {} x {} beams has {} points", scan.rings, scan.columns, scan.size());
}

Scan withoutMisses(const Scan& scan) {
  std::vector<std::uint32_t> rows;  // indices of the points that are kept
  rows.reserve(scan.size());
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (isFinite(scan.position[i])) rows.push_back(static_cast<std::uint32_t>(i));
  }
  const auto selectRows = [&]<class T>(const std::vector<T>& values) {
    std::vector<T> selected;
    if (values.empty()) return selected;
    selected.reserve(rows.size());
    for (const std::uint32_t row : rows) selected.push_back(values[row]);
    return selected;
  };
  Scan dense;
  dense.rings = scan.rings;
  dense.columns = scan.columns;
  dense.columnsIfEmpty = columnsOf(scan);
  dense.position = selectRows(scan.position);
  visitTable(dense, [&](auto key, auto& values) { values = selectRows(scan[key]); });
  for (const ForeignColumn& column : scan.foreign) {
    dense.foreign.push_back(
        {column.name,
         std::visit([&](const auto& values) { return ForeignColumn::Values(selectRows(values)); }, column.values)});
  }
  return dense;
}

bool knowsBeams(const Scan& scan) {
  if (scan.organised) return scan.size() == std::size_t{scan.planes} * scan.rings * scan.columns;
  return scan.size() == 0 || (!scan[kRing].empty() && !scan[kColumn].empty());
}

// If the scan is organised, the key follows from the point's index, because misses have no ring and no column.
PointKey keyOf(const Scan& scan, std::size_t point) {
  if (scan.organised) {
    const std::size_t row = point / scan.columns;
    return {static_cast<std::uint32_t>(row % scan.rings), static_cast<std::uint32_t>(point % scan.columns),
            static_cast<std::uint32_t>(row / scan.rings)};
  }
  const auto& number = scan[kReturn];
  return {scan[kRing][point], scan[kColumn][point],
          number.empty() || number[point] == 0 ? 0 : static_cast<std::uint32_t>(number[point] - 1)};
}

PointKey extentOf(const Scan& scan) {
  if (scan.organised) return {scan.rings, scan.columns, scan.planes};
  PointKey extent;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const PointKey key = keyOf(scan, i);
    extent.ring = std::max(extent.ring, key.ring + 1);
    extent.column = std::max(extent.column, key.column + 1);
    extent.number = std::max(extent.number, key.number + 1);
  }
  return extent;
}

}  // namespace scanmill
