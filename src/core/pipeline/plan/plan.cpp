#include "pipeline/plan/plan.h"

#include <fmt/core.h>

#include <algorithm>
#include <map>

#include "base/memory.h"
#include "base/parallel.h"
#include "base/short_text.h"
#include "methods/interface/light_paths.h"
#include "pipeline/drive/drive.h"
#include "pipeline/plan/own_vehicle.h"
#include "pipeline/plan/recorded_method.h"
#include "pipeline/plan/scene_shares.h"
#include "scene/without.h"
#include "scenefile/scene_file.h"

namespace scanmill {

namespace {

// The method of a pipeline that names one; null where `auto` is still to choose, or the hits come from a recording.
const MethodEntry* methodOf(const Pipeline& pipeline) {
  return pipeline.recording == nullptr ? pipeline.method.entry : nullptr;
}

void checkMotion(const Pipeline& pipeline) {
  const MethodEntry* const method = methodOf(pipeline);
  if (pipeline.motion.kind == MotionKind::None || method == nullptr || method->can.motion) return;
  throw InputError(pipeline.motion.where,
                   fmt::format("the method {} gives a whole revolution one pose: leave the motion out, or take "
                               "`method: {}`",
                               method->name, firstMethodThat(&MethodCapabilities::motion).name));
}

// Whether rays of a sensor go on behind what they meet, in any sequence.
bool anyLightPaths(const Pipeline& pipeline, std::size_t sensor) {
  if (pipeline.lightPaths(sensor) != nullptr) return true;
  if (pipeline.drawn == nullptr || pipeline.recording != nullptr) return false;
  const auto& cases = pipeline.drawn->cases();
  return std::any_of(cases.begin(), cases.end(),
                     [&](const SensorDraw& one) { return lightPaths(one.effects[sensor].effects) != nullptr; });
}

// What effects ask of the method.
void checkRays(const Pipeline& pipeline) {
  const MethodEntry* const method = methodOf(pipeline);
  const auto want = [&](bool wanted, bool MethodCapabilities::*can, std::string_view effect, std::string_view what) {
    if (!wanted) return;
    if (method != nullptr && method->can.*can) return;
    throw InputError({pipeline.file.string()},
                     fmt::format("the method {} {}: leave the effect {} out, or take `method: {}`",
                                 pipeline.methodName(), what, effect, firstMethodThat(can).name));
  };
  for (std::size_t s = 0; s < pipeline.sensors.size(); ++s) {
    want(pipeline.raysPerBeam(s) > 1, &MethodCapabilities::footprints, "footprint", "fires one ray a beam");
    want(anyLightPaths(pipeline, s), &MethodCapabilities::transmission, "light_paths",
         "ends rays at what they meet first");
  }
}

constexpr std::uint64_t kProgramBytes = std::uint64_t{72} << 20;  // itself, its libraries and what threads keep
constexpr std::uint64_t kBeamBytes = sizeof(Vec3d) + sizeof(Vec3f) + sizeof(float);  // of a beam table

bool sameClasses(const Ontology& a, const Ontology& b) {
  return std::equal(a.classes.begin(), a.classes.end(), b.classes.begin(), b.classes.end(),
                    [](const SemanticClass& x, const SemanticClass& y) {
                      return x.id == y.id && x.name == y.name && x.thing == y.thing;
                    });
}

// A dataset has one ontology. The scene files are read for their ontology alone, so that one that is absent or differs
// is known before hours of work.
void checkOntologies(const Pipeline& pipeline) {
  if (!pipeline.ontology.empty() || pipeline.recording != nullptr) return;
  std::map<std::filesystem::path, Ontology> known;  // by scene file
  std::vector<std::filesystem::path> files;
  for (const Sequence& s : pipeline.sequences) files.push_back(s.sceneFile);
  if (!pipeline.vehicle.empty()) files.push_back(pipeline.vehicle);
  for (const std::filesystem::path& file : files) {
    if (known.contains(file)) continue;
    const Ontology ontology = readSceneOntology(file);
    if (!known.empty() && !sameClasses(ontology, known.begin()->second)) {
      throw InputError({pipeline.file.string()},
                       fmt::format("the scenes {} and {} have different classes: name one ontology for all with the "
                                   "key `labels`",
                                   known.begin()->first.string(), file.string()));
    }
    known.emplace(file, ontology);
  }
}

// Whether points on things that move have classes of their own.
bool tellsMovingClasses(const Pipeline& pipeline) {
  if (pipeline.recording != nullptr || !pipeline.layout.columns.has(kLabel)) return false;
  const Ontology ontology = pipeline.ontology.empty() ? readSceneOntology(pipeline.sequences.front().sceneFile)
                                                      : readOntology(pipeline.ontology);
  return std::any_of(ontology.classes.begin(), ontology.classes.end(),
                     [](const SemanticClass& c) { return c.movingOf.has_value(); });
}

// A recording does not know where objects are, and how they move.
void checkObjects(const Pipeline& pipeline) {
  if (pipeline.recording == nullptr) return;
  if (pipeline.objects) {
    throw InputError({pipeline.file.string()},
                     "a recording does not know the boxes of objects: leave `output.objects` out, or trace anew");
  }
  if (pipeline.voxels) {
    throw InputError({pipeline.file.string()},
                     "a recording does not know what stands where no beam went: leave `output.voxels` out, or trace "
                     "anew");
  }
  for (std::size_t i = 0; i < kColumnCount; ++i) {
    const std::string_view name = kColumns[i].name;
    if (!pipeline.layout.columns.has(i) || !(name.starts_with("velocity_") || name.starts_with("flow_"))) continue;
    throw InputError(
        {pipeline.file.string()},
        fmt::format("a recording does not say how objects moved: leave the column {} out, or trace anew", name));
  }
}

// Points of a sensor that moves lie in the frames of their columns, voxels in one.
void checkVoxels(const Pipeline& pipeline) {
  const bool skewed = pipeline.motion.kind != MotionKind::None && !pipeline.motion.deskew;
  if (!pipeline.voxels || !skewed || pipeline.layout.organised || pipeline.layout.columns.has(kColumn)) return;
  throw InputError(pipeline.motion.where,
                   "output.voxels: which voxels points of a moving sensor lie in follows from their columns: name "
                   "`column` in output.columns, or say `motion: {steps: per_column, deskew: true}`");
}

// What was recorded belongs to certain beams: other directions would bend the cloud.
void checkBeams(const Recording& recording, const MountedSensor& sensor, const BeamTable& beams) {
  for (const RecordedSensor& recorded : recording.sensors) {
    if (recorded.name != sensor.name || recorded.beams.empty() || recorded.beams == beamsHash(beams)) continue;
    throw InputError(sensor.description.where,
                     fmt::format("the beams of '{}' differ from those of the recording in {} (their directions, "
                                 "origins or range limits): take the sensor that it was made with",
                                 sensor.name, recording.folder.string()));
  }
}

}  // namespace

std::unique_ptr<Method> makeMethod(const MethodChoice& choice, const Scene& scene) {
  if (choice.entry == nullptr) throw Error("`method: auto`: the method is still to be chosen");
  Fields options(choice.options, "method " + std::string(choice.entry->name));
  options.alsoDescribed(choice.entry->keys).finish();
  if (scene.moves() && !choice.entry->can.moving) {
    throw InputError({scene.file.string()},
                     fmt::format("objects of this scene move, and the method {} takes them as standing still: say "
                                 "`moving: false` beside the scene in the pipeline, or take `method: {}`",
                                 choice.entry->name, firstMethodThat(&MethodCapabilities::moving).name));
  }
  return choice.entry->make(scene, options);
}

Plan::Plan(Pipeline pipeline, Channels kept) : pipeline_(std::move(pipeline)) {
  if (pipeline_.recording != nullptr && pipeline_.drawn != nullptr && pipeline_.drawn->drawsMounts()) {
    throw InputError({pipeline_.file.string()},
                     "what was recorded cannot be moved: draw no `mount` of a sensor, or trace anew");
  }
  checkOntologies(pipeline_);
  checkMotion(pipeline_);
  checkRays(pipeline_);
  checkObjects(pipeline_);
  checkVoxels(pipeline_);
  for (std::size_t s = 0; s < pipeline_.sensors.size(); ++s) {
    channels_ |= channelsFor(pipeline_.effectsOf(s), pipeline_.layout.columns);
    if (anyLightPaths(pipeline_, s)) channels_ |= kLightChannels;
  }
  addDrawnChannels();
  if (pipeline_.objects || tellsMovingClasses(pipeline_)) channels_ |= Channel::Instance;
  if (pipeline_.layout.reasons) channels_ |= Channel::Material;  // tells mirrors and glass from what is dark
  traced_ = channels_ | kept;
  const std::uint64_t rays = pipeline_.raysPerFrame();
  const std::uint64_t bytes = rays * kBeamBytes + bytesPerFrameInMemory();
  if (bytes + kProgramBytes > memoryLimitBytes()) {
    throw InputError(
        {pipeline_.file.string()},
        fmt::format("{} {} a frame x {} bytes and {} of the program are {}, but it may take {} of memory "
                    "(--memory-limit, or what the machine or its container allows): allow more, or take fewer sensors, "
                    "rings, columns or rays a beam",
                    rays, rays == pipeline_.beamsPerFrame() ? "beams" : "rays", bytes / rays,
                    shortBytes(static_cast<double>(kProgramBytes)),
                    shortBytes(static_cast<double>(bytes + kProgramBytes)),
                    shortBytes(static_cast<double>(memoryLimitBytes()))));
  }
  for (const MountedSensor& sensor : pipeline_.sensors) {
    beams_.push_back(makeBeams(sensor.description));
    if (pipeline_.recording != nullptr) checkBeams(*pipeline_.recording, sensor, *beams_.back());
    if (pipeline_.motion.kind == MotionKind::Steps && pipeline_.motion.steps > beams_.back()->columns) {
      throw InputError(pipeline_.motion.where,
                       fmt::format("{} steps are more than the {} columns of '{}'", pipeline_.motion.steps,
                                   beams_.back()->columns, sensor.name));
    }
    const std::size_t s = beams_.size() - 1;
    for (const auto& effect : pipeline_.effectsOf(s)) effect->check(*beams_.back());
    const std::uint32_t raysPerBeam = pipeline_.raysPerBeam(s);
    if (beams_.back()->rosette && (raysPerBeam > 1 || !pipeline_.vehicle.empty())) {
      throw InputError(sensor.description.where,
                       fmt::format("the beams of '{}' differ from revolution to revolution: leave out {}", sensor.name,
                                   raysPerBeam > 1 ? "the effect footprint" : "`vehicle`"));
    }
    footprints_.push_back(
        raysPerBeam == 1 ? nullptr : std::make_shared<const Footprint>(makeFootprint(*beams_.back(), raysPerBeam)));
  }
  readOwnVehicle();
  std::vector<Pose> mounts;
  for (const MountedSensor& sensor : pipeline_.sensors) mounts.push_back(sensor.vehicleFromSensor);
  settings_ = settingsOf(pipeline_, traceOwnVehicle(mounts));
  checkDraws();
}

// What the effects read, in all cases of what is drawn.
void Plan::addDrawnChannels() {
  if (pipeline_.drawn == nullptr) return;
  for (const SensorDraw& one : pipeline_.drawn->cases()) {
    for (const SensorEffects& effects : one.effects) {
      channels_ |= channelsFor(effects.effects, pipeline_.layout.columns);
    }
  }
}

// Ends alone do not tell how drawn numbers go together: what is drawn for each sequence is made once.
void Plan::checkDraws() const {
  if (pipeline_.drawn == nullptr) return;
  const auto check = [&](const SensorDraw& one) {
    for (std::size_t s = 0; s < beams_.size(); ++s) {
      for (const auto& effect : one.effects[s].effects) effect->check(*beams_[s]);
    }
  };
  for (const SensorDraw& one : pipeline_.drawn->cases()) check(one);
  for (std::size_t s = 0; s < pipeline_.sequences.size(); ++s) check(pipeline_.drawn->draw(pipeline_, s, 0));
}

void Plan::readOwnVehicle() {
  if (pipeline_.vehicle.empty()) return;
  if (pipeline_.recording != nullptr) {
    throw InputError({pipeline_.file.string()},
                     fmt::format("the recording in {} knows nothing of a vehicle: leave out `vehicle`",
                                 pipeline_.recording->folder.string()));
  }
  SceneOptions options;
  options.ontology = pipeline_.ontology;
  options.wavelengthNm = pipeline_.wavelengthNm;
  vehicle_ = std::make_shared<const Scene>(readScene(pipeline_.vehicle, options));
}

VehicleHits Plan::traceOwnVehicle(const std::vector<Pose>& mounts) const {
  if (vehicle_ == nullptr) return nullptr;
  auto hits = std::make_shared<std::vector<Hits>>();
  for (std::size_t s = 0; s < mounts.size(); ++s) {
    const BeamTable& rays = footprints_[s] == nullptr ? *beams_[s] : *footprints_[s]->rays;
    hits->push_back(traceVehicle(*vehicle_, rays, mounts[s]));
  }
  return hits;
}

std::shared_ptr<const FrameSettings> Plan::settings(std::size_t sequence, std::uint32_t frame) const {
  if (pipeline_.drawn == nullptr) return {std::shared_ptr<const FrameSettings>(), &settings_};
  return drawn_->of(pipeline_, sequence, frame, settings_.vehicles,
                    [&](const std::vector<Pose>& mounts) { return traceOwnVehicle(mounts); });
}

Scene Plan::recordedScene(const Sequence& sequence) const {
  const Recording& recording = *pipeline_.recording;
  const auto index = static_cast<std::size_t>(&sequence - pipeline_.sequences.data());
  Scene scene;
  scene.name = sequence.scene;
  scene.seed = sequence.sceneSeed;
  scene.procedural = true;  // for all that is known
  scene.ontology = pipeline_.ontology.empty() ? recording.ontology : readOntology(pipeline_.ontology);
  scene.materials = recording.materials[recording.sequences[index].materials];
  const bool both = !pipeline_.ontology.empty() && !recording.ontology.classes.empty();
  if (both && !sameClasses(scene.ontology, recording.ontology)) {
    throw InputError({pipeline_.ontology.string()},
                     fmt::format("has other classes than the ontology '{}' to which the ids in the recording in {} "
                                 "belong, and ids are not translated: leave out `labels`",
                                 recording.ontology.name, recording.folder.string()));
  }
  if (scene.ontology.classes.empty()) {
    throw InputError(
        {pipeline_.file.string()},
        fmt::format("the recording in {} has no ontology: name one with the key `labels`", recording.folder.string()));
  }
  return scene;
}

Scene Plan::loadScene(const Sequence& sequence) const {
  if (pipeline_.recording != nullptr) return recordedScene(sequence);
  SceneOptions options;
  options.seed = sequence.sceneSeed;
  options.ontology = pipeline_.ontology;
  options.wavelengthNm = pipeline_.wavelengthNm;
  options.textures = traced_.has(Channel::Reflectance);
  Scene scene = readSceneToShares(sequence.sceneFile, options);
  if (!sequence.moving) standStill(scene, 0);
  findDrives(sequence, scene);  // of the whole scene: the ways are the same whatever is taken out
  takeOut(scene, sequence.without);
  return scene;
}

void Plan::findDrives(const Sequence& sequence, const Scene& scene) const {
  std::optional<SceneProbe> probe;
  for (std::size_t s = 0; s < pipeline_.sequences.size(); ++s) {
    const Sequence& other = pipeline_.sequences[s];
    if (!other.sameScene(sequence) || !needsScene(*other.trajectory)) continue;
    const std::scoped_lock lock(drives_->mutex);
    if (drives_->known.contains(s)) continue;
    if (!probe) probe.emplace(scene);
    drives_->known[s] = std::make_shared<const Trajectory>(inScene(*other.trajectory, *probe, other.sceneSeed));
  }
}

std::shared_ptr<const Trajectory> Plan::drive(std::size_t sequence) const {
  const Sequence& own = pipeline_.sequences[sequence];
  if (!needsScene(*own.trajectory)) return own.trajectory;
  const auto find = [&] {
    const std::scoped_lock lock(drives_->mutex);
    const auto known = drives_->known.find(sequence);
    return known == drives_->known.end() ? nullptr : known->second;
  };
  if (auto known = find()) return known;
  loadScene(own);
  return find();
}

std::unique_ptr<Method> Plan::makeMethod(const Scene& scene) const {
  if (pipeline_.recording != nullptr) return makeRecordedMethod(pipeline_);
  return scanmill::makeMethod(pipeline_.method, scene);
}

void Plan::requirePasses() const {
  if (pipeline_.recording != nullptr) {
    throw InputError({pipeline_.file.string()},
                     fmt::format("the scans are made of the {} in {}: no passes are drawn "
                                 "that could be kept",
                                 nameOf(pipeline_.recording->kind), pipeline_.recording->folder.string()));
  }
  const MethodEntry* const method = methodOf(pipeline_);
  if (method != nullptr && method->can.passes) return;
  const std::string_view instead = firstMethodThat(&MethodCapabilities::passes).name;
  if (method == nullptr) {
    throw InputError(pipeline_.method.options.where,
                     fmt::format("method auto may choose one that draws no passes: take `method: {}`", instead));
  }
  throw InputError(
      {pipeline_.file.string()},
      fmt::format("the method {} draws no passes that could be kept: take `method: {}`", method->name, instead));
}

void Plan::requireOneRay() const {
  if (!pipeline_.vehicle.empty()) {
    throw InputError({pipeline_.file.string()},
                     "kept hits and passes are of the scene alone: keep none, or leave out `vehicle`");
  }
  if (pipeline_.drawn != nullptr && pipeline_.drawn->drawsMounts()) {
    throw InputError({pipeline_.file.string()},
                     "kept hits and passes are of sensors that are mounted alike in all sequences: keep none, or draw "
                     "no mount");
  }
  bool one = true;
  for (std::size_t s = 0; s < pipeline_.sensors.size(); ++s) {
    one = one && pipeline_.raysPerBeam(s) == 1 && !anyLightPaths(pipeline_, s);
  }
  if (!one) {
    throw InputError(
        {pipeline_.file.string()},
        "the effects footprint and light_paths fire several rays a beam, but kept hits and passes hold one: "
        "keep none, or leave them out");
  }
  if (pipeline_.recording != nullptr || pipeline_.method.entry == nullptr || !pipeline_.method.entry->can.severalHits) {
    return;
  }
  throw InputError({pipeline_.file.string()},
                   fmt::format("the method {} fires several rays a beam, but kept hits hold one: keep none, or take "
                               "`method: {}`",
                               pipeline_.methodName(), firstMethodThat(&MethodCapabilities::reference).name));
}

void Plan::choose(MethodChoice choice, MethodRecord record) {
  pipeline_.method = std::move(choice);
  checkMotion(pipeline_);
  checkRays(pipeline_);
  chosen_ = std::move(record);
}

Shot Plan::recordedShot(const std::string& sample, std::uint32_t frame, std::size_t sensor) const {
  RecordedShot recorded = pipeline_.recording->shot(sample, pipeline_.sensors[sensor].name);
  if (recorded.worldFromSensor.size() > beams_[sensor]->columns) {
    throw InputError({pipeline_.recording->folder.string()},
                     fmt::format("{} of '{}' has {} poses for {} columns", sample, recorded.sensor,
                                 recorded.worldFromSensor.size(), beams_[sensor]->columns));
  }
  Shot shot;
  shot.frame = frame;
  shot.time = recorded.time;
  shot.beams = beamsAt(beams_[sensor], recorded.time);
  shot.worldFromSensor = std::move(recorded.worldFromSensor);
  shot.deskew = pipeline_.motion.deskew;
  return shot;
}

std::vector<Shot> Plan::shots(std::size_t sequence, std::uint32_t frame) const {
  const Sequence& own = pipeline_.sequences[sequence];
  const std::string sample = own.key(frame);
  const std::shared_ptr<const Trajectory> driven = pipeline_.recording != nullptr ? nullptr : drive(sequence);
  const std::shared_ptr<const FrameSettings> set = settings(sequence, frame);
  std::vector<Shot> shots;
  for (std::size_t s = 0; s < beams_.size(); ++s) {
    Shot shot = pipeline_.recording != nullptr
                    ? recordedShot(sample, frame, s)
                    : makeShot(beams_[s], *driven, frame, set->sensors[s].vehicleFromSensor, pipeline_.motion);
    shot.sample = sample;
    shot.seed = pipeline_.seed;
    shot.scene = static_cast<std::uint32_t>(sequence);
    shot.sensor = static_cast<std::uint32_t>(s);
    shot.sensorName = pipeline_.sensors[s].name;
    shots.push_back(std::move(shot));
  }
  return shots;
}

std::uint64_t Plan::bytesPerFrameInMemory() const {
  // Hits, returns, scan, what its encoder works on, and encoded bytes, of which a second sample may wait; the beam
  // tables are shared by all frames.
  constexpr std::uint64_t kReturnBytes = 40;
  std::uint64_t perPoint = sizeof(Vec3f);
  for (std::size_t c = 0; c < kColumnCount; ++c) {
    if (pipeline_.layout.columns.has(c)) perPoint += bytesOf(kColumns[c].type);
  }
  const std::uint64_t perRay = 4 + (traced_.has(Channel::Normal) ? 12 : 0) + 20 + 8;
  const std::uint64_t perReturn = kReturnBytes + (3 + 2 * pipeline_.formats.size()) * perPoint;
  const std::uint64_t reported = perReturn * pipeline_.mostReturns() * pipeline_.beamsPerFrame();
  constexpr std::uint64_t kVoxelBytes = 20;  // labels, areas, flags, and the archive of them
  const std::uint64_t voxels = pipeline_.voxels ? kVoxelBytes * pipeline_.voxels->voxels() : 0;
  return perRay * pipeline_.raysPerFrame() * pipeline_.mostMet() + reported + voxels * pipeline_.sensors.size();
}

std::size_t Plan::framesInFlight() const {
  const std::uint64_t free = memoryLimitBytes() - std::min(kProgramBytes, memoryLimitBytes());
  const std::uint64_t fitting = free / 2 / bytesPerFrameInMemory();
  return std::clamp<std::uint64_t>(fitting, 1, static_cast<std::uint64_t>(threadCount()));
}

std::uint64_t Plan::bytesInMemory(std::uint64_t scenes) const {
  return scenes + pipeline_.raysPerFrame() * kBeamBytes + framesInFlight() * bytesPerFrameInMemory() + kProgramBytes;
}

void Plan::checkMemory(std::uint64_t bytes, const std::string& scene) const {
  const std::uint64_t needed = bytesInMemory(bytes);
  if (needed <= memoryLimitBytes()) return;
  throw InputError(
      {pipeline_.file.string()},
      fmt::format(
          "{} takes about {} with this method, {} with frames in flight and the program, but it may "
          "take {} of memory (--memory-limit, or what the machine or its container allows): allow more, or take a "
          "smaller scene, a coarser method, or fewer rings or columns",
          scene, shortBytes(static_cast<double>(bytes)), shortBytes(static_cast<double>(needed)),
          shortBytes(static_cast<double>(memoryLimitBytes()))));
}

ColumnSet Plan::columns() const {
  const ColumnSet asked = pipeline_.layout.columns;
  return setsIntensity(pipeline_) ? asked : asked.without(kIntensity).without(kPower);
}

}  // namespace scanmill
