#pragma once

// Reads the options of a repeatability study, which are the key `repeatability:` of a pipeline, and finds the object
// that the scans look at. All keys are optional.
//
//   repeatability:
//     scans: 5                      # number of scans from each pose, with consecutive seeds
//     noise:                        # noise levels (default: one, with the pipeline's effects)
//       - {name: 1 cm, effects: [{shell: {scale_m: 0.01}}]}
//       - {name: fitted, effects: sensor}      # the effects in the sensor's file
//     reference: 1 cm               # the level that the first charts show (default: the first)
//     methods: [ray_tracing, {depth_camera: {resolution: 512}}]   # default: the pipeline's method
//     object: crate                 # name of an object in the scene (default: the object nearest to the sensor)
//     margin_m: 0.1                 # points farther from the object's bounding box are removed
//     icp: {iterations: 10, reach_m: 0.5, fitness_within_m: 0.5}  # default: 10 and no limits, as in PCL

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/vec.h"
#include "evaluate/registration.h"
#include "evaluate/settings.h"
#include "pipeline/read/pipeline.h"
#include "scene/scene.h"
#include "sense/sense.h"

namespace scanmill {

struct NoiseLevel {
  std::string name;
  std::vector<std::shared_ptr<const Effects>> effects;  // one list per sensor
  bool fromPipeline = false;                            // true: `noise` is absent; the level has the pipeline's effects
};

struct RepeatabilityChoice {
  std::uint32_t scans = 5;
  std::vector<NoiseLevel> levels;
  std::size_t reference = 0;  // index in `levels` of the level that the first charts show
  std::vector<MethodSetting> methods;
  std::string object;   // name of an object; empty: the object nearest to the sensor
  double margin = 0.1;  // distance (m) from the object's bounding box within which points are kept
  IcpOptions icp;
};

// Reads the key `repeatability` of a pipeline. Throws InputError with file and line.
RepeatabilityChoice readRepeatabilityChoice(const Pipeline& pipeline);

// Returns the layout of scans for the comparison: positions, and the column of each point.
ScanLayout repeatabilityLayout();
// Returns the channels that the effects of all noise levels read. A plan with these channels loads the textures that
// they need.
Channels repeatabilityChannels(const Pipeline& pipeline);

// An object of a scene, with a bounding box along the axes of the object's mesh.
class BoxedObject {
 public:
  BoxedObject(std::string name, const Affine& worldFromMesh, const Box& box);

  const std::string& name() const { return name_; }
  Vec3d center() const { return worldFromMesh_ * box_.center(); }
  // Returns the distance (m) from a point in the world frame to the bounding box; 0 inside of the box. The result is
  // exact if the mesh's axes are perpendicular in the world frame too.
  double distance(const Vec3d& worldPoint) const;

 private:
  std::string name_;
  Affine worldFromMesh_, meshFromWorld_;
  Box box_;
};

// Returns all object instances of a scene, sorted by instance id.
std::vector<BoxedObject> boxedObjects(const Scene& scene);

// Returns the object with this name that is nearest to the sensor's position (world frame, m); if the name is empty,
// the nearest of all objects. `scene`: the scene of the objects, which messages name. Throws InputError if no object
// has the name, or if the scene has no objects.
const BoxedObject& objectToScan(const std::vector<BoxedObject>& objects, const std::string& name,
                                const Vec3d& sensorPosition, const Scene& scene);

}  // namespace scanmill
