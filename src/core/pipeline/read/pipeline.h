#pragma once

// A pipeline file: which scenes, sensors and trajectories become which dataset. Everything is checked when it is read.
//
//   const Pipeline pipeline = readPipeline("pipelines/street.yaml", {"seed=7", "effects=[]"});  // --set

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"
#include "config/value.h"
#include "dataset/recording.h"
#include "formats/format.h"
#include "methods/method.h"
#include "pipeline/read/sequences.h"
#include "scene/voxel_grid.h"
#include "sense/sense.h"
#include "sensors/sensor.h"
#include "sensors/shot.h"

namespace scanmill {

// A sensor on the vehicle. Its beam table is built later, by makePlan(), after the total number of rays was checked.
struct MountedSensor {
  std::string name;
  Value description;  // preset and own keys merged
  SensorSize size;
  Pose vehicleFromSensor = {};
  std::shared_ptr<const Effects> effects;  // never null; shared by all sensors unless the list says `sensor`
};

struct MethodChoice {
  const MethodEntry* entry = nullptr;  // null for `auto`, until settled() has replaced it
  Value options;                       // map of the options of the method or of `auto`; Null: only the name is given
  bool automatic = false;              // the pipeline says `method: auto`
};

struct ChosenFormat {
  const FormatEntry* entry = nullptr;
  std::shared_ptr<const Format> format;
};

struct ShardOptions {
  std::uint64_t bytes = 0;  // upper bound for a shard
  std::size_t samples = 0;  // in each shard; 0: follows from `bytes`
  bool shuffled = false;    // samples are spread over the shards of their split at random
};

// The contents of samples, their formats and the shards.
struct Output {
  ScanLayout layout;
  std::vector<ChosenFormat> formats;
  std::optional<VoxelGrid> voxels;  // grid around each sensor, written beside the scans, see dataset/voxels.h
  bool objects = false;             // samples list the objects near their sensors, see dataset/objects.h
  ShardOptions shards;
};

class DrawnSensors;

// A value type; copies share their constant parts.
struct Pipeline {
  std::string name;
  std::filesystem::path file;
  std::string text;  // as read, with the overrides as comments
  Value root;        // the parsed text, from which studies read their own keys
  std::uint64_t seed = 1;
  std::filesystem::path ontology;  // empty: the scenes' own
  std::filesystem::path vehicle;   // scene file of the own vehicle, in its frame; empty: none
  int wavelengthNm = 905;
  std::vector<Sequence> sequences;
  std::vector<MountedSensor> sensors;
  // The list `effects` with its corruption, as in the first frame of the first sequence: for studies that vary it. The
  // word `sensor` stands for the sensors' own.
  std::vector<Value> effectItems;
  std::shared_ptr<const DrawnSensors> drawn;  // null: sensors and effects are the same in all sequences; else `sensors`
                                              // has those of the first frame of the first sequence
  Motion motion;
  MethodChoice method;
  Output output;
  bool splitsBySeed = false;  // splits are assigned by the seeds of the scenes
  double maxRays = 0;

  std::shared_ptr<const Recording> recording;  // source of the hits in place of scenes and a method; null: none

  std::uint64_t frames() const;
  std::uint64_t beamsPerFrame() const;
  std::uint64_t raysPerFrame() const;
  std::uint32_t raysPerBeam(std::size_t sensor) const;  // as the effect footprint says; 1 for a recording
  const LightPaths* lightPaths(
      std::size_t sensor) const;      // the paths of the effect light_paths; null: the sensor does not have the effect
  std::uint32_t mostMet() const;      // most surfaces that a ray hits
  std::uint32_t mostReturns() const;  // most returns of a beam
  std::string methodName() const;     // the name of the method that made, or will make, the hits
};

// Reads the pose of a sensor on the vehicle; Null is the vehicle's origin. Throws InputError.
Pose readMount(const Value& mount);

// True if an effect sets the intensity. Either every sensor has such an effect, or none has.
bool setsIntensity(const Pipeline& pipeline);

// Reads a pipeline file. `overrides` are the arguments of --set. With a recording, the pipeline has the recording's
// sequences: the key `trajectories` and, for recorded hits, `method` are ignored, and of `scenes` only `without` is
// checked. Throws InputError with file:line:column.
Pipeline readPipeline(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                      std::shared_ptr<const Recording> recording = nullptr);

// Reads a pipeline from a text such as Pipeline::text or that of a manifest, and applies the overrides in the comments
// at its end. `file`: the path that the text is taken to have; the files that it names are relative to it.
Pipeline readPipelineText(const std::string& text, const std::filesystem::path& file);

// Returns the overrides in the comments at the end of such a text.
std::vector<std::string> overridesIn(const std::string& text);

}  // namespace scanmill
