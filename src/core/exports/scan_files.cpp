#include "exports/scan_files.h"

#include <fmt/core.h>

namespace scanmill {

std::filesystem::path ScanFiles::fileOf(const SampleRecord& sample, const ScanRecord& scan) const {
  return std::filesystem::path(sample.split) / fmt::format("{}.{}.{}", sample.key, revolutionName(scan), suffix_);
}

std::vector<std::filesystem::path> ScanFiles::filesOf(const ExportPlan& plan, std::size_t sequence,
                                                      std::size_t frame) const {
  const SampleRecord& sample = plan.manifest.samples[plan.sequences[sequence].samples[frame]];
  std::vector<std::filesystem::path> files;
  for (std::size_t s = 0; s < plan.sensors.size(); ++s) {
    for (const ScanRecord* scan : revolutionsOf(plan, sample, s)) files.push_back(fileOf(sample, *scan));
  }
  return files;
}

void ScanFiles::write(const ExportPlan& plan, std::size_t sequence, std::size_t frame, const ReadSample& read,
                      const ExportFolder& folder) const {
  const ExportSample sample = read(sequence, frame);
  for (const ExportScan& scan : sample.scans) {
    requireConsistent(scan.scan);
    folder.write(fileOf(*sample.record, *scan.record), bytesOf(plan, sample, scan));
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
