#include "formats/columns.h"

#include <fmt/format.h>

#include "base/error.h"

namespace scanmill {

namespace {

template <class T>
std::vector<T> gathered(const std::vector<T>& column, const std::vector<std::uint32_t>& rows) {
  std::vector<T> kept;
  if (column.empty()) return kept;
  kept.reserve(rows.size());
  for (const std::uint32_t row : rows) kept.push_back(column[row]);
  return kept;
}

}  // namespace

void requireConsistent(const Scan& scan) {
  visitOptionalColumns(scan, [&](std::string_view name, const auto& column) {
    if (!column.empty() && column.size() != scan.size()) {
      throw Error(fmt::format("a scan of {} points has {} values of {}", scan.size(), column.size(), name));
    }
  });
  if (scan.organised && scan.size() != std::size_t{scan.rings} * scan.columns) {
    throw Error(fmt::format("an organised scan of {} x {} beams has {} points", scan.rings, scan.columns, scan.size()));
  }
}

Scan withoutMisses(const Scan& scan) {
  std::vector<std::uint32_t> rows;
  rows.reserve(scan.size());
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (isFinite(scan.position[i])) rows.push_back(static_cast<std::uint32_t>(i));
  }
  Scan dense;
  dense.rings = scan.rings;
  dense.columns = scan.columns;
  dense.position = gathered(scan.position, rows);
  dense.intensity = gathered(scan.intensity, rows);
  dense.label = gathered(scan.label, rows);
  dense.instance = gathered(scan.instance, rows);
  dense.ring = gathered(scan.ring, rows);
  dense.column = gathered(scan.column, rows);
  dense.time = gathered(scan.time, rows);
  dense.rangeTrue = gathered(scan.rangeTrue, rows);
  dense.incidence = gathered(scan.incidence, rows);
  return dense;
}

}  // namespace scanmill
