#include "exports/scan_files.h"

#include <fmt/core.h>

namespace scanmill {

void ScanFiles::write(const ExportPlan& plan, std::size_t sequence, std::size_t frame, const ReadSample& read,
                      const ExportFolder& folder) const {
  const ExportSample sample = read(sequence, frame);
  for (const ExportScan& scan : sample.scans) {
    requireConsistent(scan.scan);
    const std::string file = fmt::format("{}.{}.{}", sample.record->key, revolutionName(*scan.record), suffix_);
    folder.write(std::filesystem::path(sample.record->split) / file, bytesOf_(plan, sample, scan));
  }
}

ColumnSet exportedColumns(const ExportPlan& plan, const Scan& scan) {
  if (scan.size() > 0) return columnsOf(scan);
  ColumnSet columns;
  for (const std::string& name : plan.manifest.columns) {
    const std::size_t index = columnIndex(name);
    if (index < kColumnCount) columns.add(index);  // x, y and z are not in the table
  }
  return columns;
}

}  // namespace scanmill
