// pathWarnings(): warns of sensors and drives that are probably not where the user intended.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
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

constexpr std::uint32_t kFrames = 100;  // maximum number of frames in which a sensor's height is checked
// Maximum number of frames in which sensors are tested for being inside of objects.
constexpr std::uint32_t kFramesInside = 12;
constexpr double kFarAbove = 50;              // height above the surface (m); a sensor that is higher causes a warning
constexpr double kOnSurface = 0.05;           // a sensor at most this far (m) from a surface causes a warning
constexpr double kReach = 1e5;                // length of test rays (m)
constexpr double kStep = 0.5;                 // maximum length of the steps in which a path is checked (m)
constexpr double kTurnWeight = 5;             // a turn that swings the vehicle's end by 1 m counts as so many m of path
constexpr std::size_t kChunk = 20'000;        // number of steps that are swept at once, which limits memory use
constexpr std::size_t kMostPlaces = 400'000;  // after this many poses the rest of a path is not checked
// Height of the vehicle's underside above the ground (m), but at most half of the vehicle's height: it drives over what
// is lower.
constexpr double kClearance = 0.1;
constexpr double kBody = 0.6;       // height of a vehicle of which only sensors on the ground are known (m)
constexpr double kThin = 0.01;      // half of the least width and length of a vehicle (m)
constexpr double kFlat = 0.7;       // a surface counts as a wall if |z| of its unit normal is at most this
constexpr double kMostBare = 0.02;  // fraction of a path that may be without ground before a warning is given

// Returns the upward ones of the directions to the face centres, edge centres and corners of a cube, which is rotated
// so that none runs along an axis.
std::vector<Vec3d> upwardDirections() {
  const Mat3 turned = toMatrix(fromYawPitchRoll(0.37, 0.21, 0.13));
  std::vector<Vec3d> directions;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        const Vec3d direction = turned * normalized(Vec3d{double(x), double(y), double(z)});
        if (direction.z > 0) directions.push_back(direction);
      }
    }
  }
  return directions;
}

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
    for (const Instance& i : probe.scene().instances) {
      if (!i.moves()) continue;
      for (std::uint32_t object = 1; object <= probe.scene().meshes[i.mesh].objects; ++object) {
        moving_.insert(instanceId(i.firstInstanceId, object));
      }
    }
  }

  std::vector<std::string> lines() {
    for (std::size_t s = 0; s < plan_.sensors.size(); ++s) {
      checkHeights(s);
      checkInside(s);
    }
    checkPath();
    if (trajectory_->bareShare() > kMostBare) {
      report(fmt::format("{:.0f} % of its path has no ground below or above: it keeps its height there",
                         100 * trajectory_->bareShare()));
    }
    return std::move(lines_);
  }

 private:
  void report(const std::string& text) { lines_.push_back(fmt::format("sequence {}: {}", sequence_.key(), text)); }

  Vec3d sensorAt(std::size_t sensor, std::uint32_t frame) const {
    return (trajectory_->pose(frame, 0) * settings_->sensors[sensor].vehicleFromSensor).translation;
  }

  // Returns the distance to the scene's bounding box (m); 0 inside of it.
  double farFromScene(const Vec3d& p) const {
    const auto off = [](double at, double low, double high) { return std::max({low - at, at - high, 0.0}); };
    return length(Vec3d{off(p.x, bounds_.low.x, bounds_.high.x), off(p.y, bounds_.low.y, bounds_.high.y),
                        off(p.z, bounds_.low.z, bounds_.high.z)});
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

  void checkHeights(std::size_t sensor) {
    std::vector<SceneProbe::Ray> down;
    std::vector<SceneProbe::Ray> up;
    std::vector<SceneProbe::Ray> near;
    for (const std::uint32_t frame : sequence_.spreadFrames(kFrames)) {
      down.push_back({sensorAt(sensor, frame), {0, 0, -1}});
      up.push_back({down.back().from, {0, 0, 1}});
      near.push_back({down.back().from + Vec3d{0, 0, kOnSurface}, {0, 0, -1}});
    }
    const auto below = probe_.first(down, kReach);
    const auto above = probe_.first(up, kReach);
    const auto touched = probe_.first(near, 2 * kOnSurface);
    std::vector<std::size_t> onSurface, underground, outOfRange, high;  // indices of frames, by what is wrong in them
    for (std::size_t i = 0; i < below.size(); ++i) {
      if (touched[i]) {
        onSurface.push_back(i);
        continue;
      }
      if (!below[i] && above[i]) underground.push_back(i);
      if (farFromScene(down[i].from) > plan_.sensors[sensor].beams->maxRange) outOfRange.push_back(i);
      if (below[i] && below[i]->distance > kFarAbove) high.push_back(i);
    }
    const std::string& name = plan_.pipeline.sensors[sensor].name;
    const auto where = [&](const std::vector<std::size_t>& found) {
      return fmt::format("in {} of {} frames, first at {}", found.size(), below.size(),
                         shortPosition(down[found.front()].from));
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
                         shortLength(farFromScene(down[outOfRange.front()].from)), where(outOfRange)));
    }
    if (outOfRange.empty() && 2 * high.size() > below.size()) {
      report(fmt::format("'{}' is more than {:g} m above the surface below it {} ({}): is the unit of the scene right?",
                         name, kFarAbove, where(high), shortLength(below[high.front()]->distance)));
    }
  }

  // Warns if everything beside and above a sensor is of one class, within its range: it is probably inside of an
  // object, or of a building whose walls and roof are separate objects.
  void checkInside(std::size_t sensor) {
    static const std::vector<Vec3d> kDirections = upwardDirections();
    for (const std::uint32_t frame : sequence_.spreadFrames(kFramesInside)) {
      const Vec3d at = sensorAt(sensor, frame);
      std::vector<SceneProbe::Ray> rays;
      for (const Vec3d& direction : kDirections) rays.push_back({at, direction});
      const auto hits = probe_.first(rays, plan_.sensors[sensor].beams->maxRange);
      const bool enclosed = std::ranges::all_of(hits, [&](const auto& hit) {
        return hit && hit->semantic == hits.front()->semantic && !moving_.contains(hit->instance);
      });
      if (!enclosed || !probe_.first({at, {0, 0, -1}}, kReach)) continue;  // checkHeights() warns of those below ground
      return report(
          fmt::format("'{}' sees nothing beside and above it but surfaces of the class {}, such as {}, at {} (frame "
                      "{}), which is right only in rooms and tunnels",
                      plan_.pipeline.sensors[sensor].name, className(hits.front()->semantic), nameOf(*hits.front()),
                      shortPosition(at), frame));
    }
  }

  // Returns the height of the ground in the vehicle's frame (m).
  double groundInVehicle() const { return trajectory_->ground() == nullptr ? 0 : -trajectory_->ground()->height; }

  // Returns the box that the vehicle fills above what it drives over (m, vehicle's frame): that of its model or, if it
  // has none, a box about its sensors and about the wheels that the trajectory states, as high as its highest sensor.
  Box vehicleBox() const {
    const double ground = groundInVehicle();
    Box box;
    if (vehicle_ != nullptr) {
      box = vehicle_->bounds();
    } else {
      box.add(Vec3d{0, 0, ground});
      for (const SensorSetting& s : settings_->sensors) box.add(s.vehicleFromSensor.translation);
      if (box.high.z - ground < kOnSurface) box.high.z = ground + kBody;
      const GroundOptions usual;
      if (trajectory_->ground() != nullptr && trajectory_->ground()->wheels &&
          trajectory_->ground()->wheels != usual.wheels) {
        const auto& [wheelbase, track] = *trajectory_->ground()->wheels;
        for (const double side : {-0.5, 0.5}) box.add(Vec3d{side * wheelbase, side * track, ground});
      }
    }
    const double underside = ground + std::min(kClearance, (box.high.z - ground) / 2);
    // Sensors of a flying vehicle may be below its origin.
    if (trajectory_->ground() != nullptr || box.low.z > -kOnSurface) box.low.z = std::max(box.low.z, underside);
    box.add(Box{{-kThin, -kThin, box.low.z}, {kThin, kThin, box.high.z}});
    return box;
  }

  struct Step {
    std::pair<Pose, Pose> poses;
    std::uint32_t frame = 0;
  };

  // Returns the steps of the vehicle along its path, at most kStep long, but at most 1000 per frame; for a vehicle that
  // stands still, its poses. Ends after the frame in which the number of poses reaches kMostPlaces. `radius`: distance
  // of the vehicle's end from its origin (m).
  std::vector<Step> stepsOnPath(double radius) const {
    std::vector<Step> steps;
    const auto apart = [&](const Pose& a, const Pose& b) {
      return length(b.translation - a.translation) +
             kTurnWeight * radius * length(toMatrix(b.rotation).x - toMatrix(a.rotation).x);
    };
    Pose last = trajectory_->pose(0, 0);
    if (trajectory_->still() || sequence_.frames == 1) {
      for (std::uint32_t frame = 0; frame < sequence_.frames && frame < kMostPlaces; ++frame) {
        steps.push_back({{trajectory_->pose(frame, 0), trajectory_->pose(frame, 0)}, frame});
      }
      return steps;
    }
    for (std::uint32_t frame = 0; frame + 1 < sequence_.frames && steps.size() < kMostPlaces; ++frame) {
      const double span = trajectory_->frameTime(frame + 1) - trajectory_->frameTime(frame);
      constexpr int kChords = 32;
      double far = 0;
      Pose before = trajectory_->pose(frame, 0);
      for (int k = 1; k <= kChords; ++k) {
        const Pose behind = trajectory_->pose(frame, span * k / kChords);
        far += apart(before, behind);
        before = behind;
      }
      const int parts = static_cast<int>(std::clamp(std::ceil(2 * far / kStep), 1.0, 1000.0));
      for (int k = 1; k <= parts; ++k) {
        const Pose next = trajectory_->pose(frame, span * k / parts);
        const bool end = k == parts && frame + 2 == sequence_.frames;
        if (apart(last, next) < kStep / 2 && !end) continue;
        steps.push_back({{last, next}, frame});
        last = next;
      }
    }
    return steps;
  }

  // Warns if the vehicle's box meets steep surfaces, or any surface of a thing, on its way. Gentle surfaces of stuff
  // may be the ground, of which recorded heights are not exact.
  void checkPath() {
    const Box box = vehicleBox();
    std::vector<Box> boxes{box};
    for (const SensorSetting& sensor : settings_->sensors) {  // some may stand on masts above the vehicle's model
      const Vec3d& at = sensor.vehicleFromSensor.translation;
      if (at.z <= box.high.z) continue;
      boxes.push_back({{at.x - kThin, at.y - kThin, box.high.z}, {at.x + kThin, at.y + kThin, at.z}});
    }
    const double radius = std::hypot(std::max(box.high.x, -box.low.x), std::max(box.high.y, -box.low.y));
    const std::vector<Step> steps = stepsOnPath(radius);
    const std::uint32_t lastFrame = sequence_.frames - (trajectory_->still() || sequence_.frames == 1 ? 1 : 2);
    if (steps.back().frame < lastFrame) {
      report(fmt::format("only its frames 0 to {} are checked for obstacles, since its path is too long",
                         steps.back().frame));
    }
    const Ontology& ontology = probe_.scene().ontology;
    const std::vector<std::uint16_t> ground =
        trajectory_->ground() == nullptr
            ? std::vector<std::uint16_t>()
            : classIds(ontology, trajectory_->ground()->classes, trajectory_->ground()->where);
    const auto blocks = [&](const Instance& instance, const Surface& surface, const Vec3d& normal) {
      if (instance.moves()) return false;
      if (std::fabs(normal.z) <= kFlat) return true;
      const SemanticClass* const semantic = ontology.find(surface.semantic);
      return semantic != nullptr && semantic->thing && std::ranges::find(ground, surface.semantic) == ground.end();
    };
    std::optional<BoxContact> contact;
    std::size_t first = 0;  // the first step of the chunk that was swept last
    for (std::size_t begin = 0; begin < steps.size() && !contact; begin += kChunk) {
      first = begin;
      std::vector<std::pair<Pose, Pose>> poses;
      for (std::size_t i = begin; i < std::min(begin + kChunk, steps.size()); ++i) poses.push_back(steps[i].poses);
      contact = sweepBoxes(probe_.scene(), boxes, poses, blocks);
    }
    if (!contact) return;
    const Vec3d size = box.high - box.low;
    report(
        fmt::format("{} '{}' ({}) at {} (frame {}); checked is the box of its {}, {:.2f} x {:.2f} m, from {:.2f} to "
                    "{:.2f} m above its origin",
                    trajectory_->still() ? "it stands in" : "its path goes through", contact->instance->name,
                    className(contact->semantic), shortPosition(contact->position), steps[first + contact->step].frame,
                    vehicle_ == nullptr ? "sensors" : "`vehicle`", size.x, size.y, box.low.z, box.high.z));
  }

  const Plan& plan_;
  const Sequence& sequence_;
  const SceneProbe& probe_;
  std::shared_ptr<const Trajectory> trajectory_;
  std::shared_ptr<const FrameSettings> settings_;
  std::shared_ptr<const Scene> vehicle_;  // null: no ego vehicle
  Box bounds_;
  std::set<std::uint32_t> moving_;  // instance ids of moving objects
  std::vector<std::string> lines_;
};

}  // namespace

std::vector<std::string> pathWarnings(ShotSource& source, std::size_t sequence, const SceneProbe& probe) {
  return PathCheck(source, sequence, probe).lines();
}

}  // namespace scanmill
