#pragma once

// Layouts that write a file for each scan: SPLIT/KEY.SENSOR.SUFFIX,
// "train/street-s1-lane-000000.top.las", or "train/street-s1-lane-000000.top.1.las" for a sensor's second revolution in
// the sample.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "exports/layout.h"

namespace scanmill {

class ScanFiles : public ExportLayout {
 public:
  // Returns the bytes of the file of one of the sample's scans.
  using BytesOf = std::string (*)(const ExportPlan& plan, const ExportSample& sample, const ExportScan& scan);

  // `suffix`: suffix of the files, without a dot.
  ScanFiles(std::string suffix, BytesOf bytesOf) : suffix_(std::move(suffix)), bytesOf_(bytesOf) {}

  void write(const ExportPlan& plan, std::size_t sequence, std::size_t frame, const ReadSample& read,
             const ExportFolder& folder) const override;

 private:
  std::string suffix_;
  BytesOf bytesOf_;
};

// Returns the columns that a scan's file has in addition to the position: the columns of the scan or, if the scan has
// no points, the columns of the dataset.
ColumnSet exportedColumns(const ExportPlan& plan, const Scan& scan);

// Returns the value of a column to write: classes are mapped to the exported ontology, other values are unchanged.
template <class Key>
typename Key::Value exported(const ClassMap& classes, Key, typename Key::Value value) {
  if constexpr (Key::row.display.colors == ColumnColors::Classes) {
    static_assert(std::is_same_v<typename Key::Value, std::uint16_t>);
    return classes.of(value);
  } else {
    return value;
  }
}

}  // namespace scanmill
