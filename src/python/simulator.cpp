#include "python/simulator.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <unordered_set>
#include <utility>

#include "base/error.h"
#include "config/fields.h"

namespace scanmill {

namespace {

Pipeline pipelineOf(const std::string& text, const std::filesystem::path& folder) {
  Pipeline pipeline = readPipelineText(text, folder / "simulation.yaml");
  if (pipeline.sequences.size() != 1)
    throw InputError("a simulation must have one scene with one seed and one trajectory");
  return pipeline;
}

SceneChanges changesOf(std::vector<ArrayPart> parts, bool placeable) {
  SceneChanges changes{.add = nullptr, .placeable = placeable};
  if (!parts.empty()) {
    changes.add = [parts = std::move(parts)](SceneBuilder& builder) { addParts(builder, parts); };
  }
  return changes;
}

Surface surfaceOf(SceneBuilder& builder, const ArraySurface& given) {
  Surface surface = builder.surface(given.className, given.material);
  if (given.object >= 0) surface.object = static_cast<std::uint32_t>(given.object);
  if (given.reflectance >= 0) {
    Material material = builder.library().require(given.material, {});
    material.reflectance = material.least = material.greatest = given.reflectance;
    material.source = "given as an array";
    surface.material = builder.addMaterial(material);
  }
  return surface;
}

// Returns the velocity of a sensor (m/s) from each of its poses to the next, of the last pose that of the one before.
// `duration`: s, in which the sensor takes all poses at equal intervals. Of one pose: nothing.
std::vector<Vec3d> velocitiesOf(const std::vector<Pose>& poses, double duration) {
  std::vector<Vec3d> velocities;
  const double step = duration / static_cast<double>(poses.size());
  for (std::size_t i = 0; i < poses.size() && poses.size() > 1; ++i) {
    const std::size_t from = std::min(i, poses.size() - 2);
    velocities.push_back((poses[from + 1].translation - poses[from].translation) * (1 / step));
  }
  return velocities;
}

}  // namespace

void addParts(SceneBuilder& builder, const std::vector<ArrayPart>& parts) {
  std::unordered_set<std::string> names;
  for (const Instance& i : builder.soFar().instances) names.insert(i.name);
  for (const ArrayPart& part : parts) {
    if (!names.insert(part.name).second) {
      throw InputError(fmt::format("part '{}': the scene has an object of this name: take another name", part.name));
    }
    try {
      Mesh mesh = part.mesh;
      mesh.name = part.name;
      for (const ArraySurface& given : part.surfaces) mesh.surfaces.push_back(surfaceOf(builder, given));
      const std::uint32_t added = builder.addMesh(std::move(mesh));
      if (builder.soFar().meshes[added].triangles.empty()) throw InputError("none of its triangles has an area");
      builder.place(added, part.worldFromMesh, part.name);
    } catch (const InputError& e) {
      throw InputError(fmt::format("part '{}': {}", part.name, e.what()));
    }
  }
}

Simulator::Simulator(const std::string& pipeline, const std::filesystem::path& folder, std::vector<ArrayPart> parts,
                     bool placeable)
    : plan_(makePlan(pipelineOf(pipeline, folder))), source_(plan_, changesOf(std::move(parts), placeable)) {
  const MethodEntry& method = *plan_.pipeline.method.entry;
  if (placeable && !method.can.moving) {
    throw InputError(
        fmt::format("poses: the method {} cannot trace moving objects: take the method {}, or add the "
                    "objects with their poses",
                    method.name, firstMethodThat(&MethodCapabilities::moving).name));
  }
  scene_ = source_.load(0);
  method_ = source_.method(scene_);
  plan_.checkMemory(method_->memoryBytes(), "the scene");
  for (std::uint32_t i = 0; i < scene_.instances.size(); ++i) {
    const std::string& name = scene_.instances[i].name;
    instances_[name].push_back(i);
    if (const std::size_t copy = name.rfind('#'); copy != std::string::npos) copies_[name.substr(0, copy)].push_back(i);
  }
}

// Returns the indices of an object's instances: of those with this name, or else of all copies of the object.
const std::vector<std::uint32_t>& Simulator::instancesOf(const std::string& name) const {
  for (const auto* named : {&instances_, &copies_}) {
    if (const auto found = named->find(name); found != named->end()) return found->second;
  }
  std::vector<std::string> names;
  for (const auto& [known, indices] : instances_) names.push_back(known);
  throw InputError(fmt::format("poses: the scene has no object '{}'{}", name, suggestion(name, names)));
}

std::shared_ptr<const Placements> Simulator::placementsOf(const SimulatedShot& wanted) const {
  if (wanted.objects.empty()) return nullptr;
  auto placed = std::make_shared<Placements>(wanted.time);
  for (const ObjectPose& object : wanted.objects) {
    const std::vector<std::uint32_t>& instances = instancesOf(object.name);
    Affine moved;  // takes the object from its pose in the scene to the given pose
    if (object.worldFromObject) {
      const Affine inScene = scene_.instances[instances.front()].worldFromMeshAt(wanted.time);
      moved = *object.worldFromObject * inverse(rigidPartOf(inScene));
    }
    for (const std::uint32_t index : instances) {
      RigidMotion motion;
      motion.hidden = !object.worldFromObject;
      motion.worldFromMesh = moved * scene_.instances[index].worldFromMeshAt(wanted.time);
      motion.turning = object.turning;
      if (!motion.hidden) {
        const Vec3d arm = motion.worldFromMesh.translation - object.worldFromObject->translation;
        motion.velocity = object.velocity + cross(object.turning, arm);
      }
      placed->set(index, motion);
    }
  }
  return placed;
}

std::vector<SimulatedScan> Simulator::scan(const SimulatedShot& wanted) const {
  std::vector<SimulatedScan> scans;
  const std::shared_ptr<const FrameSettings> settings = source_.settings(0, wanted.frame);
  const std::shared_ptr<const Placements> placed = placementsOf(wanted);
  for (Shot& shot : source_.frame(0, 0).shots) {
    shot.frame = wanted.frame;
    shot.time = wanted.time;
    shot.beams = beamsAt(plan_.sensors[shot.sensor].beams, wanted.time);
    if (wanted.moving) shot.duration = shot.beams->columnPeriod() * shot.beams->columns;
    shot.placed = placed;
    shot.worldFromSensor.clear();
    for (const Pose& worldFromVehicle : wanted.worldFromVehicle.at(shot.sensor)) {
      shot.worldFromSensor.push_back(worldFromVehicle * settings->sensors[shot.sensor].vehicleFromSensor);
    }
    shot.sensorVelocity = velocitiesOf(shot.worldFromSensor, shot.beams->columnPeriod() * shot.beams->columns);
    ShotBuffers buffers;
    StageClock clock({"trace", "effects"});
    runShot(setupOf(plan_, *settings, scene_, *method_, shot.sensor), shot, buffers, clock);
    scans.push_back({std::move(buffers.scan), std::move(shot.worldFromSensor)});
  }
  return scans;
}

std::unordered_map<std::string, SceneObject> Simulator::objects(double time) const {
  std::unordered_map<std::string, SceneObject> all;
  for (const auto& [name, indices] : instances_) {
    SceneObject& object = all[name];
    object.worldFromObject = rigidPartOf(scene_.instances[indices.front()].worldFromMeshAt(time));
    for (const std::uint32_t index : indices) {
      const Instance& instance = scene_.instances[index];
      object.moves |= instance.moves();
      for (std::uint32_t k = 1; k <= scene_.meshes[instance.mesh].objects; ++k) {
        object.things.push_back(instanceId(instance.firstInstanceId, k));
      }
    }
    std::sort(object.things.begin(), object.things.end());
    object.things.erase(std::unique(object.things.begin(), object.things.end()), object.things.end());
  }
  return all;
}

}  // namespace scanmill
