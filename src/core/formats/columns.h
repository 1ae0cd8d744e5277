#pragma once

// The columns of a scan, for code that treats them alike.

#include <algorithm>
#include <span>
#include <string>
#include <string_view>

#include "scan/scan.h"

namespace scanmill {

// visit(name, column) for the optional columns in the order of columnNames(), absent ones (empty) included.
template <class ScanType, class Visit>
void visitOptionalColumns(ScanType& scan, Visit&& visit) {
  visit(std::string_view("intensity"), scan.intensity);
  visit(std::string_view("label"), scan.label);
  visit(std::string_view("instance"), scan.instance);
  visit(std::string_view("ring"), scan.ring);
  visit(std::string_view("column"), scan.column);
  visit(std::string_view("time"), scan.time);
  visit(std::string_view("range_true"), scan.rangeTrue);
  visit(std::string_view("incidence"), scan.incidence);
}

// visit(name, empty column) for the optional columns among `names`.
template <class Visit>
void visitNamedColumns(std::span<const std::string> names, Visit&& visit) {
  const Scan none;
  visitOptionalColumns(none, [&](std::string_view name, const auto& column) {
    if (std::find(names.begin(), names.end(), name) != names.end()) visit(name, column);
  });
}

// Throws Error where an optional column is neither empty nor as long as the scan, or an organised scan is not
// rings * columns long.
void requireConsistent(const Scan& scan);

// The points whose position is finite; the sensor's rings and columns stay.
Scan withoutMisses(const Scan& scan);

}  // namespace scanmill
