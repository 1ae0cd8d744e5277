// The Python class Simulator, which holds a scene, its sensors and a simulation method, and makes scans from any pose.

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "base/error.h"
#include "config/fields.h"
#include "dataset/json_text.h"
#include "pipeline/plan/plan.h"
#include "pipeline/run/dataset_writer.h"
#include "pipeline/run/sample_maker.h"
#include "python/arrays.h"
#include "scene/builder.h"

namespace py = pybind11;

namespace scanmill {
namespace {

// Parts of a scene that Python gives as arrays, which the module scanmill.parts has checked.

// The class, material and thing that some of a part's triangles share.
struct ArraySurface {
  std::string className, material;
  float reflectance = -1;    // replaces the material's; negative: the material's own
  std::int64_t object = -1;  // see Surface::object; negative: 1 for a class of things, 0 for a class of stuff
};

struct ArrayPart {
  std::string name;
  Mesh mesh;                           // without surfaces
  std::vector<ArraySurface> surfaces;  // Mesh::surfaceOf indexes them
  Affine worldFromMesh;
};

struct SimulatedScan {
  Scan scan;
  std::vector<Pose> worldFromSensor;  // sensor pose at each step of the revolution
};

struct SimulatedFrame {
  std::vector<SimulatedScan> scans;  // one per sensor; empty: an earlier run of the loop has written the sample
  std::string objects;               // the list of objects as JSON; empty if the pipeline does not ask for objects
};

// The dataset that a scan becomes a sample of.
struct Target {
  DatasetWriter* writer = nullptr;  // null: none
  std::string drive, split;
};

// States where an object of the scene is at the start of a scan, and how it moves during the scan.
struct ObjectPose {
  std::string name;
  std::optional<Affine> worldFromObject;  // without scale; none: the object is left out of the scan
  Vec3d velocity;                         // m/s, world axes
  Vec3d turning;                          // rad/s, world axes, about the object's origin
};

std::string textOf(const std::vector<ObjectPose>& objects) {
  std::string text;
  for (const ObjectPose& o : objects) {
    const Affine pose = o.worldFromObject.value_or(Affine{});
    text += fmt::format("{} {} ", o.name, o.worldFromObject.has_value());
    for (const Vec3d& v : {pose.linear.x, pose.linear.y, pose.linear.z, pose.translation, o.velocity, o.turning}) {
      text += fmt::format("{} {} {} ", v.x, v.y, v.z);
    }
  }
  return text;
}

struct SimulatedShot {
  std::vector<std::vector<Pose>> worldFromVehicle = {};  // for each sensor, the poses at equal steps of its revolution
  double time = 0;                                       // s since the drive began, at the start of the revolution
  std::uint32_t frame = 0;                               // selects the noise
  std::vector<ObjectPose> objects = {};                  // the objects that are not where the scene places them
  bool moving = false;                                   // true: objects move during the revolution
};

// An object of the scene: all instances that share a name.
struct SceneObject {
  Affine worldFromObject;             // without scale: the pose of its first instance
  std::vector<std::uint32_t> things;  // ids of its things, ascending
  bool moves = false;                 // true: the scene itself moves the object
};

Pipeline pipelineOf(const std::string& text, const std::filesystem::path& folder) {
  Pipeline pipeline = readPipelineText(text, folder / "simulation.yaml");
  if (pipeline.sequences.size() != 1)
    throw InputError("a simulation must have one scene with one seed and one trajectory");
  return pipeline;
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

// Returns the velocity of a sensor (m/s) from each of its poses to the next; the last pose has the velocity of the pose
// before it. Successive poses are duration / poses.size() (s) apart. Returns nothing for a single pose.
std::vector<Vec3d> velocitiesOf(const std::vector<Pose>& poses, double duration) {
  std::vector<Vec3d> velocities;
  const double step = duration / static_cast<double>(poses.size());
  for (std::size_t i = 0; i < poses.size() && poses.size() > 1; ++i) {
    const std::size_t from = std::min(i, poses.size() - 2);
    velocities.push_back((poses[from + 1].translation - poses[from].translation) * (1 / step));
  }
  return velocities;
}

// Adds the parts to a scene. Throws an InputError that names the part if the scene or another part already has the
// part's name, or if a class or material is unknown.
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

SceneChanges changesOf(std::vector<ArrayPart> parts, bool placeable) {
  SceneChanges changes{.add = nullptr, .placeable = placeable};
  if (!parts.empty()) {
    changes.add = [parts = std::move(parts)](SceneBuilder& builder) { addParts(builder, parts); };
  }
  return changes;
}

// Makes scans of one scene. Safe to use from several threads.
class Simulator {
 public:
  // `pipeline`: text of a pipeline with one sequence. Relative paths in the text start at `folder`. `parts` are added
  // to the scene. If `placeable`, scans may place objects. Throws InputError.
  Simulator(const std::string& pipeline, const std::filesystem::path& folder, std::vector<ArrayPart> parts = {},
            bool placeable = false)
      : plan_(makePlan(pipelineOf(pipeline, folder))), source_(plan_, changesOf(std::move(parts), placeable)) {
    const MethodEntry& method = *plan_.pipeline.method.entry;
    if (placeable && !method.can.moving) {
      throw InputError(
          fmt::format("poses: the method {} cannot trace moving objects: take the method {}, or add the "
                      "objects with their poses",
                      method.name, firstMethodThat(&MethodCapabilities::moving).name));
    }
    for (const MountedSensor& sensor : plan_.pipeline.sensors) {
      if (sensor.size.sectors == 1) continue;
      throw InputError(
          fmt::format("a scan is one turn, but '{}' makes its turn in {} sectors: give the sensor sectors=1",
                      sensor.name, sensor.size.sectors));
    }
    loadScene(source_, 0, ready_);
    for (std::uint32_t i = 0; i < scene().instances.size(); ++i) {
      const std::string& name = scene().instances[i].name;
      instances_[name].push_back(i);
      if (const std::size_t copy = name.rfind('#'); copy != std::string::npos)
        copies_[name.substr(0, copy)].push_back(i);
    }
  }

  // Returns one scan per sensor: the scan that `scanmill generate` makes with this pipeline in the frame `frame`, if
  // the vehicle has the same poses, and all objects have the scene's poses and stand still during the revolution.
  // If there is a target, the frame is its next one. Throws InputError for an unknown object.
  SimulatedFrame scan(const SimulatedShot& simulated, const Target& target) const {
    Sequence sequence = plan_.pipeline.sequences.front();
    DatasetWriter* const writer = target.writer;
    if (writer != nullptr) {
      sequence.trajectoryName = keyPart(target.drive);
      sequence.split = target.split;
    }
    Frame frame = source_.frame(0, 0);
    frame.number = writer == nullptr ? simulated.frame : writer->framesOf(sequence);
    frame.time = simulated.time;
    const std::shared_ptr<const FrameSettings> settings = source_.settings(0, frame.number);
    frame.settings = settings;
    const std::shared_ptr<const Placements> placed = placementsOf(simulated);
    for (Shot& shot : frame.shots) {
      shot.frame = frame.number;
      shot.sample = sequence.key(frame.number);
      if (writer != nullptr) shot.scene = writer->indexOf(sequence);
      shot.time = simulated.time;
      shot.beams = beamsAt(plan_.sensors[shot.sensor].beams, simulated.time);
      if (simulated.moving) shot.duration = shot.beams->columnPeriod() * shot.beams->columns;
      shot.placed = placed;
      shot.worldFromSensor.clear();
      for (const Pose& worldFromVehicle : simulated.worldFromVehicle.at(shot.sensor)) {
        shot.worldFromSensor.push_back(worldFromVehicle * settings->sensors[shot.sensor].vehicleFromSensor);
      }
      shot.sensorVelocity = velocitiesOf(shot.worldFromSensor, shot.beams->columnPeriod() * shot.beams->columns);
    }
    if (writer != nullptr && writer->hasNext(source_, sequence, frame, textOf(simulated.objects))) return {};
    ShotBuffers buffers;
    StageClock clock;
    SimulatedFrame made;
    const auto take = [&](const Shot& shot, ShotBuffers& traced) {
      made.scans.push_back({std::move(traced.scan), shot.worldFromSensor});
    };
    MadeSample sample = makeSample(plan_, ready_, sequence, frame, {buffers, clock, take, writer != nullptr});
    if (sample.sample.objects) made.objects = sample.sample.files.front().bytes;
    if (writer != nullptr) writer->add(source_, sequence, std::move(sample));
    return made;
  }

  // Returns the objects of the scene, by their names, at a time (s since the drive began).
  std::unordered_map<std::string, SceneObject> objects(double time) const {
    std::unordered_map<std::string, SceneObject> objects;
    for (const auto& [name, indices] : instances_) {
      SceneObject& object = objects[name];
      object.worldFromObject = rigidPartOf(scene().instances[indices.front()].worldFromMeshAt(time));
      for (const std::uint32_t index : indices) {
        const Instance& instance = scene().instances[index];
        object.moves |= instance.moves();
        for (std::uint32_t k = 1; k <= scene().meshes[instance.mesh].objects; ++k) {
          object.things.push_back(instanceId(instance.firstInstanceId, k));
        }
      }
      std::ranges::sort(object.things);
      object.things.erase(std::unique(object.things.begin(), object.things.end()), object.things.end());
    }
    return objects;
  }

  const Plan& plan() const { return plan_; }
  const Scene& scene() const { return ready_.scene; }

 private:
  // Returns the indices of the instances called `name`, or else of its copies NAME#1, ...; throws InputError if none.
  const std::vector<std::uint32_t>& instancesOf(const std::string& name) const {
    for (const auto* indicesByName : {&instances_, &copies_}) {
      if (const auto entry = indicesByName->find(name); entry != indicesByName->end()) return entry->second;
    }
    std::vector<std::string> names;
    for (const auto& [instanceName, indices] : instances_) names.push_back(instanceName);
    throw InputError(fmt::format("poses: the scene has no object '{}'{}", name, suggestion(name, names)));
  }

  // Returns the motions of all instances of `simulated.objects`; null if `simulated.objects` is empty.
  std::shared_ptr<const Placements> placementsOf(const SimulatedShot& simulated) const {
    if (simulated.objects.empty()) return nullptr;
    auto placed = std::make_shared<Placements>(simulated.time);
    for (const ObjectPose& object : simulated.objects) {
      const std::vector<std::uint32_t>& instances = instancesOf(object.name);
      Affine moved;  // from the object's pose in the scene to its pose in the shot
      if (object.worldFromObject) {
        const Affine inScene = scene().instances[instances.front()].worldFromMeshAt(simulated.time);
        moved = *object.worldFromObject * inverse(rigidPartOf(inScene));
      }
      for (const std::uint32_t index : instances) {
        RigidMotion motion;
        motion.hidden = !object.worldFromObject;
        motion.worldFromMesh = moved * scene().instances[index].worldFromMeshAt(simulated.time);
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

  Plan plan_;
  mutable ShotSource source_;  // its functions may be called from any thread
  ReadyScene ready_;
  // Indices of instances: by their name, and for the copies NAME#1, NAME#2, ... by NAME.
  std::unordered_map<std::string, std::vector<std::uint32_t>> instances_, copies_;
};

// Returns the transform from a 4 x 4 matrix that is stored row by row.
Affine affineOf(const double* m) {
  const auto column = [&](int k) { return Vec3d{m[k], m[4 + k], m[8 + k]}; };
  return {{column(0), column(1), column(2)}, column(3)};
}

py::array_t<double> matrixOf(const Affine& a) {
  const std::array<double, 16> rows = matrixRows(a);
  return arrayOf<double>(std::vector<double>(rows.begin(), rows.end()), {4, 4});
}

// Surfaces are tuples (class, material, reflectance or None, number of the thing or -1).
using SurfaceTuple = std::tuple<std::string, std::string, std::optional<float>, std::int64_t>;

// Converts a part from the dictionary that the Python class Part makes.
ArrayPart partOf(const py::dict& given) {
  ArrayPart part;
  part.name = given["name"].cast<std::string>();
  part.mesh.positions = copied<Vec3f>(given["vertices"].cast<Array<float>>());
  part.mesh.triangles = copied<Triangle>(given["triangles"].cast<Array<std::uint32_t>>());
  part.mesh.surfaceOf = copied<std::uint16_t>(given["surface_of"].cast<Array<std::uint16_t>>());
  for (const auto& [name, material, reflectance, object] : given["surfaces"].cast<std::vector<SurfaceTuple>>()) {
    part.surfaces.push_back({name, material, reflectance.value_or(-1), object});
  }
  const auto pose = given["pose"].cast<Array<double>>();
  if (pose.size() != 16) throw InputError(fmt::format("part '{}': pose must be a matrix of 4 x 4", part.name));
  part.worldFromMesh = affineOf(pose.data());
  return part;
}

// Returns the poses of the objects `names` from arrays: matrices (n, 4, 4), linear and angular velocities (n, 6), and
// whether the objects are left out (n,).
std::vector<ObjectPose> objectPosesOf(const std::vector<std::string>& names, const Array<double>& matrices,
                                      const Array<double>& velocities, const Array<bool>& hidden) {
  const auto v = velocities.unchecked<2>();
  const auto h = hidden.unchecked<1>();
  std::vector<ObjectPose> poses;
  for (py::ssize_t i = 0; i < static_cast<py::ssize_t>(names.size()); ++i) {
    ObjectPose& pose = poses.emplace_back();
    pose.name = names[static_cast<std::size_t>(i)];
    if (!h(i)) pose.worldFromObject = affineOf(matrices.data(i));
    pose.velocity = {v(i, 0), v(i, 1), v(i, 2)};
    pose.turning = {v(i, 3), v(i, 4), v(i, 5)};
  }
  return poses;
}

// Returns poses from an array (n, 7) of quaternions w, x, y, z and translations.
std::vector<Pose> posesOf(const Array<double>& rows) {
  const auto r = rows.unchecked<2>();
  std::vector<Pose> poses;
  for (py::ssize_t i = 0; i < r.shape(0); ++i) {
    const double norm = std::sqrt(r(i, 0) * r(i, 0) + r(i, 1) * r(i, 1) + r(i, 2) * r(i, 2) + r(i, 3) * r(i, 3));
    if (!(std::abs(norm - 1) < 1e-6)) throw InputError("rotation must be a unit quaternion w, x, y, z");
    poses.push_back({{r(i, 0) / norm, r(i, 1) / norm, r(i, 2) / norm, r(i, 3) / norm}, {r(i, 4), r(i, 5), r(i, 6)}});
  }
  return poses;
}

// Returns a dictionary of arrays for each sensor, and the list of objects as JSON. `poses`: an array for each sensor,
// see posesOf(). For the other parameters see objectPosesOf(), SimulatedShot and Target.
py::tuple simulate(const Simulator& simulator, const std::vector<Array<double>>& poses, double time,
                   std::uint32_t frame, const std::vector<std::string>& names, const Array<double>& matrices,
                   const Array<double>& velocities, const Array<bool>& hidden, bool moving, DatasetWriter* writer,
                   const std::string& drive, const std::string& split) {
  SimulatedShot shot{
      .time = time, .frame = frame, .objects = objectPosesOf(names, matrices, velocities, hidden), .moving = moving};
  for (const Array<double>& rows : poses) shot.worldFromVehicle.push_back(posesOf(rows));
  SimulatedFrame made;
  {
    const py::gil_scoped_release released;
    made = simulator.scan(shot, {writer, drive, split});
  }
  py::list scansOfSensors;
  for (SimulatedScan& simulated : made.scans) {
    py::dict arrays = arraysOf(std::move(simulated.scan));
    arrays["world_from_sensor"] = matricesOf(simulated.worldFromSensor);
    scansOfSensors.append(std::move(arrays));
  }
  return py::make_tuple(scansOfSensors, made.objects);
}

}  // namespace

void defineSimulator(py::module_& module) {
  py::class_<Simulator>(module, "Simulator")
      .def(py::init([](const std::string& pipeline, const std::string& folder, const std::vector<py::dict>& given,
                       bool placeable) {
             std::vector<ArrayPart> parts;
             parts.reserve(given.size());
             for (const py::dict& part : given) parts.push_back(partOf(part));
             const py::gil_scoped_release released;
             return std::make_unique<Simulator>(pipeline, folder, std::move(parts), placeable);
           }),
           py::arg("pipeline"), py::arg("folder"), py::arg("parts") = std::vector<py::dict>(),
           py::arg("placeable") = false)
      .def_property_readonly("sensors",
                             [](const Simulator& s) {
                               py::list sensors;
                               for (std::size_t i = 0; i < s.plan().sensors.size(); ++i) {
                                 const BeamTable& beams = *s.plan().sensors[i].beams;
                                 sensors.append(py::make_tuple(s.plan().pipeline.sensors[i].name,
                                                               py::make_tuple(beams.rings, beams.columns),
                                                               staggerOf(beams), beams.columnPeriod() * beams.columns));
                               }
                               return sensors;
                             })
      .def_property_readonly("classes", [](const Simulator& s) { return layOut(ontologyJson(s.scene().ontology)); })
      .def(
          "objects",
          [](const Simulator& s, double time) {
            py::dict all;
            for (const auto& [name, object] : s.objects(time)) {
              all[py::str(name)] = py::make_tuple(matrixOf(object.worldFromObject), object.things, object.moves);
            }
            return all;
          },
          py::arg("time") = 0.0)
      .def("scan", &simulate, py::arg("poses"), py::arg("time"), py::arg("frame"), py::arg("names"),
           py::arg("matrices"), py::arg("velocities"), py::arg("hidden"), py::arg("moving"),
           py::arg("writer") = nullptr, py::arg("drive") = "", py::arg("split") = "");
  py::class_<DatasetWriter>(module, "DatasetWriter")
      .def(py::init([](const std::string& folder, bool overwrite, bool resume, std::uint64_t shardSamples) {
        const FolderUse use = resume ? FolderUse::Resume : overwrite ? FolderUse::Replace : FolderUse::New;
        return std::make_unique<DatasetWriter>(DatasetWriter::Options{folder, use, shardSamples});
      }))
      .def("finish", [](DatasetWriter& writer) { writer.finish(); });
}

}  // namespace scanmill
