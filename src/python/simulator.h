#pragma once

// The class Simulator holds a scene, its sensors and a simulation method, and makes scans from any pose.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "pipeline/plan/plan.h"
#include "pipeline/run/run_shot.h"
#include "scene/builder.h"

namespace scanmill {

// Objects of a scene that Python gives as arrays. The module scanmill.parts checks the arrays before they come here.

// One class, material and thing of a part's triangles.
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

// Adds the parts to a scene. Throws an InputError that names the part, for a name that the scene or another part has
// already, and for unknown classes and materials.
void addParts(SceneBuilder& builder, const std::vector<ArrayPart>& parts);

struct SimulatedScan {
  Scan scan;
  std::vector<Pose> worldFromSensor;  // sensor pose at each step of the revolution
};

// States where an object of the scene is at the start of a scan, and how it moves during the scan.
struct ObjectPose {
  std::string name;
  std::optional<Affine> worldFromObject;  // without scale; none: the object is left out of the scan
  Vec3d velocity;                         // m/s, world axes
  Vec3d turning;                          // rad/s, world axes, about the object's origin
};

struct SimulatedShot {
  std::vector<std::vector<Pose>> worldFromVehicle = {};  // for each sensor, the poses at equal steps of its revolution
  double time = 0;                                       // s since the drive began, at the start of the revolution
  std::uint32_t frame = 0;                               // selects the noise
  std::vector<ObjectPose> objects = {};                  // the objects that are not where the scene places them
  bool moving = false;                                   // true: objects move during the revolution
};

// An object of the scene: all instances that share a name.
struct SceneObject {
  Affine worldFromObject;             // without scale; that of its first instance
  std::vector<std::uint32_t> things;  // ids of its things, ascending
  bool moves = false;                 // true: it moves by itself
};

// Makes scans of one scene. Safe to use from several threads.
class Simulator {
 public:
  // `pipeline`: text of a pipeline with one sequence. Relative paths in the text start at `folder`. `parts` are added
  // to the scene. If `placeable`, scans may place objects. Throws InputError.
  Simulator(const std::string& pipeline, const std::filesystem::path& folder, std::vector<ArrayPart> parts = {},
            bool placeable = false);

  // Returns one scan per sensor. If all objects are where the scene places them and stand still during the revolution,
  // they are equal to those that `scanmill generate` makes with this pipeline for the frame number `frame`, but with
  // the vehicle at these poses. Throws InputError for an unknown object.
  std::vector<SimulatedScan> scan(const SimulatedShot& simulated) const;

  // Returns the objects of the scene, by their names, at a time (s since the drive began).
  std::unordered_map<std::string, SceneObject> objects(double time) const;

  const Plan& plan() const { return plan_; }
  const Scene& scene() const { return scene_; }

 private:
  std::shared_ptr<const Placements> placementsOf(const SimulatedShot& simulated) const;
  const std::vector<std::uint32_t>& instancesOf(const std::string& name) const;

  Plan plan_;
  mutable ShotSource source_;  // its functions may be called from any thread
  Scene scene_;
  std::unique_ptr<Method> method_;
  // The indices of the instances with each name, and of the copies NAME#1, NAME#2, ... of each NAME.
  std::unordered_map<std::string, std::vector<std::uint32_t>> instances_, copies_;
};

}  // namespace scanmill
