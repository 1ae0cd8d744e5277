#pragma once

// A pipeline file: which scenes, sensors and trajectories become which dataset. Everything is checked when it is read.

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

// A sensor on the vehicle. Its beam table is made by Plan, once the totals are known to be sane.
struct MountedSensor {
  std::string name;
  Value description;  // preset and own keys merged
  SensorSize size;
  Pose vehicleFromSensor = {};
  std::shared_ptr<const Effects> effects;  // never null; sensors with the same list share it
};

struct MethodChoice {
  const MethodEntry* entry = nullptr;  // null for `auto`, until it is settled()
  Value options;                       // its map, or that of `auto`; Null where the pipeline gives only the name
  bool automatic = false;              // the pipeline says `method: auto`
};

struct ChosenFormat {
  const FormatEntry* entry = nullptr;
  std::shared_ptr<const Format> format;
};

struct ShardOptions {
  std::uint64_t bytes = 0;  // at most
  std::size_t samples = 0;  // in each; 0: follows from the bytes
  bool shuffled = false;    // samples are spread over the shards of their split at random
};

// What is written.
struct Output {
  ScanLayout layout;
  std::vector<ChosenFormat> formats;
  std::optional<VoxelGrid> voxels;  // about each sensor, that samples have beside scans, see dataset/voxels.h
  bool objects = false;             // samples list the things near their sensors, see dataset/objects.h
  ShardOptions shards;
};

class DrawnSensors;

// A value: copies share what does not change.
struct Pipeline {
  std::string name;
  std::filesystem::path file;
  std::string text;  // as read, with the overrides as comments
  Value root;        // the same as values, of which studies read their own keys
  std::uint64_t seed = 1;
  std::filesystem::path ontology;  // empty: the scenes' own
  std::filesystem::path vehicle;   // scene file of the own vehicle, in its frame; empty: none
  int wavelengthNm = 905;
  std::vector<Sequence> sequences;
  std::vector<MountedSensor> sensors;
  std::shared_ptr<const DrawnSensors> drawn;  // null: sensors and effects are the same in all sequences; else those
                                              // here are of the first frame of the first one
  Motion motion;
  MethodChoice method;
  Output output;
  bool splitsBySeed = false;  // the splits part scenes by their seeds
  double maxRays = 0;

  std::shared_ptr<const Recording> recording;  // where its shots come from, in place of scenes and a method; or null

  std::uint64_t frames() const;
  std::uint64_t beamsPerFrame() const;
  std::uint64_t raysPerFrame() const;
  std::uint32_t raysPerBeam(std::size_t sensor) const;     // of the effect footprint; a recording holds one
  const LightPaths* lightPaths(std::size_t sensor) const;  // of the effect light_paths; null: none
  std::uint32_t mostMet() const;                           // surfaces by a ray
  std::uint32_t mostReturns() const;                       // of a beam
  std::string methodName() const;                          // that made, or makes, the hits
};

// A pose on the vehicle; Null: its origin. Throws InputError.
Pose readMount(const Value& mount);

// Whether an effect sets the intensity; either an effect of every sensor does, or none.
bool setsIntensity(const Pipeline& pipeline);

// `overrides` are the arguments of --set. With a recording, its sequences are the pipeline's: the keys `scenes` and
// `trajectories` are not looked at, nor is `method` for recorded hits. Throws InputError with file:line:column.
Pipeline readPipeline(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                      std::shared_ptr<const Recording> recording = nullptr);

// The same of a pipeline's text, with its overrides applied and as comments at its end, as Pipeline::text and manifests
// have it. `file`: where it would lie, for the files that it names.
Pipeline readPipelineText(const std::string& text, const std::filesystem::path& file);

// The overrides in such a text.
std::vector<std::string> overridesIn(const std::string& text);

}  // namespace scanmill
