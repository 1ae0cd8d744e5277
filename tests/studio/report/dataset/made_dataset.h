#pragma once

// Datasets that say exactly what a test wants: scans of a handful of points.

#include <string>
#include <vector>

#include "tests/core/dataset/fixture.h"

namespace scanmill {

struct MadePoint {
  Vec3f at;
  std::uint16_t label = 7;
  std::uint32_t instance = 0;
  float intensity = 10;
};

struct WrittenSample {
  std::string key;
  std::string split;
  std::vector<MadePoint> points;
  std::uint64_t unresolved = 0;
};

// One sensor, "top"; classes 0 unlabeled, 7 road and 65535 car, which is a thing.
inline Manifest madeManifest() {
  Manifest manifest = testManifest();
  manifest.sensors.resize(1);
  manifest.sequences.clear();
  for (const std::uint64_t seed : {1, 2}) {
    const std::string name = "street-s" + std::to_string(seed) + "-lane";
    manifest.sequences.push_back({name, "street", "street.yaml", seed, "lane", true, ""});
  }
  manifest.columns = {"x", "y", "z", "intensity", "label", "instance", "ring"};
  return manifest;
}

inline Scan madeScan(const BeamTable& beams, const std::vector<MadePoint>& points) {
  Scan scan;
  scan.rings = beams.rings;
  scan.columns = beams.columns;
  scan.columnsIfEmpty = ColumnSet(kIntensity, kLabel, kInstance, kRing);
  for (const MadePoint& p : points) {
    scan.position.push_back(p.at);
    scan[kLabel].push_back(p.label);
    scan[kInstance].push_back(p.instance);
    scan[kIntensity].push_back(p.intensity);
    scan[kRing].push_back(static_cast<std::uint16_t>(scan[kRing].size() % beams.rings));
  }
  return scan;
}

// Every sample fills a shard of its own where `apart`.
inline Manifest writeMadeDataset(const std::filesystem::path& folder, const std::vector<WrittenSample>& samples,
                                 Manifest manifest = madeManifest(), bool apart = false) {
  PackedDataset writer(folder, false, apart ? 4096 : 10'000'000);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const WrittenSample& made = samples[i];
    const Scan scan = madeScan(manifest.sensors[0].beams, made.points);
    Sample sample{
        {.key = made.key, .split = made.split, .scans = {testRecord(manifest.sensors[0], scan, 0.1 * double(i))}}, {}};
    sample.scans[0].unresolved = made.unresolved;
    for (const FormatRecord& format : manifest.formats) {
      sample.files.push_back({memberSuffix(sample.scans[0], format.suffix), encode(format.name, scan)});
    }
    writer.add(std::move(sample));
  }
  writer.finish(manifest);
  return manifest;
}

// Nothing to warn of: road and a car with an id in every split.
inline std::vector<WrittenSample> soundSamples() {
  std::vector<WrittenSample> samples;
  for (int i = 0; i < 6; ++i) {
    const std::string split = i < 4 ? "train" : "val";
    WrittenSample sample{"street-s" + std::to_string(i < 4 ? 1 : 2) + "-lane-00000" + std::to_string(i), split, {}, 0};
    for (int k = 0; k < 20; ++k) sample.points.push_back({{3.0f + float(k), 0.25f * float(k), -1.5f}, 7, 0, float(k)});
    for (int k = 0; k < 5; ++k) {
      sample.points.push_back({{12, 2 + 0.1f * float(k), -1}, 65535, 3, 200});
    }
    samples.push_back(sample);
  }
  return samples;
}

}  // namespace scanmill
