#include "pipeline/scenes/shot_source.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/parallel.h"
#include "base/path.h"
#include "pipeline/read/drawn_sensors.h"
#include "pipeline/scenes/scene_probe.h"
#include "scene/surface_heights.h"
#include "scenefile/scene_file.h"

namespace scanmill {
namespace {

// True if the trajectory's poses can only be computed when its scene is loaded.
bool needsScene(const Trajectory& trajectory) {
  return trajectory.randomPath() != nullptr || trajectory.ground() != nullptr;
}

// Returns the points of a drive from one point to another. Throws InputError if the path is too short for all frames.
std::vector<Vec3d> pathOfTrip(const Scene& scene, const RandomPath& drive) {
  SurfaceHeights heights(scene);
  heights.update();
  std::vector<Vec3d> points = findRoadPath(heights, scene.ontology, *drive.trip);
  const double length = Path(points).length();
  if (length >= drive.length) return points;
  const double missing = std::ceil((drive.length - length) / drive.perFrame);
  throw InputError(drive.trip->where, fmt::format("the path from `from` to `to` is {:.1f} m long, but {:.1f} m are "
                                                  "needed: take {:.0f} frames less, or a lower speed",
                                                  length, drive.length, missing));
}

// Places trajectories in a scene, whose hierarchies it builds when a trajectory first needs them.
class TrajectoryPlacer {
 public:
  explicit TrajectoryPlacer(const Scene& scene) : scene_(scene) {}

  // Returns the trajectory along its random path, if it has one, and moved onto the ground if it has GroundOptions.
  // `seed`: determines the random path. Throws InputError if the scene has no suitable path or ground.
  Trajectory place(const Trajectory& trajectory, std::uint64_t seed) {
    Trajectory result = trajectory;
    if (const RandomPath* request = trajectory.randomPath()) {
      if (!request->trip && !probe_) probe_.emplace(scene_);
      result = result.along(request->trip ? pathOfTrip(scene_, *request)
                                          : findRandomPath(*probe_, *request, seed, trajectory.name()));
    }
    if (const GroundOptions* ground = trajectory.ground()) {
      const std::vector<std::uint16_t> classes = classIds(scene_.ontology, ground->classes, ground->where);
      result = result.onGround(grounds_.try_emplace(classes, scene_, classes).first->second);
    }
    return result;
  }

 private:
  const Scene& scene_;
  std::optional<SceneProbe> probe_;
  std::map<std::vector<std::uint16_t>, SceneGround> grounds_;  // by class ids
};

// Returns the settings of a frame. Mounts and effects in `draw`, if not empty, replace those in Pipeline::sensors.
FrameSettings settingsOf(const Pipeline& pipeline, const VehicleHits& vehicles, SensorDraw draw = {}) {
  FrameSettings settings;
  for (std::size_t s = 0; s < pipeline.sensors.size(); ++s) {
    const MountedSensor& sensor = pipeline.sensors[s];
    const auto& effects = draw.effects.empty() ? sensor.effects : draw.effects[s];
    settings.sensors.push_back({.vehicleFromSensor = draw.mounts.empty() ? sensor.vehicleFromSensor : draw.mounts[s],
                                .scans = draw.scans.empty() || draw.scans[s],
                                .effects = effects,
                                .paths = pipeline.recording == nullptr ? lightPaths(*effects) : nullptr,
                                .vehicle = vehicles.empty() ? nullptr : vehicles[s]});
  }
  settings.draws = std::move(draw.draws);
  return settings;
}

VehicleHits hitsOf(const FrameSettings& settings) {
  VehicleHits hits;
  for (const SensorSetting& sensor : settings.sensors) hits.push_back(sensor.vehicle);
  return hits;
}

constexpr std::uint32_t kRaysAtOnce = 1 << 16;  // about the number of rays that are traced at a time

// Copies `count` rings of a table to `part`, starting with the ring `firstRing`.
void copyRings(const BeamTable& table, std::uint32_t firstRing, std::uint32_t count, BeamTable& part) {
  part.rings = count;
  part.columns = table.columns;
  part.raysPerBeam = table.raysPerBeam;
  part.maxRange = table.maxRange;
  part.period = table.period;
  const auto copy = [&](const auto& values, auto& partValues) {  // empty, or as many values for each ring
    if (values.empty()) return;
    const std::size_t perRing = values.size() / table.rings;
    const auto first = values.begin() + static_cast<std::ptrdiff_t>(firstRing * perRing);
    partValues.assign(first, first + static_cast<std::ptrdiff_t>(count * perRing));
  };
  copy(table.elevation, part.elevation);
  copy(table.direction, part.direction);
  copy(table.origin, part.origin);
  copy(table.time, part.time);
}

// Returns the rays of a sensor's beam table that hit the vehicle, even if the hits are below the sensor's minimum
// range. `vehicle`: traces the vehicle's scene, in the vehicle's frame. Traces some rings at a time, which saves
// memory: few rays hit the vehicle, and only their hits are kept.
BlockedRays traceVehicle(const Method& vehicle, const BeamTable& rays, const Pose& vehicleFromSensor) {
  BlockedRays blocked;
  blocked.range.reserve(rays.size());
  blocked.hits.reset(0, 0, Channels::all());
  Shot shot;
  shot.worldFromSensor = {vehicleFromSensor};
  const auto table = std::make_shared<BeamTable>();
  shot.beams = table;
  Hits hits;
  const std::uint32_t ringsAtOnce = std::max(1u, kRaysAtOnce / rays.columns);
  for (std::uint32_t ring = 0; ring < rays.rings; ring += ringsAtOnce) {
    copyRings(rays, ring, std::min(ringsAtOnce, rays.rings - ring), *table);
    vehicle.trace(shot, Channels::all(), hits);
    const std::size_t firstRay = blocked.range.size();
    blocked.range.insert(blocked.range.end(), hits.range.begin(), hits.range.end());
    for (std::size_t ray = 0; ray < hits.rays(); ++ray) {
      if (!hits.hit(ray)) continue;
      blocked.blocked.push_back(static_cast<std::uint32_t>(firstRay + ray));
      forEachChannel([&](const ChannelRow&, auto member) { (blocked.hits.*member).push_back((hits.*member)[ray]); });
    }
  }
  return blocked;
}

}  // namespace

std::unique_ptr<Method> makeMethod(const MethodChoice& choice, const Scene& scene) {
  Fields options(choice.options, "method " + std::string(choice.entry->name));
  if (scene.moves() && !choice.entry->can.moving) {
    throw InputError({scene.file.string()},
                     "objects of this scene move, but the method {} cannot trace moving objects: write "
                     "`moving: false` beside the scene in the pipeline, or take `method: {}`",
                     choice.entry->name, firstMethodThat(&MethodCapabilities::moving).name);
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
    const auto traceRays = [scene = vehicle_, method, mount = mounts[s],
                            drop = pipeline_.dropVehicle](const BeamTable& rays) {
      BlockedRays blockedRays = traceVehicle(*method, rays, mount);
      blockedRays.dropped = drop;
      return blockedRays;
    };
    const PlannedSensor& sensor = plan_.sensors[s];
    const auto blocked =
        std::make_shared<BlockedRays>(traceRays(sensor.footprint == nullptr ? *sensor.beams : *sensor.footprint->rays));
    if (sensor.beams->changes()) blocked->ofRevolution = traceRays;
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
  const bool hasTwoOntologies = !pipeline_.ontology.empty() && !recording.ontology.classes.empty();
  if (hasTwoOntologies && !sameClasses(scene.ontology, recording.ontology)) {
    throw InputError({pipeline_.ontology.string()},
                     "has other classes than the ontology '{}' of the recording in {}, whose class ids "
                     "cannot be converted: leave out `labels`",
                     recording.ontology.name, recording.folder.string());
  }
  if (scene.ontology.classes.empty()) {
    throw InputError({pipeline_.file.string()}, "the recording in {} has no ontology: name one by the key `labels`",
                     recording.folder.string());
  }
  return scene;
}

Scene ShotSource::load(std::size_t sequence) {
  if (pipeline_.recording != nullptr) return recordedScene(sequence);
  const Sequence& loaded = pipeline_.sequences[sequence];
  Scene scene = readScene(loaded.sceneFile, {.seed = loaded.sceneSeed,
                                             .ontology = pipeline_.ontology,
                                             .wavelengthNm = pipeline_.wavelengthNm,
                                             .textures = plan_.channels.has(Channel::Reflectance),
                                             .add = changes_.add});
  if (!loaded.moving) standStill(scene, 0);
  scene.placeable = changes_.placeable;
  // Trajectories are found before takeOut(), so that random paths do not depend on which objects are removed.
  findTrajectories(loaded, scene);
  takeOut(scene, loaded.without);
  return scene;
}

void ShotSource::findTrajectories(const Sequence& sequence, const Scene& scene) {
  TrajectoryPlacer placer(scene);
  for (std::size_t s = 0; s < pipeline_.sequences.size(); ++s) {
    const Sequence& other = pipeline_.sequences[s];
    if (!other.sameScene(sequence) || !needsScene(*other.trajectory)) continue;
    {
      const std::scoped_lock lock(mutex_);
      if (trajectories_.contains(s)) continue;
    }
    auto placed = std::make_shared<const Trajectory>(placer.place(*other.trajectory, other.sceneSeed));
    const std::scoped_lock lock(mutex_);
    trajectories_.try_emplace(s, std::move(placed));
  }
}

std::shared_ptr<const Trajectory> ShotSource::trajectory(std::size_t sequence) {
  const Sequence& requested = pipeline_.sequences[sequence];
  if (!needsScene(*requested.trajectory)) return requested.trajectory;
  const auto find = [&] {
    const std::scoped_lock lock(mutex_);
    const auto cached = trajectories_.find(sequence);
    return cached == trajectories_.end() ? nullptr : cached->second;
  };
  if (auto cached = find()) return cached;
  load(sequence);
  return find();
}

std::unique_ptr<Method> ShotSource::method(const Scene& scene) const {
  return pipeline_.recording != nullptr ? makeRecordedMethod(pipeline_) : makeMethod(pipeline_.method, scene);
}

std::shared_ptr<const FrameSettings> ShotSource::settings(std::size_t sequence, std::uint32_t frame) {
  if (pipeline_.drawn == nullptr) return settings_;
  const DrawnSensors& sensors = *pipeline_.drawn;
  const auto isOfSequence = [&](const auto& drawn) { return drawn.first == sequence; };
  std::shared_ptr<const FrameSettings> cached;  // settings of this frame or of another frame of the sequence
  {
    const std::scoped_lock lock(mutex_);
    if (const auto* const entry = drawn_.find(isOfSequence)) cached = entry->second;
  }
  if (cached != nullptr && !sensors.drawsPerFrame()) return cached;
  SensorDraw drawn = sensors.draw(pipeline_, sequence, frame);
  VehicleHits vehicles = vehicleHits_;
  // Random mounts are the same in all frames of a sequence, so the hits on the ego vehicle are traced once.
  if (sensors.drawsMounts()) vehicles = cached != nullptr ? hitsOf(*cached) : traceEgoVehicle(drawn.mounts);
  const auto settings = std::make_shared<const FrameSettings>(settingsOf(pipeline_, vehicles, std::move(drawn)));
  // Two cached sequences per thread are enough, since each thread makes samples of one sequence at a time.
  const auto mostCached = 2 * static_cast<std::size_t>(threadCount());
  const std::scoped_lock lock(mutex_);
  return drawn_.findOrAdd(isOfSequence, mostCached, [&] { return std::pair{sequence, settings}; }).second = settings;
}

Shot ShotSource::recordedShot(const std::string& sample, std::uint32_t frame, std::size_t sensor) const {
  const std::shared_ptr<const BeamTable>& beams = plan_.sensors[sensor].beams;
  RecordedShot recorded = pipeline_.recording->shot(sample, pipeline_.sensors[sensor].name);
  if (recorded.worldFromSensor.size() > beams->columns) {
    throw InputError({pipeline_.recording->folder.string()},
                     fmt::format("{} of '{}' has {} poses, more than the {} columns of the sensor", sample,
                                 recorded.sensor, recorded.worldFromSensor.size(), beams->columns));
  }
  return {.frame = frame,
          .time = recorded.time,
          .beams = beamsAt(beams, recorded.time),
          .worldFromSensor = std::move(recorded.worldFromSensor),
          .deskew = pipeline_.motion.deskew};
}

Frame ShotSource::frame(std::size_t sequence, std::uint32_t number, Revolutions revolutions) {
  const Sequence& drive = pipeline_.sequences[sequence];
  const bool isRecorded = pipeline_.recording != nullptr;
  const std::string sample = drive.key(number);
  const std::shared_ptr<const Trajectory> path = isRecorded ? nullptr : trajectory(sequence);
  Frame frame{settings(sequence, number), number, isRecorded ? 0 : path->frameTime(number), {}};
  for (std::size_t s = 0; s < plan_.sensors.size(); ++s) {
    if (!frame.settings->sensors[s].scans) continue;
    const double period = pipeline_.sensors[s].period;
    std::vector<double> starts{0};  // start times of the sensor's revolutions (s after the frame's time)
    if (revolutions == Revolutions::All && !isRecorded) starts = drive.revolutions(number, period, pipeline_.periods);
    for (std::size_t revolution = 0; revolution < starts.size(); ++revolution) {
      Shot shot = isRecorded
                      ? recordedShot(sample, number, s)
                      : makeShot(plan_.sensors[s].beams, *path, number, frame.settings->sensors[s].vehicleFromSensor,
                                 pipeline_.motion, starts[revolution]);
      if (revolution + 1 < starts.size() || drive.turnsWithoutBreak(pipeline_.periods)) shot.untilNext = period;
      // makeShot() sets untilNext to the frame's interval minus the revolution's start: possibly less than the period.
      if (revolution > 0) shot.untilNext = std::max(shot.untilNext, period);
      shot.sample = sample;
      shot.seed = pipeline_.seed;
      shot.scene = static_cast<std::uint32_t>(sequence);
      shot.sensor = static_cast<std::uint32_t>(s);
      shot.revolution = static_cast<std::uint32_t>(revolution);
      shot.sensorName = pipeline_.sensors[s].name;
      frame.shots.push_back(std::move(shot));
    }
  }
  if (isRecorded) frame.time = frame.shots.front().time;
  return frame;
}

void blockByVehicle(const BlockedRays& vehicle, double minRange, Hits& hits) {
  hits.pathOfRay.assign(hits.rays(), RayPath::Direct);
  for (std::size_t i = 0; i < vehicle.blocked.size(); ++i) {
    const std::uint32_t ray = vehicle.blocked[i];
    const float range = vehicle.hits.range[i];
    if (range > hits.range[ray]) continue;
    const bool reported = !vehicle.dropped && range >= minRange;
    hits.range[ray] = reported ? range : kMiss;
    hits.pathOfRay[ray] = RayPath::EgoVehicle;
    forEachChannel([&](const ChannelRow& row, auto member) {
      auto& column = hits.*member;
      using Element = typename std::remove_reference_t<decltype(column)>::value_type;
      if (row.channel != Channel::Range && !column.empty())
        column[ray] = reported ? (vehicle.hits.*member)[i] : Element{};
    });
    if (!hits.instance.empty()) hits.instance[ray] = 0;
    if (!hits.material.empty()) hits.material[ray] = reported ? kNoMaterial : 0;
    if (!hits.roughness.empty()) hits.roughness[ray] = 1;
    if (!hits.metallic.empty()) hits.metallic[ray] = 0;
    if (!hits.retroreflectance.empty()) hits.retroreflectance[ray] = 0;
  }
  // Rays that the vehicle blocks no longer count as unresolved.
  std::erase_if(hits.unresolved, [&](std::uint32_t ray) { return hits.pathOfRay[ray] == RayPath::EgoVehicle; });
}

}  // namespace scanmill
