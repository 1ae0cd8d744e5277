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

// Returns the surface of the builder's scene with this class, material and thing; a surface with a reflectance of its
// own gets a new material.
Surface addSurface(SceneBuilder& builder, const ArraySurface& arraySurface) {
  Surface surface = builder.surface(arraySurface.className, arraySurface.material);
  if (arraySurface.object >= 0) surface.object = static_cast<std::uint32_t>(arraySurface.object);
  if (arraySurface.reflectance >= 0) {
    Material material = builder.library().require(arraySurface.material, {});
    material.reflectance = material.least = material.greatest = arraySurface.reflectance;
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
      for (const ArraySurface& surface : part.surfaces) mesh.surfaces.push_back(addSurface(builder, surface));
      const std::uint32_t meshIndex = builder.addMesh(std::move(mesh));
      if (builder.soFar().meshes[meshIndex].triangles.empty()) throw InputError("none of its triangles has an area");
      builder.place(meshIndex, part.worldFromMesh, part.name);
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
  for (const auto* indicesByName : {&instances_, &copies_}) {
    if (const auto entry = indicesByName->find(name); entry != indicesByName->end()) return entry->second;
  }
  std::vector<std::string> names;
  for (const auto& [instanceName, indices] : instances_) names.push_back(instanceName);
  throw InputError(fmt::format("poses: the scene has no object '{}'{}", name, suggestion(name, names)));
}

// Returns the motions of all instances of the objects of a shot; null if there are no such objects.
std::shared_ptr<const Placements> Simulator::placementsOf(const SimulatedShot& simulated) const {
  if (simulated.objects.empty()) return nullptr;
  auto placed = std::make_shared<Placements>(simulated.time);
  for (const ObjectPose& object : simulated.objects) {
    const std::vector<std::uint32_t>& instances = instancesOf(object.name);
    Affine moved;  // from the object's pose in the scene to its pose in the shot
    if (object.worldFromObject) {
      const Affine inScene = scene_.instances[instances.front()].worldFromMeshAt(simulated.time);
      moved = *object.worldFromObject * inverse(rigidPartOf(inScene));
    }
    for (const std::uint32_t index : instances) {
      RigidMotion motion;
      motion.hidden = !object.worldFromObject;
      motion.worldFromMesh = moved * scene_.instances[index].worldFromMeshAt(simulated.time);
      motion.turning = object.turning;
      if (!motion.hidden) {
        const Vec3d lever = motion.worldFromMesh.translation - object.worldFromObject->translation;
        motion.velocity = object.velocity + cross(object.turning, lever);
      }
      placed->set(index, motion);
    }
  }
  return placed;
}

std::vector<SimulatedScan> Simulator::scan(const SimulatedShot& simulated) const {
  std::vector<SimulatedScan> scans;
  const std::shared_ptr<const FrameSettings> settings = source_.settings(0, simulated.frame);
  const std::shared_ptr<const Placements> placed = placementsOf(simulated);
  for (Shot& shot : source_.frame(0, 0).shots) {
    shot.frame = simulated.frame;
    shot.time = simulated.time;
    shot.beams = beamsAt(plan_.sensors[shot.sensor].beams, simulated.time);
    if (simulated.moving) shot.duration = shot.beams->columnPeriod() * shot.beams->columns;
    shot.placed = placed;
    shot.worldFromSensor.clear();
    for (const Pose& worldFromVehicle : simulated.worldFromVehicle.at(shot.sensor)) {
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
  std::unordered_map<std::string, SceneObject> objects;
  for (const auto& [name, indices] : instances_) {
    SceneObject& object = objects[name];
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
  return objects;
}

}  // namespace scanmill
