#pragma once

// Gives the viewer what it shows: the samples of a dataset or of a shard, a single scan, or a scene.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/vec.h"
#include "dataset/objects.h"
#include "scan/scan.h"
#include "scene/ontology.h"
#include "sensors/beams.h"

namespace scanmill {

// One scan of a sample, and what is known of it besides its columns.
struct ViewScan {
  std::string name;    // tells it from the sample's other scans: "top", "top, particle", "out/b: top"
  std::string sensor;  // empty where unknown
  std::string method;  // empty where unknown
  Scan scan;
  std::optional<Pose> worldFromSensor;  // at the start of the revolution
  double time = 0;                      // s since the start of the sequence
  std::vector<float> error;             // m, one per point, not negative; NaN where unknown; empty where none is known
  std::string errorTitle;               // "distance to the reference (m)", "range error (m)"
  std::shared_ptr<const BeamTable> beams;  // of the dataset's sensor; null where unknown
  std::string whyNoError{};                // what NaN means among errors: "no partner in the reference"; may be empty
};

// A thing near the sensors, as the sample lists it.
struct ViewObject {
  ObjectRecord record;
  // m, world: the middle of its box in this frame and in those about it, in their order; empty for what stands.
  std::vector<Vec3d> track;
};

struct ViewFrame {
  std::string key;
  std::vector<ViewScan> scans;
  std::vector<std::string> problems;  // a line for everything that could not be loaded
  std::vector<ViewObject> objects{};  // empty where the dataset lists none
};

struct SceneChoice {
  std::filesystem::path file;
  std::uint64_t seed = 1;
  double time = 0;                   // s since the drive began: where its moving objects are shown
  std::filesystem::path ontology{};  // in place of its own; empty: its own
  bool operator==(const SceneChoice&) const = default;
};

// What a user wants to see. What is empty is not asked for.
struct ViewInput {
  std::filesystem::path path;  // a dataset's folder, a shard, a scan of any known format, or a scene (.yaml)
  // Further datasets, shards or scans. Their samples are joined by their keys, a single scan with every sample.
  std::vector<std::filesystem::path> over{};
  std::filesystem::path reference{};    // the noise-free reference: a dataset, a shard or a scan
  std::string sensor{};                 // only the scans of this sensor are shown
  std::filesystem::path ontology{};     // a file as labels/*.yaml, in place of the dataset's own ontology
  std::filesystem::path scene{};        // the scene that was scanned, in place of the one that the manifest names
  std::optional<std::uint64_t> seed{};  // of a scene that is viewed by itself
};

// A list of frames that are loaded when they are wanted.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  // The name of the folder or the file that is shown.
  virtual std::string title() const = 0;
  // The names of the frames, in the order in which they are shown. A single scan or a scene is one frame.
  virtual const std::vector<std::string>& keys() const = 0;
  // Names and colours of the classes; null where they are unknown.
  virtual const Ontology* ontology() const = 0;
  // Whether a scene is shown: its frame has no scans, only what scene() names.
  virtual bool isScene() const = 0;
  // Loads a frame; any thread may call it. Faults of the data do not throw: a damaged or missing shard, a member that
  // cannot be decoded, or a sample that a further dataset lacks becomes one of the frame's problems, which names the
  // file and says what to do.
  virtual ViewFrame load(std::size_t frame) const = 0;
  // Where the sensor of the first scan stood in every frame of the frame's sequence, as worldFromSensor, in the order
  // of the frames. Empty where that is unknown.
  virtual std::vector<Pose> trajectory(std::size_t frame) const = 0;
  // The scene that the frame was made of. Absent where it is unknown or its file is missing; then `why` says so.
  virtual std::optional<SceneChoice> scene(std::size_t frame, std::string& why) const = 0;
  // The ids of all classes that occur in the frames, ascending; empty where they are unknown.
  virtual std::vector<std::uint16_t> classes() const { return {}; }
  // The indices of frames that cannot be shown, as far as they are known by now, ascending. Any thread may call it.
  virtual std::vector<std::size_t> damaged() const { return {}; }
};

// Opens what a user wants to see: reads the manifest and the directories of the shards, but no scan of a dataset.
// Throws InputError where there is nothing to show: the file does not exist or is of no known kind, the manifest or a
// single scan cannot be read, or there is no such sensor.
std::unique_ptr<FrameSource> openFrames(const ViewInput& input);

// The index of the frame that is `wanted`: its key, a part of it that no other key has, or its index from 0; where
// `wanted` is empty, the middle frame. Throws InputError with the nearest keys.
std::size_t findFrame(const FrameSource& source, const std::string& wanted);

}  // namespace scanmill
