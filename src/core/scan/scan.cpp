#include "scan/scan.h"

namespace scanmill {

std::vector<std::string> columnNames(const Scan& scan) {
  std::vector<std::string> names{"x", "y", "z"};
  const auto add = [&](const auto& column, const char* name) {
    if (!column.empty()) names.emplace_back(name);
  };
  add(scan.intensity, "intensity");
  add(scan.label, "label");
  add(scan.instance, "instance");
  add(scan.ring, "ring");
  add(scan.column, "column");
  add(scan.time, "time");
  add(scan.rangeTrue, "range_true");
  add(scan.incidence, "incidence");
  return names;
}

}  // namespace scanmill
