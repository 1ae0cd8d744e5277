#pragma once

// Datasets that differ from tests/core/dataset/fixture.h in what a viewer must tell apart.

#include <functional>
#include <string>

#include "tests/core/dataset/fixture.h"
#include "viewer/frames/frame_source.h"

namespace scanmill {

// `scan` sees every scan before it is written, `manifest` what stands above all samples.
struct DatasetChanges {
  std::function<void(Scan&, std::size_t sample, std::size_t sensor)> scan = [](Scan&, std::size_t, std::size_t) {};
  std::function<void(Manifest&)> manifest = [](Manifest&) {};
  std::vector<std::string> methods{"ray_tracing"};  // one scan of each
  std::uint32_t frames = 4;
  std::uint32_t revolutions = 1;  // of each sensor in each frame
  std::string sequence = "town-s3-drive";
};

inline Manifest writeChangedDataset(const std::filesystem::path& folder, const DatasetChanges& changes) {
  Manifest manifest = testManifest();
  changes.manifest(manifest);
  PackedDataset writer(folder, false, 1 << 20);
  for (std::uint32_t i = 0; i < changes.frames; ++i) {
    Sample sample{{.key = changes.sequence + "-00000" + std::to_string(i), .split = "train"}, {}};
    for (std::size_t s = 0; s < manifest.sensors.size(); ++s) {
      for (std::uint32_t r = 0; r < changes.revolutions; ++r) {
        for (const std::string& method : changes.methods) {
          Scan scan = testScan(manifest.sensors[s].beams, i * 10 + static_cast<std::uint32_t>(s) + r * 1000);
          changes.scan(scan, i, s);
          ScanRecord record = testRecord(manifest.sensors[s], testScan(manifest.sensors[s].beams, i), 0.1 * i);
          record.method = method;
          record.revolution = r;
          sample.scans.push_back(record);
          for (const FormatRecord& format : manifest.formats) {
            sample.files.push_back({memberSuffix(record, format.suffix), encode(format.name, scan)});
          }
        }
      }
    }
    writer.add(sample);
  }
  writer.finish(manifest);
  return manifest;
}

inline std::vector<std::string> namesOf(const ViewFrame& frame) {
  std::vector<std::string> names;
  for (const ViewScan& s : frame.scans) names.push_back(s.name);
  return names;
}

}  // namespace scanmill
