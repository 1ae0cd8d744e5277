#pragma once

// A pipeline file says which scenes, sensors and trajectories become which dataset. All its keys are checked when it is
// read.
//
//   const Pipeline pipeline = readPipeline("pipelines/street.yaml", {"seed=7", "effects=[]"});  // as with --set

#include <fmt/core.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"
#include "config/fields.h"
#include "config/value.h"
#include "dataset/manifest.h"
#include "dataset/recording.h"
#include "formats/format.h"
#include "methods/method.h"
#include "scene/voxel_grid.h"
#include "sense/sense.h"
#include "sensors/sensor.h"
#include "sensors/shot.h"

namespace scanmill {

class Trajectory;

// Durations of the fastest and of the slowest sensor's revolution (s).
struct Periods {
  double shortest = 0.1;
  double longest = 0.1;
};

// One scene with one procedural seed, driven along one trajectory. All its frames belong to the same split.
struct Sequence {
  std::string scene;  // the scene file's name without its suffix, in the form of keyPart()
  std::filesystem::path sceneFile;
  std::uint64_t sceneSeed = 1;
  std::shared_ptr<const Trajectory> trajectory;  // null if the shots come from a recording
  std::string trajectoryName;
  std::uint32_t frames = 0;
  std::string split = {};
  bool moving = true;               // false: objects stay at their positions at time 0 s
  std::vector<Value> without = {};  // classes, names or ids of objects to remove from the scene, see takeOut()

  // True if sensors of different rates turn without a break from the start of the sequence: the time from frame to
  // frame is not longer than a revolution of the slowest sensor, and not shorter than a revolution of the fastest.
  bool turnsWithoutBreak(const Periods& periods) const;
  // Returns the start times of a sensor's revolutions that belong to a frame (s after the frame's start, may be
  // negative). `period`: duration of the sensor's revolution (s). If the sensors turn without a break, these are the
  // revolutions that end after the frame's start but not after the next frame's start: several of a fast sensor, at
  // times none of a slow one. Otherwise every sensor starts its first revolution at the frame's start, and the frame
  // has the revolutions that end within the slowest sensor's period. If the next frame starts before that period has
  // passed, the frame has only the first revolution.
  std::vector<double> revolutions(std::uint32_t frame, double period, const Periods& periods) const;
  double totalRevolutions(double period, const Periods& periods) const;        // total of all frames
  std::uint32_t mostRevolutions(double period, const Periods& periods) const;  // maximum per frame

  bool sameScene(const Sequence& other) const;
  // Returns at most `most` frame numbers, spread evenly over the sequence.
  std::vector<std::uint32_t> spreadFrames(std::uint32_t most) const;
  // Returns the scene with its seed, such as "street-s1".
  std::string sceneName() const { return fmt::format("{}-s{}", scene, sceneSeed); }
  std::string key() const;  // key of the sequence, such as "street-s1-lane": scene, seed and trajectory
  // Returns the key of a sample, such as "street-s1-lane-000012".
  std::string key(std::uint32_t frame) const { return fmt::format("{}-{:06}", key(), frame); }
};

// Returns the text as a part of sample keys, which are ASCII without dots and slashes. Letters become lower case;
// digits, '-' and '_' stay; other Unicode characters become their code ("u5317"), other ASCII characters '_'.
std::string keyPart(std::string_view text);

// Returns one sequence for each combination of scene, seed and trajectory. `period`: duration of the slowest sensor's
// revolution (s). Calls `checkFrames` repeatedly with a lower bound of the number of frames, first before any scene
// file is read. Throws InputError.
std::vector<Sequence> readSequences(Fields& fields, double period,
                                    const std::function<void(std::uint64_t)>& checkFrames);
// Returns the sequences of a recording. Throws InputError if the pipeline's key `without` differs from the recording's,
// since objects cannot be removed from recorded hits.
std::vector<Sequence> recordedSequences(const Recording& recording, Fields& fields);

// A sensor on the vehicle. makePlan() builds its beam table after it has checked the total number of rays.
struct MountedSensor {
  std::string name;
  std::string key;  // in the pipeline, as in --set: "sensors.0", or "sensors.0.choice.1" for one of a random choice
  // Key of the random choice of which each sequence has one sensor, "sensors.0"; empty: all sequences have this sensor.
  std::string choice;
  std::size_t alternatives = 1;  // number of sensors in the choice
  Value description;             // the keys of the sensor's preset file, overridden by those of the pipeline
  SensorSize size;
  Pose vehicleFromSensor = {};
  double period = 0.1;            // s, duration of a revolution
  std::uint32_t revolutions = 1;  // greatest number of revolutions in one sample
  // Never null. All sensors share one list, unless the pipeline's key `effects` contains the word `sensor`.
  std::shared_ptr<const Effects> effects;

  std::uint64_t beams() const { return size.rings * size.columns; }  // in a revolution
};

struct MethodChoice {
  const MethodEntry* entry = nullptr;  // null only for a recording, if the pipeline names no method
  Value options;                       // map of the method's options; Null: no options are given
};

struct ChosenFormat {
  const FormatEntry* entry = nullptr;
  std::shared_ptr<const Format> format;
};

struct ShardOptions {
  std::uint64_t bytes = 0;  // maximum size of a shard
  std::size_t samples = 0;  // number of samples per shard; 0: computed from `bytes`
  bool shuffled = false;    // samples are distributed at random over the shards of their split
};

// The contents and formats of samples, and their distribution over shards.
// The objects that the samples list, with their boxes (dataset/objects.h).
struct ListedObjects {
  bool all = false;  // all objects; false: those of `classes`, or if it is empty, of the classes of road users
  std::vector<std::string> classes = {};
  Location where = {};
};

struct Output {
  ScanLayout layout;
  std::vector<ChosenFormat> formats;
  std::optional<VoxelGrid> voxels;       // voxel grid around each sensor, see dataset/voxels.h; nothing: no voxels
  std::optional<ListedObjects> objects;  // nothing: no lists of objects
  ShardOptions shards;
};

class DrawnSensors;

// A pipeline as it was read. Copies are cheap, since they share their constant parts.
struct Pipeline {
  std::string name;
  std::map<std::string, std::string> about;  // description, license and so on, see Manifest::about
  std::filesystem::path file;
  std::string text;  // the file's text, with the overrides appended as comments
  Value root;        // the parsed text; studies read their keys from it
  std::uint64_t seed = 1;
  std::filesystem::path ontology;  // file that replaces the scenes' ontologies; empty: each scene's ontology is used
  std::filesystem::path vehicle;   // scene file of the ego vehicle, in the vehicle's frame; empty: no vehicle
  bool dropVehicle = false;        // true: beams that hit the ego vehicle have no return
  int wavelengthNm = 905;
  std::vector<FileRecord> files;  // files that trajectories and sensors were read from, see Manifest::files
  std::vector<Sequence> sequences;
  std::vector<MountedSensor> sensors;
  Periods periods;  // of the sensors' revolutions
  // The list `effects` with the corruption applied, with the random values of the first frame of the first sequence.
  // The word `sensor` in it is not replaced yet. Studies vary this list.
  std::vector<Value> effectItems;
  // Random mounts and effects, of which `sensors` has the values in the first frame of the first sequence. Null: mounts
  // and effects are the same in all frames.
  std::shared_ptr<const DrawnSensors> drawn;
  Motion motion;
  MethodChoice method;
  Output output;
  bool splitsBySeed = false;  // sequences are assigned to splits by the seeds of their scenes
  double maxRays = 0;

  // The hits come from this recording instead of from scenes and a method; null: no recording.
  std::shared_ptr<const Recording> recording;

  std::uint64_t frames() const;
  // Return the numbers of beams and rays in one revolution of every sensor, and of rays in all samples.
  std::uint64_t beamsPerFrame() const;
  std::uint64_t raysPerFrame() const;
  double rays() const;
  // Returns true if each sample has exactly one revolution of each sensor.
  bool oneRevolution() const;
  std::uint32_t raysPerBeam(std::size_t sensor) const;  // set by the effect `footprint`; 1 for a recording
  // Returns the light paths that the effect `light_paths` of a sensor describes; null if the sensor does not have this
  // effect.
  const LightPaths* lightPaths(std::size_t sensor) const;
  // Returns the effects of a sensor in the first frame, then its effects in each of DrawnSensors::cases(), if any.
  std::vector<const Effects*> effectCases(std::size_t sensor) const;
  std::uint32_t mostReturns() const;  // maximum number of returns of a beam
  std::string methodName() const;     // name of the method that computes the hits, or that computed the recorded hits
};

// Reads and checks the key `output` of a pipeline. Throws InputError.
Output readOutput(const Value& value);

// Reads the pose of a sensor in the vehicle's frame; Null means the vehicle's origin. `vehicle`: the vehicle's scene
// file, which has the robot's links; may be empty. Throws InputError.
Pose readMount(const Value& mount, const std::filesystem::path& vehicle);

// True if an effect sets the intensity. Either every sensor has such an effect, or none has.
bool setsIntensity(const Pipeline& pipeline);

// Reads a pipeline file. `overrides`: the arguments of --set. With a recording, the pipeline has the recording's
// sequences: the key `trajectories` is ignored; `method` is ignored for recorded hits; and of the key `scenes`, only
// `without` is checked. Throws InputError with file:line:column.
Pipeline readPipeline(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                      std::shared_ptr<const Recording> recording = nullptr);

// Reads a pipeline from a text, such as Pipeline::text or a manifest's text, and applies the overrides in the comments
// at the text's end. `file`: the path that the text is assumed to have; the text's relative paths start at its folder.
Pipeline readPipelineText(const std::string& text, const std::filesystem::path& file);

// Returns the overrides in the comments at the end of a pipeline's text.
std::vector<std::string> overridesIn(const std::string& text);

}  // namespace scanmill
