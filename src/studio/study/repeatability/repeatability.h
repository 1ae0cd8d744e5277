#pragma once

// Measures how well repeated scans of an object agree, with the ICP protocol of the paper "LiDAR-GEIL: LiDAR GPU
// Exploitation in Lightsimulations" (its Figures 10, 11 and 13). From each pose, the object is scanned several times
// with different noise, and each scan is cropped to the object. One scan is then registered to another by ICP, and the
// fitness is measured.

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/vec.h"
#include "evaluate/registration.h"
#include "evaluate/settings.h"
#include "pipeline/plan/plan.h"
#include "pipeline/read/pipeline.h"
#include "scene/scene.h"
#include "sense/sense.h"

namespace scanmill {

// Numbers of points on the object in the scans from one pose with one noise level.
struct PointCount {
  double mean = 0;
  std::uint64_t least = 0, most = 0;
};

// The fitness of all ordered pairs of scans with different seeds, for one noise level of the source and one of the
// target. The fitness is the mean squared distance (m²) from the source's points to the nearest points of the target.
struct LevelFitness {
  FitnessSpread registered;  // fitness after ICP; only pairs for which ICP finds a motion, see Registered::moved
  FitnessSpread unmoved;    // fitness without ICP (both scans have the same pose); only pairs with points in both scans
  std::uint64_t pairs = 0;  // number of all pairs
};

// The results for one pose of the sensor.
struct RepeatedPose {
  std::uint32_t frame = 0;
  std::string object;
  double distance = 0;                  // distance from the sensor to the object's bounding box (m)
  std::vector<PointCount> points{};     // one per noise level
  std::vector<LevelFitness> fitness{};  // index: source level * number of levels + target level
};

struct RepeatedView {
  std::size_t method = 0;  // index in Repeatability::methods
  // The view's name, such as "small_box front". It consists of the scene, the seed if there are several seeds, the
  // trajectory, and the sensor if there are several sensors.
  std::string name;
  std::string sensor;  // the sensor with its size, such as "lidar0 (OS1-128, 128 x 1024 beams)"
  std::vector<RepeatedPose> poses;
};

struct Repeatability {
  static constexpr int kSchemaVersion = 2;
  std::string programVersion;
  std::string pipelineName;
  std::string pipelineText;  // the pipeline's text with overrides as comments, see Pipeline::text
  std::uint64_t seed = 0;    // seed of the first scan; further scans have the following numbers
  std::uint32_t scans = 0;   // number of scans from each pose
  double margin = 0;         // points farther from the object's bounding box than this (m) are removed
  int icpIterations = kIcpIterations;
  std::vector<std::string> methods;  // names of the settings
  std::vector<std::string> levels;   // names of the noise levels
  std::size_t reference = 0;         // index in `levels` of the level that the first charts show
  std::vector<RepeatedView> views;
  std::vector<std::string> warnings;  // sentences about figures that are not meaningful

  const LevelFitness& at(const RepeatedPose& pose, std::size_t source, std::size_t target) const {
    return pose.fitness[source * levels.size() + target];
  }
};

// The options of a study are the key `repeatability:` of a pipeline. All keys in it are optional.
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
//     icp: {iterations: 10}         # the default, as in PCL
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
  int icpIterations = kIcpIterations;
};

// Reads the key `repeatability` of a pipeline; absent keys have the defaults. Throws InputError with file and line.
RepeatabilityChoice readRepeatabilityChoice(const Pipeline& pipeline);

// The layout of scans for the comparison: positions, and the column of each point.
inline const ScanLayout kRepeatabilityLayout{ColumnSet(kColumn), false};
// Returns the channels that the effects of all noise levels read. A plan with these channels loads the textures.
Channels repeatabilityChannels(const Pipeline& pipeline);

// An object of a scene, with a bounding box along the axes of the object's mesh.
struct BoxedObject {
  std::string name;
  Affine worldFromMesh, meshFromWorld;
  Box box;

  Vec3d center() const { return worldFromMesh * box.center(); }
  // Returns the distance (m) from a point in the world frame to the bounding box; 0 inside of the box. The result is
  // exact if the mesh's axes are perpendicular in the world frame too.
  double distance(const Vec3d& worldPoint) const;
};

struct RepeatabilityOptions {
  bool quiet = false;
  const std::atomic<bool>* stop = nullptr;
};

// Runs the study that the pipeline's key `repeatability` describes. The plan must have been made with
// repeatabilityChannels(). Throws InputError for unusable input.
Repeatability measureRepeatability(const Plan& plan, const RepeatabilityOptions& options);

// Returns the result as JSON. The same figures always give the same bytes.
std::string repeatabilityJson(const Repeatability& result);

}  // namespace scanmill
