// pathWarnings(): warns of sensors and drives that are probably not where the user intended.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <set>

#include "base/short_text.h"
#include "pipeline/checks/box_sweep.h"
#include "pipeline/checks/warnings.h"
#include "pipeline/scenes/scene_probe.h"
#include "pipeline/scenes/shot_source.h"
#include "sensors/trajectory.h"

namespace scanmill {
namespace {

// Limits beyond which positions and paths are unusual, chosen by eye.
constexpr double kOnSurface = 0.05;      // m; a sensor at most this far from a surface causes a warning
constexpr double kMostShift = 0.1;       // m; waypoints that are farther from the ground on average cause a warning
constexpr double kLeastFlight = 3;       // m above the ground; lower paths that are not on it cause a warning
constexpr double kMostBareShare = 0.02;  // a path causes a warning if a larger fraction of it has no ground
// Height (m) of the vehicle's underside above the ground, unless half of the vehicle's height is less. The vehicle can
// drive over lower obstacles.
constexpr double kClearance = 0.1;
constexpr double kDefaultHeight = 0.6;    // m, of a vehicle without a model whose sensors are all on the ground
constexpr double kLeastHalfWidth = 0.01;  // m, least half width and half length of a vehicle
constexpr double kWallNormal = 0.7;       // a surface counts as a wall if |z| of its unit normal is at most this

// Limits of the amount of work.
constexpr std::uint32_t kHeightFrames = 100;  // frames in which a sensor's height is checked, at most
constexpr std::uint32_t kInsideFrames = 12;   // frames in which sensors are tested for being inside of objects, at most
constexpr double kProbeLength = 1e5;          // m, length of test rays
constexpr double kStep = 0.5;                 // m, largest length of the steps in which a path is checked
constexpr double kTurnWeight = 5;             // a turn counts as so many m of path per m that the vehicle's end swings
constexpr std::size_t kStepsAtOnce = 20'000;  // steps that are swept at once, which limits memory use
constexpr std::size_t kMostPoses = 400'000;   // after this many poses the rest of a path is not checked
constexpr double kMostStepsPerFrame = 1000;
constexpr Vec3d kUp{0, 0, 1};
constexpr Vec3d kDownwards{0, 0, -1};

// Returns the directions from the centre of a cube to its face centres, edge centres and corners that point upwards.
// The cube is rotated so that no direction is along an axis.
std::vector<Vec3d> upwardDirections() {
  const Mat3 rotation = toMatrix(fromYawPitchRoll(0.37, 0.21, 0.13));  // rad
  std::vector<Vec3d> directions;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        const Vec3d direction = rotation * normalized(Vec3d{double(x), double(y), double(z)});
        if (direction.z > 0) directions.push_back(direction);
      }
    }
  }
  return directions;
}

// Checks one sequence; see pathWarnings().
class PathCheck {
 public:
  PathCheck(ShotSource& source, std::size_t sequence, const SceneProbe& probe)
      : plan_(source.plan()),
        sequence_(plan_.pipeline.sequences[sequence]),
        probe_(probe),
        trajectory_(source.trajectory(sequence)),
        settings_(source.settings(sequence, 0)),
        vehicle_(source.vehicle()),
        bounds_(probe.bounds()) {
    if (const GroundOptions* const ground = trajectory_->ground()) {
      groundClasses_ = classIds(probe.scene().ontology, ground->classes, ground->where);
    }
    for (const Instance& i : probe.scene().instances) {
      if (!i.moves()) continue;
      for (std::uint32_t object = 1; object <= probe.scene().meshes[i.mesh].objects; ++object) {
        movingIds_.insert(instanceId(i.firstInstanceId, object));
      }
    }
  }

  std::vector<std::string> warnings() {
    for (std::size_t s = 0; s < plan_.sensors.size(); ++s) {
      checkHeights(s);
      checkInside(s);
    }
    checkPath();
    if (trajectory_->bareShare() > kMostBareShare) {
      report(fmt::format("{:.0f} % of its path has no ground below or above: it keeps its height there",
                         100 * trajectory_->bareShare()));
    }
    const double clearance = trajectory_->clearanceByDefault();
    if (trajectory_->ground() == nullptr && clearance > 0 && clearance < kLeastFlight) {
      report(
          fmt::format("its path is {:.2f} m off the ground on average and keeps its heights: `ground: drop` puts the "
                      "vehicle on its wheels, `ground: none` keeps it there without this line",
                      clearance));
    } else if (trajectory_->ground() != nullptr && clearance > kMostShift) {
      report(
          fmt::format("the vehicle stands on the ground, {:.2f} m from its waypoints on average: `ground: none` keeps "
                      "their heights",
                      clearance));
    }
    return std::move(warnings_);
  }

 private:
  void report(const std::string& text) { warnings_.push_back(fmt::format("sequence {}: {}", sequence_.key(), text)); }

  // Returns the position of a sensor at the start of a frame (m, world frame).
  Vec3d sensorPosition(std::size_t sensor, std::uint32_t frame) const {
    return (trajectory_->pose(frame, 0) * settings_->sensors[sensor].vehicleFromSensor).translation;
  }

  std::string className(std::uint16_t id) const {
    const SemanticClass* const semantic = probe_.scene().ontology.find(id);
    return semantic == nullptr ? "unlabeled" : semantic->name;
  }

  // Returns the name and class of the object instance that was hit; only the class if the hit has no instance id.
  std::string nameOf(const SceneProbe::Hit& hit) const {
    const Scene& scene = probe_.scene();
    const std::string name = className(hit.semantic);
    for (const Instance& i : scene.instances) {
      const std::uint32_t objects = scene.meshes[i.mesh].objects;
      if (hit.instance < i.firstInstanceId || hit.instance >= i.firstInstanceId + objects) continue;
      return fmt::format("'{}' ({})", i.name, name);
    }
    return fmt::format("something of the class {}", name);
  }

  // Warns of a sensor that is on a surface, below the ground, or out of range of the scene.
  void checkHeights(std::size_t sensor) {
    std::vector<Vec3d> positions;  // by checked frame
    for (const std::uint32_t frame : sequence_.spreadFrames(kHeightFrames)) {
      positions.push_back(sensorPosition(sensor, frame));
    }
    const auto firstHits = [&](double startHeight, const Vec3d& direction, double reach) {
      std::vector<SceneProbe::Ray> rays;
      rays.reserve(positions.size());
      for (const Vec3d& p : positions) rays.push_back({p + Vec3d{0, 0, startHeight}, direction});
      return probe_.first(rays, reach);
    };
    const auto below = firstHits(0, kDownwards, kProbeLength);
    const auto above = firstHits(0, kUp, kProbeLength);
    const auto touched = firstHits(kOnSurface, kDownwards, 2 * kOnSurface);
    std::vector<std::size_t> onSurface, underground, outOfRange;  // frame numbers
    for (std::size_t i = 0; i < positions.size(); ++i) {
      if (touched[i]) {
        onSurface.push_back(i);
        continue;
      }
      if (!below[i] && above[i]) underground.push_back(i);
      if (bounds_.distanceTo(positions[i]) > plan_.sensors[sensor].beams->maxRange) outOfRange.push_back(i);
    }
    const std::string& name = plan_.pipeline.sensors[sensor].name;
    const auto where = [&](const std::vector<std::size_t>& frames) {
      return fmt::format("in {} of {} frames, first at {}", frames.size(), positions.size(),
                         shortPosition(positions[frames.front()]));
    };
    if (!onSurface.empty()) {
      const bool mounted = settings_->sensors[sensor].vehicleFromSensor.translation.z - groundInVehicle() > kOnSurface;
      report(fmt::format("'{}' is on the surface of {} {}{}", name, nameOf(*touched[onSurface.front()]),
                         where(onSurface),
                         mounted ? "" : ": does it have a `mount`, such as {position: [0, 0, 1.8]}?"));
    }
    if (!underground.empty()) {
      report(fmt::format(
          "'{}' is below the ground {}: no surface is below it, and {} is {} above it ({})", name, where(underground),
          nameOf(*above[underground.front()]), shortLength(above[underground.front()]->distance),
          trajectory_->ground() != nullptr ? "place its `mount` above the vehicle's origin, which is on the ground"
                                           : "`ground: drop` in the trajectory puts the vehicle on the ground"));
    }
    if (!outOfRange.empty()) {
      report(fmt::format("'{}' is {} away from the scene {}, which is beyond its range", name,
                         shortLength(bounds_.distanceTo(positions[outOfRange.front()])), where(outOfRange)));
    }
  }

  // Warns if a sensor is probably inside of an object or of a building: all test rays, sideways and upwards, hit
  // surfaces within the sensor's range, and these surfaces have one class and do not belong to moving objects.
  void checkInside(std::size_t sensor) {
    static const std::vector<Vec3d> kDirections = upwardDirections();
    for (const std::uint32_t frame : sequence_.spreadFrames(kInsideFrames)) {
      const Vec3d position = sensorPosition(sensor, frame);
      std::vector<SceneProbe::Ray> rays;
      rays.reserve(kDirections.size());
      for (const Vec3d& direction : kDirections) rays.push_back({position, direction});
      const auto hits = probe_.first(rays, plan_.sensors[sensor].beams->maxRange);
      const bool enclosed = std::ranges::all_of(hits, [&](const auto& hit) {
        return hit && hit->semantic == hits.front()->semantic && !movingIds_.contains(hit->instance);
      });
      if (!enclosed || !probe_.first({position, kDownwards}, kProbeLength))
        continue;  // checkHeights() warns of sensors below the ground
      return report(
          fmt::format("'{}' sees nothing beside and above it but surfaces of the class {}, such as {}, at {} (frame "
                      "{}), which is right only in rooms and tunnels",
                      plan_.pipeline.sensors[sensor].name, className(hits.front()->semantic), nameOf(*hits.front()),
                      shortPosition(position), frame));
    }
  }

  // Returns the height of the ground in the vehicle's frame (m); 0 if the trajectory has no ground.
  double groundInVehicle() const { return trajectory_->ground() == nullptr ? 0 : -trajectory_->ground()->height; }

  // Returns the vehicle's box (m, vehicle's frame), without the space below its underside: the bounds of its model or,
  // without a model, of its sensors and of the wheels that the trajectory states.
  Box vehicleBox() const {
    const GroundOptions* const options = trajectory_->ground();
    const bool flies = options == nullptr || (!options->wheels && options->height > kLeastFlight);
    const double ground = flies ? 0 : -options->height;
    Box box;
    if (vehicle_ != nullptr) {
      box = vehicle_->bounds();
    } else {
      box.add(Vec3d{0, 0, ground});
      for (const SensorSetting& s : settings_->sensors) box.add(s.vehicleFromSensor.translation);
      if (box.high.z - ground < kOnSurface) box.high.z = ground + kDefaultHeight;
      if (options != nullptr && options->wheels && options->wheels != GroundOptions().wheels) {
        const auto& [wheelbase, track] = *options->wheels;
        for (const double half : {-0.5, 0.5}) box.add(Vec3d{half * wheelbase, half * track, ground});
      }
    }
    const double underside = ground + std::min(kClearance, (box.high.z - ground) / 2);
    // Cuts the box at the underside, except for flying vehicles, whose sensors may be below the vehicle's origin.
    if (!flies || box.low.z > -kOnSurface) box.low.z = std::max(box.low.z, underside);
    box.add(Box{{-kLeastHalfWidth, -kLeastHalfWidth, box.low.z}, {kLeastHalfWidth, kLeastHalfWidth, box.high.z}});
    return box;
  }

  struct Step {
    std::pair<Pose, Pose> poses;  // of the vehicle, at the start and at the end of the step
    std::uint32_t frame = 0;
  };

  // Divides the vehicle's path into steps of about kStep, but each frame into at most kMostStepsPerFrame. A vehicle
  // that stands still has one step without motion per frame. Ends after the frame in which the number of steps reaches
  // kMostPoses. `radius`: horizontal distance from the vehicle's origin to the farthest corner of its box (m).
  std::vector<Step> stepsOnPath(double radius) const {
    std::vector<Step> steps;
    if (trajectory_->still() || sequence_.frames == 1) {
      for (std::uint32_t frame = 0; frame < sequence_.frames && frame < kMostPoses; ++frame) {
        steps.push_back({{trajectory_->pose(frame, 0), trajectory_->pose(frame, 0)}, frame});
      }
      return steps;
    }
    const auto distance = [&](const Pose& a, const Pose& b) {
      return length(b.translation - a.translation) +
             kTurnWeight * radius * length(toMatrix(b.rotation).x - toMatrix(a.rotation).x);
    };
    Pose last = trajectory_->pose(0, 0);  // the vehicle's pose at the end of the previous step
    for (std::uint32_t frame = 0; frame + 1 < sequence_.frames && steps.size() < kMostPoses; ++frame) {
      const double duration = trajectory_->frameTime(frame + 1) - trajectory_->frameTime(frame);
      constexpr int kChords = 32;  // number of chords that approximate a frame's path
      double travelled = 0;
      Pose chordStart = trajectory_->pose(frame, 0);
      for (int k = 1; k <= kChords; ++k) {
        const Pose chordEnd = trajectory_->pose(frame, duration * k / kChords);
        travelled += distance(chordStart, chordEnd);
        chordStart = chordEnd;
      }
      // Divides the frame's path into half steps. A half step shorter than kStep / 2 is joined with the next one.
      const int parts = static_cast<int>(std::clamp(std::ceil(2 * travelled / kStep), 1.0, kMostStepsPerFrame));
      for (int k = 1; k <= parts; ++k) {
        const Pose next = trajectory_->pose(frame, duration * k / parts);
        const bool isPathEnd = k == parts && frame + 2 == sequence_.frames;
        if (distance(last, next) < kStep / 2 && !isPathEnd) continue;
        steps.push_back({{last, next}, frame});
        last = next;
      }
    }
    return steps;
  }

  // True for triangles that the vehicle may not touch: steep triangles, and all triangles of thing classes that are not
  // ground. False for moving objects, and for gentle slopes of ground or stuff, since recorded heights are not exact.
  bool isObstacle(const Instance& instance, const Surface& surface, const Vec3d& normal) const {
    if (instance.moves()) return false;
    if (std::fabs(normal.z) <= kWallNormal) return true;
    const SemanticClass* const semantic = probe_.scene().ontology.find(surface.semantic);
    return semantic != nullptr && semantic->thing &&
           std::ranges::find(groundClasses_, surface.semantic) == groundClasses_.end();
  }

  // Warns of the first obstacle that the vehicle's box, or a mast of a sensor, touches on its way.
  void checkPath() {
    const Box box = vehicleBox();
    const GroundOptions* const onGround = trajectory_->ground();
    const double lowest = vehicle_ == nullptr || onGround == nullptr ? 0 : vehicle_->bounds().low.z;
    if (onGround != nullptr && -lowest - onGround->height > kOnSurface) {
      report(
          fmt::format("the model of `vehicle` reaches {} under the ground: `ground: {{height: {:.3f}}}` in the "
                      "trajectory puts it on its wheels",
                      shortLength(-lowest - onGround->height), -lowest));
    }
    std::vector<Box> boxes{box};
    for (const SensorSetting& sensor : settings_->sensors) {  // some may stand on masts above the vehicle's model
      const Vec3d& p = sensor.vehicleFromSensor.translation;
      if (p.z <= box.high.z) continue;
      boxes.push_back({{p.x - kLeastHalfWidth, p.y - kLeastHalfWidth, box.high.z},
                       {p.x + kLeastHalfWidth, p.y + kLeastHalfWidth, p.z}});
    }
    const double radius = std::hypot(std::max(box.high.x, -box.low.x), std::max(box.high.y, -box.low.y));
    const std::vector<Step> steps = stepsOnPath(radius);
    const std::uint32_t lastFrame = sequence_.frames - (trajectory_->still() || sequence_.frames == 1 ? 1 : 2);
    if (steps.back().frame < lastFrame) {
      report(fmt::format("only its frames 0 to {} are checked for obstacles, since its path is too long",
                         steps.back().frame));
    }
    for (std::size_t first = 0; first < steps.size(); first += kStepsAtOnce) {
      std::vector<std::pair<Pose, Pose>> poses;
      for (std::size_t i = first; i < std::min(first + kStepsAtOnce, steps.size()); ++i)
        poses.push_back(steps[i].poses);
      const std::optional<BoxContact> contact =
          sweepBoxes(probe_.scene(), boxes, poses, std::bind_front(&PathCheck::isObstacle, this));
      if (!contact) continue;
      const Vec3d size = box.high - box.low;
      return report(fmt::format(
          "{} '{}' ({}) at {} (frame {}); checked is the box of its {}, {:.2f} x {:.2f} m, from {:.2f} to "
          "{:.2f} m above its origin",
          trajectory_->still() ? "it stands in" : "its path goes through", contact->instance->name,
          className(contact->semantic), shortPosition(contact->position), steps[first + contact->step].frame,
          vehicle_ == nullptr ? "sensors" : "`vehicle`", size.x, size.y, box.low.z, box.high.z));
    }
  }

  const Plan& plan_;
  const Sequence& sequence_;
  const SceneProbe& probe_;
  std::shared_ptr<const Trajectory> trajectory_;
  std::shared_ptr<const FrameSettings> settings_;
  std::shared_ptr<const Scene> vehicle_;      // null: no ego vehicle
  Box bounds_;                                // of the scene (m, world frame)
  std::vector<std::uint16_t> groundClasses_;  // classes of the trajectory's ground; empty: no ground
  std::set<std::uint32_t> movingIds_;         // instance ids of moving objects
  std::vector<std::string> warnings_;
};

}  // namespace

std::vector<std::string> pathWarnings(ShotSource& source, std::size_t sequence, const SceneProbe& probe) {
  return PathCheck(source, sequence, probe).warnings();
}

}  // namespace scanmill
