#include "pipeline/run/run_records.h"

#include <algorithm>
#include <string_view>
#include <vector>

#include "base/hash.h"
#include "config/resources.h"
#include "config/version.h"
#include "pipeline/read/drawn_sensors.h"

namespace scanmill {

namespace {

// Returns the number of beams of which at least one ray is unresolved. The rays of a beam need not be adjacent in
// `hits`.
std::uint64_t unresolvedBeams(const Hits& hits) {
  if (hits.beamOfRay.empty()) return hits.unresolved.size();
  std::vector<std::uint32_t> beams;
  for (const std::uint32_t ray : hits.unresolved) beams.push_back(hits.beamOfRay[ray]);
  std::sort(beams.begin(), beams.end());
  return static_cast<std::uint64_t>(std::unique(beams.begin(), beams.end()) - beams.begin());
}

// Counts the points of each class and the different instances of a scan. Consecutive points mostly have the same class
// and instance, so a group of points with the same class and instance is counted in one step.
void countPoints(const Scan& scan, ScanRecord& record) {
  std::vector<std::uint64_t> perClass;
  std::vector<std::uint32_t> instances;
  const bool labels = !scan[kLabel].empty();
  const bool things = !scan[kInstance].empty();
  const auto isPoint = [&](std::size_t i) { return !scan.organised || isFinite(scan.position[i]); };
  for (std::size_t first = 0; first < scan.size();) {
    const bool point = isPoint(first);
    std::size_t end = first + 1;
    while (end < scan.size() && isPoint(end) == point && (!labels || scan[kLabel][end] == scan[kLabel][first]) &&
           (!things || scan[kInstance][end] == scan[kInstance][first])) {
      ++end;
    }
    if (point) {
      record.points += end - first;
      if (labels) {
        const std::uint16_t label = scan[kLabel][first];
        if (label >= perClass.size()) perClass.resize(label + std::size_t{1});
        perClass[label] += end - first;
      }
      if (things && scan[kInstance][first] != 0) instances.push_back(scan[kInstance][first]);
    }
    first = end;
  }
  for (std::size_t c = 0; c < perClass.size(); ++c) {
    if (perClass[c] > 0) record.pointsPerClass[static_cast<std::uint16_t>(c)] = perClass[c];
  }
  std::sort(instances.begin(), instances.end());
  record.instances = static_cast<std::uint32_t>(std::unique(instances.begin(), instances.end()) - instances.begin());
}

}  // namespace

Manifest startManifest(const ShotSource& source, const DatasetPlan& planned) {
  const Plan& plan = source.plan();
  const Pipeline& pipeline = plan.pipeline;
  Manifest manifest;
  manifest.programVersion = kVersion;
  manifest.name = pipeline.name;
  manifest.about = pipeline.about;
  manifest.pipelineText = pipeline.text;
  manifest.pipelineSha256 = sha256(pipeline.text);
  manifest.planSha256 = planned.hash;
  manifest.seed = pipeline.seed;
  manifest.organised = pipeline.output.layout.organised;
  manifest.deskewed = pipeline.motion.deskew;
  manifest.columns = scanColumnNames(plan.columns());
  for (const ChosenFormat& f : pipeline.output.formats) {
    manifest.formats.push_back({std::string(f.entry->name), std::string(f.entry->suffix), f.format->maxError()});
  }
  for (std::size_t s = 0; s < pipeline.sensors.size(); ++s) {
    manifest.sensors.push_back({pipeline.sensors[s].name, *plan.sensors[s].beams, {}});
    if (pipeline.drawn == nullptr || !pipeline.drawn->drawsMounts()) {
      manifest.sensors.back().vehicleFromSensor = pipeline.sensors[s].vehicleFromSensor;
    }
    const double fullScale = intensityFullScale(*pipeline.sensors[s].effects);
    if (fullScale > 0) manifest.sensors.back().intensityFullScale = fullScale;
    BeamTable& beams = manifest.sensors.back().beams;
    // The manifest stores only the compact description, from which fillBeams() computes these tables.
    beams.direction = {};
    beams.origin = {};
    beams.time = {};
  }
  const std::filesystem::path folder = pipeline.file.parent_path();
  for (const Sequence& s : pipeline.sequences) {
    manifest.sequences.push_back({s.key(), s.scene, s.sceneFile.empty() ? "" : savedPath(s.sceneFile, folder),
                                  s.sceneSeed, s.trajectoryName, s.moving,
                                  pipeline.vehicle.empty() ? "" : savedPath(pipeline.vehicle, folder)});
  }
  manifest.files = pipeline.files;
  addFiles(source.vehicleFiles(), manifest.files);
  manifest.modelled = modelled(plan, source.blockedShares());
  return manifest;
}

ScanRecord recordOf(const Shot& shot, const Hits& hits, const Scan& scan, std::string_view method) {
  ScanRecord record;
  record.sensor = shot.sensorName;
  record.revolution = shot.revolution;
  record.method = method;
  record.time = shot.time;
  record.worldFromSensor.push_back(shot.worldFromSensor.front());
  if (shot.worldFromSensor.size() > 1) record.worldFromSensor.push_back(shot.worldFromSensor.back());
  record.beams = hits.size();
  record.unresolved = unresolvedBeams(hits);
  countPoints(scan, record);
  record.beamsPerReason = countReasons(scan.reasonOfBeam);
  return record;
}

}  // namespace scanmill
