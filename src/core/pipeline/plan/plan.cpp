#include "pipeline/plan/plan.h"

#include <fmt/core.h>

#include <algorithm>
#include <map>

#include "base/memory.h"
#include "base/parallel.h"
#include "base/short_text.h"
#include "methods/interface/light_paths.h"
#include "pipeline/read/drawn_sensors.h"
#include "scenefile/scene_file.h"

namespace scanmill {

namespace {

[[noreturn]] void refuse(const Pipeline& pipeline, const std::string& reason) {
  throw InputError({pipeline.file.string()}, reason);
}

// True if rays of a sensor continue through glass or off mirrors in any sequence.
bool anyLightPaths(const Pipeline& pipeline, std::size_t sensor) {
  const std::vector<const Effects*> cases = pipeline.effectCases(sensor);
  return pipeline.recording == nullptr &&
         std::ranges::any_of(cases, [](const Effects* effects) { return lightPaths(*effects) != nullptr; });
}

// Throws InputError if rays must continue behind surfaces, but the method ends each ray at its first hit.
void checkLightPaths(const Pipeline& pipeline) {
  if (pipeline.recording != nullptr || pipeline.method.entry->can.transmission) return;
  for (std::size_t s = 0; s < pipeline.sensors.size(); ++s) {
    if (!anyLightPaths(pipeline, s)) continue;
    refuse(pipeline, fmt::format("the method {} ends each ray at the first surface that it hits: leave the effect "
                                 "light_paths out, or take `method: {}`",
                                 pipeline.methodName(), firstMethodThat(&MethodCapabilities::transmission).name));
  }
}

// Memory of the program, its libraries and its threads' buffers (bytes).
constexpr std::uint64_t kProgramBytes = std::uint64_t{72} << 20;
constexpr std::uint64_t kBeamBytes = sizeof(Vec3d) + sizeof(Vec3f) + sizeof(float);  // memory per beam of a beam table

// Throws InputError if the scenes have different classes, since a dataset has a single ontology. Reads only the
// ontology of each scene file, so that errors are found before hours of work.
void checkOntologies(const Pipeline& pipeline) {
  if (!pipeline.ontology.empty() || pipeline.recording != nullptr) return;
  std::map<std::filesystem::path, Ontology> ontologies;  // by scene file
  std::vector<std::filesystem::path> files;
  for (const Sequence& s : pipeline.sequences) files.push_back(s.sceneFile);
  if (!pipeline.vehicle.empty()) files.push_back(pipeline.vehicle);
  for (const std::filesystem::path& file : files) {
    if (ontologies.contains(file)) continue;
    const Ontology ontology = readSceneOntology(file);
    if (!ontologies.empty() && !sameClasses(ontology, ontologies.begin()->second)) {
      refuse(pipeline,
             fmt::format(
                 "the scenes {} and {} have different classes: name one ontology for all scenes by the key `labels`",
                 ontologies.begin()->first.string(), file.string()));
    }
    ontologies.emplace(file, ontology);
  }
}

// Returns the ontology of a pipeline that has no recording.
Ontology ontologyOf(const Pipeline& pipeline) {
  return pipeline.ontology.empty() ? readSceneOntology(pipeline.sequences.front().sceneFile)
                                   : readOntology(pipeline.ontology);
}

// True if the scans have labels from an ontology with separate classes for moving objects.
bool tellsMovingClasses(const Pipeline& pipeline) {
  if (pipeline.recording != nullptr || !pipeline.output.layout.columns.has(kLabel)) return false;
  const Ontology ontology = ontologyOf(pipeline);
  return std::ranges::any_of(ontology.classes, [](const SemanticClass& c) { return c.movingOf.has_value(); });
}

// Throws InputError if a class whose objects are to be listed is unknown or has no objects, or if the output needs what
// recordings lack: boxes or motions of objects, or geometry that no beam hit.
void checkObjects(const Pipeline& pipeline) {
  const ListedObjects listed = pipeline.output.objects.value_or(ListedObjects{});
  if (!listed.classes.empty() && pipeline.recording == nullptr) {
    const Ontology ontology = ontologyOf(pipeline);
    for (const std::string& name : listed.classes) {
      if (ontology.require(name, listed.where).thing) continue;
      throw InputError(listed.where, "the class '{}' has no objects, since it is not marked with `thing`", name);
    }
  }
  if (pipeline.recording == nullptr) return;
  const auto refuseMissing = [&](std::string_view missing, const std::string& key) {
    refuse(pipeline, fmt::format("a recording does not have {}: leave {} out, or trace the scene again", missing, key));
  };
  if (pipeline.output.objects) refuseMissing("the boxes of objects", "`output.objects`");
  if (pipeline.output.voxels) refuseMissing("the geometry that no beam hit", "`output.voxels`");
  for (std::size_t i = 0; i < kColumnCount; ++i) {
    if (!pipeline.output.layout.columns.has(i) || !dependsOnMotion(kColumns[i])) continue;
    refuseMissing("the motions of objects and of the sensor", fmt::format("the column {}", kColumns[i].name));
  }
}

// Throws InputError if the voxels of points cannot be computed. Without deskewing, each point of a moving sensor is in
// the sensor's frame at the time of its column, so that the column must be known to transform the point to the grid's
// frame.
void checkVoxels(const Pipeline& pipeline) {
  const bool skewed = pipeline.motion.kind != MotionKind::None && !pipeline.motion.deskew;
  if (!pipeline.output.voxels || !skewed || pipeline.output.layout.organised ||
      pipeline.output.layout.columns.has(kColumn))
    return;
  throw InputError(pipeline.motion.where,
                   "output.voxels: the voxels of points of a moving sensor depend on their columns: add `column` to "
                   "output.columns, or write `motion: {steps: per_column, deskew: true}`");
}

// Throws InputError if the beams differ from the recorded beams: recorded ranges would be combined with wrong
// directions.
void checkBeams(const Recording& recording, const MountedSensor& sensor, const BeamTable& beams) {
  for (const RecordedSensor& recorded : recording.sensors) {
    if (recorded.name != sensor.name || recorded.beams.empty() || recorded.beams == beamsHash(beams)) continue;
    throw InputError(sensor.description.where,
                     "the beams of '{}' differ in directions, origins or range limits from those of the "
                     "recording in {}: use the sensor that made the recording",
                     sensor.name, recording.folder.string());
  }
}

// Checks the random effects of the first frame of each sequence against the beams: Pipeline::effectCases() has the ends
// of each distribution, but not all combinations of random values.
void checkDraws(const Plan& plan) {
  const Pipeline& pipeline = plan.pipeline;
  if (pipeline.drawn == nullptr) return;
  for (std::size_t i = 0; i < pipeline.sequences.size(); ++i) {
    const SensorDraw drawn = pipeline.drawn->draw(pipeline, i, 0);
    for (std::size_t s = 0; s < plan.sensors.size(); ++s) {
      for (const ChosenEffect& effect : *drawn.effects[s]) effect->check(*plan.sensors[s].beams);
    }
  }
}

// Returns the channels of hits that the plan's effects and output read.
Channels channelsOf(const Pipeline& pipeline) {
  Channels channels;
  for (std::size_t s = 0; s < pipeline.sensors.size(); ++s) {
    for (const Effects* effects : pipeline.effectCases(s)) {
      channels |= channelsFor(*effects, pipeline.output.layout.columns);
    }
    if (anyLightPaths(pipeline, s)) channels |= kLightChannels;
  }
  if (pipeline.output.objects || tellsMovingClasses(pipeline)) channels |= Channel::Instance;
  // The material is needed to distinguish mirrors and glass from dark surfaces.
  if (pipeline.output.layout.reasons) channels |= Channel::Material;
  return channels;
}

// Throws InputError if a frame and the program need more memory than is allowed.
void checkFrameMemory(const Plan& plan) {
  const Pipeline& pipeline = plan.pipeline;
  const std::uint64_t rays = pipeline.raysPerFrame();
  const std::uint64_t bytes = rays * kBeamBytes + plan.bytesPerFrameInMemory();
  if (bytes + kProgramBytes <= memoryLimitBytes()) return;
  refuse(pipeline,
         fmt::format("{} {} per frame x {} bytes and {} of the program are {}, but only {} of memory are "
                     "allowed (by --memory-limit, the machine or its container): allow more, or take fewer "
                     "sensors, rings, columns or rays per beam",
                     rays, rays == pipeline.beamsPerFrame() ? "beams" : "rays", bytes / rays, shortBytes(kProgramBytes),
                     shortBytes(bytes + kProgramBytes), shortBytes(memoryLimitBytes())));
}

// Returns the beams and the footprint of a sensor. Throws InputError if the recording, the motion or the effects do not
// fit the beams.
PlannedSensor planSensor(const Pipeline& pipeline, std::size_t index) {
  const MountedSensor& sensor = pipeline.sensors[index];
  const std::shared_ptr<const BeamTable> beams = makeBeams(sensor.description);
  if (pipeline.recording != nullptr) checkBeams(*pipeline.recording, sensor, *beams);
  if (pipeline.motion.kind == MotionKind::Steps && pipeline.motion.steps > beams->columns) {
    throw InputError(pipeline.motion.where, "{} steps are more than the {} columns of '{}'", pipeline.motion.steps,
                     beams->columns, sensor.name);
  }
  for (const Effects* effects : pipeline.effectCases(index)) {
    for (const ChosenEffect& effect : *effects) effect->check(*beams);
  }
  if (sensor.size.sectors > 1 && pipeline.output.objects) {
    throw InputError(sensor.description.where,
                     "boxes of objects are not listed for '{}', whose turn is made in sectors: leave out `objects` of "
                     "the output (points have their instances all the same), or `sectors`",
                     sensor.name);
  }
  const std::uint32_t rays = pipeline.raysPerBeam(index);
  if (rays == 1) return {beams, nullptr};
  if (beams->rosette() == nullptr) return {beams, std::make_shared<const Footprint>(makeFootprint(*beams, rays))};
  throw InputError(sensor.description.where,
                   "the effect footprint cannot be applied to '{0}', whose beams change from revolution "
                   "to revolution: leave it out, or write `effects: sensor` and give each sensor its "
                   "own `effects`, without footprint for '{0}'",
                   sensor.name);
}

}  // namespace

Plan makePlan(Pipeline readPipeline, Channels recorded) {
  Plan plan{.pipeline = std::move(readPipeline), .sensors = {}, .channels = recorded};
  const Pipeline& pipeline = plan.pipeline;
  if (pipeline.recording != nullptr && pipeline.drawn != nullptr && pipeline.drawn->drawsMounts()) {
    refuse(pipeline,
           "the sensors of a recording cannot be moved: give each `mount` fixed values, or trace the scene again");
  }
  checkOntologies(pipeline);
  checkLightPaths(pipeline);
  checkObjects(pipeline);
  checkVoxels(pipeline);
  plan.channels |= channelsOf(pipeline);
  checkFrameMemory(plan);
  for (std::size_t s = 0; s < pipeline.sensors.size(); ++s) plan.sensors.push_back(planSensor(pipeline, s));
  if (!pipeline.vehicle.empty() && pipeline.recording != nullptr) {
    refuse(pipeline, fmt::format("the recording in {} has no data of a vehicle: leave out `vehicle`",
                                 pipeline.recording->folder.string()));
  }
  checkDraws(plan);
  return plan;
}

void Plan::requirePasses() const {
  requireOneRevolution();
  if (pipeline.method.entry->can.passes) return;
  refuse(pipeline, fmt::format("the method {} draws no passes to save: take `method: {}`", pipeline.methodName(),
                               firstMethodThat(&MethodCapabilities::passes).name));
}

void Plan::requireOneRevolution() const {
  if (pipeline.oneRevolution()) return;
  refuse(pipeline,
         "saved hits and passes have one revolution of each sensor in each sample, but these sensors turn at "
         "different rates, in sectors, or are chosen at random: save none, or scan with sensors of one rate");
}

void Plan::requireOneRay() const {
  requireOneRevolution();
  if (!pipeline.vehicle.empty()) {
    refuse(pipeline, "saved hits have only the scene, not the ego vehicle: save none, or leave out `vehicle`");
  }
  if (pipeline.drawn != nullptr && pipeline.drawn->drawsMounts()) {
    refuse(pipeline,
           "saved hits need the same mounts of sensors in all sequences: save none, or give each `mount` fixed values");
  }
  for (std::size_t s = 0; s < pipeline.sensors.size(); ++s) {
    if (pipeline.raysPerBeam(s) == 1 && !anyLightPaths(pipeline, s)) continue;
    refuse(pipeline,
           "the effects footprint and light_paths trace several rays per beam, but saved hits have one: save none, or "
           "leave these effects out");
  }
}

std::uint64_t Plan::bytesPerFrameInMemory() const {
  // Adds up the bytes of a revolution's hits, returns, scan and encoders' buffers, and the encoded bytes of this sample
  // and of another sample that waits to be written. Beam tables are not counted, since all frames share them.
  constexpr std::uint64_t kReturnBytes = 40;  // bytes of a row of Returns
  constexpr std::uint64_t kVoxelBytes = 20;   // bytes of a voxel: labels, area, flags, part of the encoded archive
  std::uint64_t bytesPerPoint = sizeof(Vec3f);
  for (std::size_t c = 0; c < kColumnCount; ++c) {
    if (pipeline.output.layout.columns.has(c)) bytesPerPoint += bytesOf(kColumns[c].type);
  }
  std::uint64_t bytesPerRay = 8;  // bytes of buffers that all methods need, without channels
  forEachChannel([&]<class T>(const ChannelRow& row, std::vector<T> Hits::*) {
    if (row.channel != Channel::Normal || channels.has(Channel::Normal)) bytesPerRay += sizeof(T);
  });
  const std::uint64_t returns = pipeline.mostReturns();
  const std::uint64_t bufferBytes = (kReturnBytes + 3 * bytesPerPoint) * returns * pipeline.beamsPerFrame();
  std::uint64_t encodedPoints = 0;
  std::uint64_t scanCount = 0;
  for (const MountedSensor& s : pipeline.sensors) {
    // The compressed points of all sectors need fewer bytes than one uncompressed point a beam.
    encodedPoints += s.beams() * s.revolutions * (s.size.sectors > 1 ? 1 : returns);
    scanCount += s.revolutions;
  }
  const std::uint64_t returnBytes = bufferBytes + 2 * pipeline.output.formats.size() * bytesPerPoint * encodedPoints;
  const std::uint64_t voxelBytes = pipeline.output.voxels ? kVoxelBytes * pipeline.output.voxels->voxels() : 0;
  return bytesPerRay * pipeline.raysPerFrame() + returnBytes + voxelBytes * scanCount;
}

std::size_t Plan::framesInFlight() const {
  const std::uint64_t freeBytes = memoryLimitBytes() - std::min(kProgramBytes, memoryLimitBytes());
  const std::uint64_t fittingFrames = freeBytes / 2 / bytesPerFrameInMemory();
  return std::clamp<std::uint64_t>(fittingFrames, 1, static_cast<std::uint64_t>(threadCount()));
}

std::uint64_t Plan::bytesInMemory(std::uint64_t scenes) const {
  return scenes + pipeline.raysPerFrame() * kBeamBytes + framesInFlight() * bytesPerFrameInMemory() + kProgramBytes;
}

void Plan::checkMemory(std::uint64_t bytes, const std::string& scene) const {
  const std::uint64_t needed = bytesInMemory(bytes);
  if (needed <= memoryLimitBytes()) return;
  refuse(pipeline, fmt::format("{} takes about {} with this method, {} with the frames in flight and the program, but "
                               "only {} of memory are allowed (by --memory-limit, the machine or its container): allow "
                               "more, or take a smaller scene, a coarser method, or fewer rings or columns",
                               scene, shortBytes(bytes), shortBytes(needed), shortBytes(memoryLimitBytes())));
}

ColumnSet Plan::columns() const {
  const ColumnSet columns = pipeline.output.layout.columns;
  return setsIntensity(pipeline) ? columns : columns.without(kIntensity).without(kPower);
}

}  // namespace scanmill
