#include "pipeline/run/sample_maker.h"

#include <algorithm>
#include <string_view>

#include "base/hash.h"
#include "config/resources.h"
#include "config/version.h"
#include "formats/reasons_png.h"
#include "pipeline/read/drawn_sensors.h"

namespace scanmill {

namespace {

// Returns the number of beams of which at least one ray is unresolved. The rays of a beam need not be adjacent in
// `hits`.
std::uint64_t unresolvedBeams(const Hits& hits) {
  if (hits.beamOfRay.empty()) return hits.unresolved.size();
  std::vector<std::uint32_t> beams;
  for (const std::uint32_t ray : hits.unresolved) beams.push_back(hits.beamOfRay[ray]);
  std::ranges::sort(beams);
  return static_cast<std::uint64_t>(std::unique(beams.begin(), beams.end()) - beams.begin());
}

// Sets the counts of a scan's record: points, points per class, and instances.
void countPoints(const Scan& scan, ScanRecord& record) {
  std::vector<std::uint64_t> pointsPerClass;
  std::vector<std::uint32_t> instances;  // consecutive points mostly have the same instance, which is listed once
  const bool hasLabels = !scan[kLabel].empty();
  const bool hasInstances = !scan[kInstance].empty();
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (scan.organised && !isFinite(scan.position[i])) continue;
    ++record.points;
    if (hasLabels) {
      const std::size_t label = scan[kLabel][i];
      if (label >= pointsPerClass.size()) pointsPerClass.resize(label + 1);
      ++pointsPerClass[label];
    }
    const std::uint32_t thing = hasInstances ? scan[kInstance][i] : 0;
    if (thing != 0 && (instances.empty() || instances.back() != thing)) instances.push_back(thing);
  }
  for (std::size_t c = 0; c < pointsPerClass.size(); ++c) {
    if (pointsPerClass[c] > 0) record.pointsPerClass[static_cast<std::uint16_t>(c)] = pointsPerClass[c];
  }
  std::ranges::sort(instances);
  record.instances = static_cast<std::uint32_t>(std::unique(instances.begin(), instances.end()) - instances.begin());
}

// Returns the manifest's record of a scan: its poses, time and counts.
ScanRecord recordOf(const Shot& shot, const Hits& hits, const Scan& scan, std::string_view method) {
  ScanRecord record{.sensor = shot.sensorName,
                    .revolution = shot.revolution,
                    .method = std::string(method),
                    .time = shot.time,
                    .worldFromSensor = {shot.worldFromSensor.front()},
                    .beams = hits.size(),
                    .unresolved = unresolvedBeams(hits),
                    .beamsPerReason = countReasons(scan.reasonOfBeam)};
  if (shot.worldFromSensor.size() > 1) record.worldFromSensor.push_back(shot.worldFromSensor.back());
  countPoints(scan, record);
  return record;
}

// Encodes a scan in all formats, and the reasons of its beams if the pipeline asks for them, and adds the results to
// the sample's files. The scan's record must be the last in `sample.scans`.
void addFormats(const Pipeline& pipeline, const Scan& scan, Sample& sample) {
  for (const ChosenFormat& f : pipeline.output.formats) {
    sample.files.push_back({memberSuffix(sample.scans.back(), f.entry->suffix), f.format->encode(scan)});
  }
  if (pipeline.output.layout.reasons) {
    sample.files.push_back({memberSuffix(sample.scans.back(), kReasonsSuffix),
                            encodeReasons(scan.reasonOfBeam, scan.rings, scan.columns)});
  }
}

void addVoxels(const Pipeline& pipeline, const SceneVoxels& voxels, const Shot& shot, const ShotBuffers& buffers,
               Sample& sample) {
  VoxelLabels labels = voxels.labels(*pipeline.output.voxels, shot.worldFromSensor.front(), shot.time);
  sample.files.push_back({memberSuffix(sample.scans.back(), kVoxelsSuffix),
                          encodeVoxels(viewVoxels(*pipeline.output.voxels, std::move(labels), shot,
                                                  pipeline.raysPerBeam(shot.sensor), buffers.hits, buffers.scan))});
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
    auto& sensor = manifest.sensors.emplace_back();
    sensor.name = pipeline.sensors[s].name;
    sensor.choice = pipeline.sensors[s].choice;
    sensor.beams = *plan.sensors[s].beams;
    // The manifest stores only the compact description, from which fillBeams() computes these tables.
    sensor.beams.direction = {};
    sensor.beams.origin = {};
    sensor.beams.time = {};
    if (pipeline.drawn == nullptr || !pipeline.drawn->drawsMounts()) {
      sensor.vehicleFromSensor = pipeline.sensors[s].vehicleFromSensor;
    }
    const double fullScale = intensityFullScale(*pipeline.sensors[s].effects);
    if (fullScale > 0) sensor.intensityFullScale = fullScale;
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

SampleMaker::SampleMaker(ShotSource& source, std::filesystem::path keepHits, bool overwrite,
                         std::function<void(const Sequence&)> loading)
    : source_(source),
      plan_(source.plan()),
      keepHits_(std::move(keepHits)),
      overwrite_(overwrite),
      scenes_(source, std::move(loading)),
      recorder_(plan_, RecordingKind::Hits) {}

std::unique_ptr<ShotBuffers> SampleMaker::takeBuffers() {
  const std::scoped_lock lock(idleMutex_);
  if (idle_.empty()) return std::make_unique<ShotBuffers>();
  std::unique_ptr<ShotBuffers> buffers = std::move(idle_.back());
  idle_.pop_back();
  return buffers;
}

MadeSample makeSample(const Plan& plan, const ReadyScene& scene, const Sequence& sequence, const Frame& frame,
                      const SampleWork& work) {
  const Pipeline& pipeline = plan.pipeline;
  const FrameSettings& settings = *frame.settings;
  MadeSample made{.sample = {}, .scene = scene.facts, .account = {}};
  made.sample.key = sequence.key(frame.number);
  made.sample.split = sequence.split;
  made.sample.draws = scene.scene.draws;
  made.sample.draws.insert(made.sample.draws.end(), settings.draws.begin(), settings.draws.end());
  std::ranges::sort(made.sample.draws, {}, &DrawnValue::key);
  if (frame.shots.front().time != frame.time) made.sample.time = frame.time;
  std::optional<ObjectList> objects;
  ShotBuffers& buffers = work.buffers;
  for (const Shot& shot : frame.shots) {
    const ShotSetup setup = setupOf(plan, settings, scene.scene, *scene.method, shot.sensor);
    made.account += runShot(setup, shot, buffers, work.clock);
    // The list has one view of an object for each sensor, in the sensor's first revolution of the sample.
    if (scene.objects != nullptr && shot.revolution == 0) {
      const StageTimer timer(work.clock, "objects");
      if (!objects) objects.emplace(*scene.objects, made.sample.key, frame.time, shot.placed);
      objects->add(shot, pipeline.raysPerBeam(shot.sensor), buffers.hits, buffers.returns);
    }
    std::vector<ScanRecord>& scans = made.sample.scans;
    scans.push_back(recordOf(shot, buffers.hits, buffers.scan, pipeline.methodName()));
    if (pipeline.drawn != nullptr && pipeline.drawn->drawsMounts()) {
      scans.back().vehicleFromSensor = settings.sensors[shot.sensor].vehicleFromSensor;
    }
    if (work.encodes) {
      const StageTimer timer(work.clock, "encode");
      addFormats(pipeline, buffers.scan, made.sample);
    }
    if (work.encodes && scene.voxels != nullptr) {
      const StageTimer timer(work.clock, "voxels");
      addVoxels(pipeline, *scene.voxels, shot, buffers, made.sample);
    }
    work.take(shot, buffers);
  }
  if (objects) {
    const SampleObjects listed = objects->finish();
    made.sample.objects = listed.counts();
    std::vector<Member>& files = made.sample.files;
    files.insert(files.begin(), {std::string(kObjectsSuffix), objectsJson(listed, scene.scene.ontology)});
  }
  return made;
}

MadeSample SampleMaker::make(const SampleAddress& address) {
  const std::shared_ptr<const ReadyScene> loaded = scenes_.enter(address.sequence);
  // Open the recording only after the scene and the method are set up: --overwrite removes an old recording, which must
  // not happen if the new one cannot be made.
  std::call_once(opened_, [&] { recorder_.open(keepHits_, overwrite_); });
  recorder_.enter(address.sequence, loaded->scene, *loaded->method);
  const Frame frame = source_.frame(address.sequence, address.frame, Revolutions::All);
  std::unique_ptr<ShotBuffers> buffers = takeBuffers();
  const auto record = [&](const Shot& shot, const ShotBuffers& traced) {
    if (recorder_.records()) recorder_.writeHits(shot, traced.hits);
  };
  MadeSample made =
      makeSample(plan_, *loaded, plan_.pipeline.sequences[address.sequence], frame, {*buffers, clock_, record});
  {
    const std::scoped_lock lock(idleMutex_);
    idle_.push_back(std::move(buffers));
  }
  scenes_.account(address.sequence, made.account);
  scenes_.release(address.sequence);
  return made;
}

StageSeconds SampleMaker::stageSeconds() const {
  StageSeconds stages = clock_.seconds();
  const StageSeconds methodStages = scenes_.methodSeconds();
  if (!methodStages.empty()) stages.erase("trace");  // the method's own stages are listed instead of their sum
  addSeconds(methodStages, stages);
  addSeconds(recorder_.stageSeconds(), stages);
  stages["setup"] = scenes_.setupSeconds();
  return stages;
}

}  // namespace scanmill
