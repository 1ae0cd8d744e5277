#include "pipeline/scenes/shot_source.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/parallel.h"
#include "base/path.h"
#include "pipeline/read/drawn_sensors.h"
#include "pipeline/scenes/ego_vehicle.h"
#include "pipeline/scenes/scene_probe.h"
#include "scene/surface_heights.h"
#include "scenefile/scene_file.h"

namespace scanmill {

namespace {

// True if the trajectory's poses can only be computed when its scene is loaded.
bool needsScene(const Trajectory& trajectory) {
  return trajectory.randomPath() != nullptr || trajectory.ground() != nullptr;
}

// Returns the points of a drive from one point to another. Throws InputError if they are too near for all frames.
std::vector<Vec3d> pathOfTrip(const Scene& scene, const RandomPath& drive) {
  SurfaceHeights heights(scene);
  heights.update();
  std::vector<Vec3d> way = findRoadPath(heights, scene.ontology, *drive.trip);
  const double length = Path(way).length();
  if (length >= drive.length) return way;
  const double missing = std::ceil((drive.length - length) / drive.perFrame);
  throw InputError(
      drive.trip->where,
      fmt::format("the path from `from` to `to` is {:.1f} m long, but {:.1f} m are needed: take {:.0f} frames "
                  "less, or a lower speed",
                  length, drive.length, missing));
}

// Returns the trajectory with its random path, if the trajectory has one, and with its poses moved onto the ground, if
// it asks for that. The path and the ground are found in the scene of `probe`. `seed`: determines the random path.
// Throws InputError if the scene has no suitable path or ground.
Trajectory inScene(const Trajectory& trajectory, const SceneProbe& probe, std::uint64_t seed) {
  Trajectory driven = trajectory;
  if (const RandomPath* random = trajectory.randomPath()) {
    driven = driven.along(random->trip ? pathOfTrip(probe.scene(), *random)
                                       : findRandomPath(probe, *random, seed, trajectory.name()));
  }
  if (const GroundOptions* ground = trajectory.ground()) {
    driven = driven.onGround(SceneGround(probe, classIds(probe.scene().ontology, ground->classes, ground->where)));
  }
  return driven;
}

// Returns the settings of a frame; an entry of `draw` replaces the mounts and effects in Pipeline::sensors.
FrameSettings settingsOf(const Pipeline& pipeline, const VehicleHits& vehicles, SensorDraw draw = {}) {
  FrameSettings settings;
  for (std::size_t s = 0; s < pipeline.sensors.size(); ++s) {
    const MountedSensor& sensor = pipeline.sensors[s];
    const auto& effects = draw.effects.empty() ? sensor.effects : draw.effects[s];
    settings.sensors.push_back({draw.mounts.empty() ? sensor.vehicleFromSensor : draw.mounts[s], effects,
                                pipeline.recording == nullptr ? lightPaths(*effects) : nullptr,
                                vehicles.empty() ? nullptr : vehicles[s]});
  }
  settings.draws = std::move(draw.draws);
  return settings;
}

VehicleHits hitsOf(const FrameSettings& settings) {
  VehicleHits hits;
  for (const SensorSetting& sensor : settings.sensors) hits.push_back(sensor.vehicle);
  return hits;
}

}  // namespace

std::unique_ptr<Method> makeMethod(const MethodChoice& choice, const Scene& scene) {
  Fields options(choice.options, "method " + std::string(choice.entry->name));
  options.alsoDescribed(choice.entry->keys).finish();
  if (scene.moves() && !choice.entry->can.moving) {
    throw InputError({scene.file.string()},
                     fmt::format("objects of this scene move, but the method {} cannot trace moving objects: write "
                                 "`moving: false` beside the scene in the pipeline, or take `method: {}`",
                                 choice.entry->name, firstMethodThat(&MethodCapabilities::moving).name));
  }
  return choice.entry->make(scene, options);
}

ShotSource::ShotSource(const Plan& plan, SceneChanges changes)
    : plan_(plan), pipeline_(plan.pipeline), changes_(std::move(changes)) {
  if (!pipeline_.vehicle.empty()) {
    const FilesRead read;
    vehicle_ = std::make_shared<const Scene>(
        readScene(pipeline_.vehicle, {.ontology = pipeline_.ontology, .wavelengthNm = pipeline_.wavelengthNm}));
    vehicleFiles_ = recordsOf(read, pipeline_.file.parent_path());
  }
  std::vector<Pose> mounts;
  for (const MountedSensor& sensor : pipeline_.sensors) mounts.push_back(sensor.vehicleFromSensor);
  vehicleHits_ = traceEgoVehicle(mounts);
  settings_ = std::make_shared<const FrameSettings>(settingsOf(pipeline_, vehicleHits_));
}

VehicleHits ShotSource::traceEgoVehicle(const std::vector<Pose>& mounts) const {
  VehicleHits hits;
  if (vehicle_ == nullptr) return hits;
  const std::shared_ptr<const Method> method = makeReference(*vehicle_);
  for (std::size_t s = 0; s < mounts.size(); ++s) {
    const auto trace = [scene = vehicle_, method, mount = mounts[s],
                        drop = pipeline_.dropVehicle](const BeamTable& rays) {
      BlockedRays found = traceVehicle(*method, rays, mount);
      found.dropped = drop;
      return found;
    };
    const PlannedSensor& sensor = plan_.sensors[s];
    const auto blocked =
        std::make_shared<BlockedRays>(trace(sensor.footprint == nullptr ? *sensor.beams : *sensor.footprint->rays));
    if (sensor.beams->rosette() != nullptr) blocked->ofRevolution = trace;
    hits.push_back(blocked);
  }
  return hits;
}

std::vector<double> ShotSource::blockedShares() const {
  std::vector<double> shares;
  for (const auto& vehicle : vehicleHits_) shares.push_back(vehicle->share());
  return shares;
}

Scene ShotSource::recordedScene(std::size_t sequence) const {
  const Recording& recording = *pipeline_.recording;
  Scene scene;
  scene.name = pipeline_.sequences[sequence].scene;
  scene.seed = pipeline_.sequences[sequence].sceneSeed;
  scene.procedural = true;  // a recording does not state this; with false, a warning about several seeds would appear
  scene.ontology = pipeline_.ontology.empty() ? recording.ontology : readOntology(pipeline_.ontology);
  scene.materials = recording.materials[recording.sequences[sequence].materials];
  const bool both = !pipeline_.ontology.empty() && !recording.ontology.classes.empty();
  if (both && !sameClasses(scene.ontology, recording.ontology)) {
    throw InputError({pipeline_.ontology.string()},
                     fmt::format("has other classes than the ontology '{}' of the recording in {}, whose class ids "
                                 "cannot be converted: leave out `labels`",
                                 recording.ontology.name, recording.folder.string()));
  }
  if (scene.ontology.classes.empty()) {
    throw InputError(
        {pipeline_.file.string()},
        fmt::format("the recording in {} has no ontology: name one by the key `labels`", recording.folder.string()));
  }
  return scene;
}

Scene ShotSource::load(std::size_t sequence) {
  if (pipeline_.recording != nullptr) return recordedScene(sequence);
  const Sequence& own = pipeline_.sequences[sequence];
  Scene scene = readScene(own.sceneFile, {.seed = own.sceneSeed,
                                          .ontology = pipeline_.ontology,
                                          .wavelengthNm = pipeline_.wavelengthNm,
                                          .textures = plan_.channels.has(Channel::Reflectance),
                                          .add = changes_.add});
  if (!own.moving) standStill(scene, 0);
  scene.placeable = changes_.placeable;
  // Before takeOut(), so that random paths do not depend on which objects are removed.
  findTrajectories(own, scene);
  takeOut(scene, own.without);
  return scene;
}

void ShotSource::findTrajectories(const Sequence& sequence, const Scene& scene) {
  std::optional<SceneProbe> probe;
  for (std::size_t s = 0; s < pipeline_.sequences.size(); ++s) {
    const Sequence& other = pipeline_.sequences[s];
    if (!other.sameScene(sequence) || !needsScene(*other.trajectory)) continue;
    {
      const std::scoped_lock lock(mutex_);
      if (trajectories_.contains(s)) continue;
    }
    if (!probe) probe.emplace(scene);
    auto found = std::make_shared<const Trajectory>(inScene(*other.trajectory, *probe, other.sceneSeed));
    const std::scoped_lock lock(mutex_);
    trajectories_.try_emplace(s, std::move(found));
  }
}

std::shared_ptr<const Trajectory> ShotSource::trajectory(std::size_t sequence) {
  const Sequence& own = pipeline_.sequences[sequence];
  if (!needsScene(*own.trajectory)) return own.trajectory;
  const auto find = [&] {
    const std::scoped_lock lock(mutex_);
    const auto known = trajectories_.find(sequence);
    return known == trajectories_.end() ? nullptr : known->second;
  };
  if (auto known = find()) return known;
  load(sequence);
  return find();
}

std::unique_ptr<Method> ShotSource::method(const Scene& scene) const {
  if (pipeline_.recording != nullptr) return makeRecordedMethod(pipeline_);
  return makeMethod(pipeline_.method, scene);
}

std::shared_ptr<const FrameSettings> ShotSource::settings(std::size_t sequence, std::uint32_t frame) {
  if (pipeline_.drawn == nullptr) return settings_;
  const DrawnSensors& sensors = *pipeline_.drawn;
  const auto isOwn = [&](const auto& drawn) { return drawn.first == sequence; };
  std::shared_ptr<const FrameSettings> known;  // of this frame or of another one of the sequence
  {
    const std::scoped_lock lock(mutex_);
    if (const auto* const found = drawn_.find(isOwn)) known = found->second;
  }
  if (known != nullptr && !sensors.drawsPerFrame()) return known;
  SensorDraw drawn = sensors.draw(pipeline_, sequence, frame);
  const VehicleHits vehicles = !sensors.drawsMounts() ? vehicleHits_
                               : known != nullptr     ? hitsOf(*known)  // mounts are the same in all frames
                                                      : traceEgoVehicle(drawn.mounts);
  const auto settings = std::make_shared<const FrameSettings>(settingsOf(pipeline_, vehicles, std::move(drawn)));
  // Two cached sequences per thread are enough, since each thread makes samples of one sequence at a time.
  const auto most = 2 * static_cast<std::size_t>(threadCount());
  const std::scoped_lock lock(mutex_);
  return drawn_.findOrAdd(isOwn, most, [&] { return std::pair{sequence, settings}; }).second = settings;
}

Shot ShotSource::recordedShot(const std::string& sample, std::uint32_t frame, std::size_t sensor) const {
  const std::shared_ptr<const BeamTable>& beams = plan_.sensors[sensor].beams;
  RecordedShot recorded = pipeline_.recording->shot(sample, pipeline_.sensors[sensor].name);
  if (recorded.worldFromSensor.size() > beams->columns) {
    throw InputError({pipeline_.recording->folder.string()},
                     fmt::format("{} of '{}' has {} poses, more than the {} columns of the sensor", sample,
                                 recorded.sensor, recorded.worldFromSensor.size(), beams->columns));
  }
  Shot shot;
  shot.frame = frame;
  shot.time = recorded.time;
  shot.beams = beamsAt(beams, recorded.time);
  shot.worldFromSensor = std::move(recorded.worldFromSensor);
  shot.deskew = pipeline_.motion.deskew;
  return shot;
}

Frame ShotSource::frame(std::size_t sequence, std::uint32_t number, Revolutions revolutions) {
  const Sequence& own = pipeline_.sequences[sequence];
  const bool recorded = pipeline_.recording != nullptr;
  const std::string sample = own.key(number);
  const std::shared_ptr<const Trajectory> driven = recorded ? nullptr : trajectory(sequence);
  Frame frame{settings(sequence, number), recorded ? 0 : driven->frameTime(number), {}};
  for (std::size_t s = 0; s < plan_.sensors.size(); ++s) {
    const double period = pipeline_.sensors[s].period;
    std::vector<double> begins{0};  // s after the frame's time, of the sensor's revolutions
    if (revolutions == Revolutions::All && !recorded) begins = own.revolutions(number, period, pipeline_.periods);
    for (std::size_t r = 0; r < begins.size(); ++r) {
      Shot shot = recorded ? recordedShot(sample, number, s)
                           : makeShot(plan_.sensors[s].beams, *driven, number,
                                      frame.settings->sensors[s].vehicleFromSensor, pipeline_.motion, begins[r]);
      if (r + 1 < begins.size() || own.turnsWithoutBreak(pipeline_.periods)) shot.untilNext = period;
      if (r > 0) shot.untilNext = std::max(shot.untilNext, period);  // of a single frame
      shot.sample = sample;
      shot.seed = pipeline_.seed;
      shot.scene = static_cast<std::uint32_t>(sequence);
      shot.sensor = static_cast<std::uint32_t>(s);
      shot.revolution = static_cast<std::uint32_t>(r);
      shot.sensorName = pipeline_.sensors[s].name;
      frame.shots.push_back(std::move(shot));
    }
  }
  if (recorded) frame.time = frame.shots.front().time;
  return frame;
}

}  // namespace scanmill
