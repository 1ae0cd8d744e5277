#include "pipeline/run/run_records.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string_view>
#include <vector>

#include "base/file.h"
#include "base/hash.h"
#include "config/version.h"
#include "dataset/recording.h"

namespace scanmill {

namespace {

// Beams of which a ray was given up. A beam's rays need not follow one another.
std::uint64_t unresolvedBeams(const Hits& hits) {
  if (hits.beamOfRay.empty()) return hits.unresolved.size();
  std::vector<std::uint32_t> beams;
  for (const std::uint32_t ray : hits.unresolved) beams.push_back(hits.beamOfRay[ray]);
  std::sort(beams.begin(), beams.end());
  return static_cast<std::uint64_t>(std::unique(beams.begin(), beams.end()) - beams.begin());
}

}  // namespace

Manifest startManifest(const Plan& plan) {
  const Pipeline& pipeline = plan.pipeline();
  Manifest manifest;
  manifest.programVersion = kVersion;
  manifest.name = pipeline.name;
  manifest.pipelineText = pipeline.text;
  manifest.pipelineSha256 = sha256(pipeline.text);
  manifest.seed = pipeline.seed;
  manifest.organised = pipeline.layout.organised;
  manifest.deskewed = pipeline.motion.deskew;
  manifest.columns = scanColumnNames(plan.columns());
  for (const FormatChoice& f : pipeline.formats) {
    manifest.formats.push_back({std::string(f.entry->name), std::string(f.entry->suffix), f.format->maxError()});
  }
  for (std::size_t s = 0; s < pipeline.sensors.size(); ++s) {
    manifest.sensors.push_back({pipeline.sensors[s].name, *plan.beams()[s], pipeline.sensors[s].vehicleFromSensor});
    BeamTable& beams = manifest.sensors.back().beams;  // the manifest holds the table per ring
    beams.direction = {};
    beams.origin = {};
    beams.time = {};
  }
  manifest.modelled = plan.modelled();
  manifest.chosen = plan.chosen();
  return manifest;
}

ScanRecord recordOf(const Shot& shot, const Hits& hits, const Scan& scan, std::string_view method) {
  ScanRecord record;
  record.sensor = shot.sensorName;
  record.method = method;
  record.time = shot.time;
  record.worldFromSensor.push_back(shot.worldFromSensor.front());
  if (shot.worldFromSensor.size() > 1) record.worldFromSensor.push_back(shot.worldFromSensor.back());
  record.beams = hits.size();
  record.unresolved = unresolvedBeams(hits);
  std::vector<std::uint64_t> perClass;
  std::vector<std::uint32_t> instances;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (!isFinite(scan.position[i])) continue;
    ++record.points;
    if (!scan[kLabel].empty()) {
      if (scan[kLabel][i] >= perClass.size()) perClass.resize(scan[kLabel][i] + std::size_t{1});
      ++perClass[scan[kLabel][i]];
    }
    if (!scan[kInstance].empty() && scan[kInstance][i] != 0 &&
        (instances.empty() || instances.back() != scan[kInstance][i])) {
      instances.push_back(scan[kInstance][i]);
    }
  }
  for (std::size_t c = 0; c < perClass.size(); ++c) {
    if (perClass[c] > 0) record.pointsPerClass[static_cast<std::uint16_t>(c)] = perClass[c];
  }
  std::sort(instances.begin(), instances.end());
  record.beamsPerReason = countReasons(scan.reasonOfBeam);
  record.instances = static_cast<std::uint32_t>(std::unique(instances.begin(), instances.end()) - instances.begin());
  return record;
}

std::string planHash(const Plan& plan) {
  const Pipeline& pipeline = plan.pipeline();
  Sha256 hash;
  const auto add = [&](std::string_view text) { hash.add(fmt::format("{}:{}\n", text.size(), text)); };
  add(kVersion);
  add(pipeline.text);
  if (plan.chosen()) add(plan.chosen()->assignment);
  for (const auto& beams : plan.beams()) add(beamsHash(*beams));
  std::set<std::filesystem::path> scenes;
  for (const Sequence& sequence : pipeline.sequences) scenes.insert(sequence.sceneFile);
  std::error_code ignored;
  for (const std::filesystem::path& scene : scenes) {
    if (std::filesystem::is_regular_file(scene, ignored)) add(readFile(scene));  // recordings have none
  }
  return hash.hex();
}

}  // namespace scanmill
