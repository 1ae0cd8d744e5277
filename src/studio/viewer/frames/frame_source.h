#pragma once

// Gives the viewer its frames: the samples of a dataset or of a shard, a single scan, or a scene.

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

// One scan of a sample, and its data besides its columns.
struct ViewScan {
  std::string name;    // unique among the sample's scans: "top", "top, particle", "out/b: top"
  std::string sensor;  // empty if unknown
  std::string method;  // empty if unknown
  Scan scan;
  std::optional<Pose> worldFromSensor;     // at the start of the revolution
  double time = 0;                         // s since the start of the sequence
  std::vector<float> error;                // m, one per point, not negative; NaN: unknown; empty: all unknown
  std::string errorTitle;                  // "distance to the reference (m)", "range error (m)"
  std::shared_ptr<const BeamTable> beams;  // the table of the dataset's sensor; null if unknown
  std::string whyNoError{};                // the meaning of NaN in `error`: "no partner in the reference"; may be empty
};

// An object instance near the sensors, as the sample lists it.
struct ViewObject {
  ObjectRecord record;
  // m, world: the centre of its box in this frame and the neighbouring frames, in their order; empty if it is static.
  std::vector<Vec3d> track;
};

struct ViewFrame {
  std::string key;
  std::vector<ViewScan> scans;
  std::vector<std::string> problems;  // a line for everything that could not be loaded
  std::vector<ViewObject> objects{};  // empty if the dataset lists none
};

struct SceneChoice {
  std::filesystem::path file;
  std::uint64_t seed = 1;
  double time = 0;                   // s since the drive began: the time at which moving objects are shown
  std::filesystem::path ontology{};  // replaces the scene's ontology; empty: the scene's own
  bool operator==(const SceneChoice&) const = default;
};

// The user's choice of what is shown. Empty members are not requested.
struct ViewInput {
  std::filesystem::path path;  // a dataset's folder, a shard, a scan of any known format, or a scene (.yaml)
  // Further datasets, shards or scans. Their samples are joined by their keys, a single scan with every sample.
  std::vector<std::filesystem::path> over{};
  std::filesystem::path reference{};    // the noise-free reference: a dataset, a shard or a scan
  std::string sensor{};                 // only the scans of this sensor are shown
  std::filesystem::path ontology{};     // a file like labels/*.yaml that replaces the dataset's own ontology
  std::filesystem::path scene{};        // the scene that was scanned; replaces the scene that the manifest names
  std::optional<std::uint64_t> seed{};  // the seed of a scene that is viewed without scans
};

// A list of frames that are loaded on demand.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  // Returns the name of the folder or the file that is shown.
  virtual std::string title() const = 0;
  // Returns the names of the frames, in the order in which they are shown. A single scan or a scene is one frame.
  virtual const std::vector<std::string>& keys() const = 0;
  // Returns the names and colours of the classes; null if they are unknown.
  virtual const Ontology* ontology() const = 0;
  // True if a scene is shown: its only frame has no scans, only the scene that scene() returns.
  virtual bool isScene() const = 0;
  // Loads a frame; any thread may call load(). Faults of the data do not throw: a damaged or missing shard, a member
  // that cannot be decoded, or a sample that a further dataset lacks becomes one of the frame's problems, which names
  // the file and says what to do.
  virtual ViewFrame load(std::size_t frame) const = 0;
  // Returns the pose (worldFromSensor) of the first scan's sensor in every frame of this frame's sequence, in the order
  // of the frames. Empty if the poses are unknown.
  virtual std::vector<Pose> trajectory(std::size_t frame) const = 0;
  // Returns the scene that the frame was scanned in. Absent if the scene is unknown or its file is missing; then `why`
  // says which.
  virtual std::optional<SceneChoice> scene(std::size_t frame, std::string& why) const = 0;
  // Returns the ids of all classes that occur in the frames, ascending; empty if they are unknown.
  virtual std::vector<std::uint16_t> classes() const { return {}; }
  // Returns the indices of frames that are known so far to be unreadable, ascending. Any thread may call damaged().
  virtual std::vector<std::size_t> damaged() const { return {}; }
};

// Opens the user's choice: reads the manifest and the directories of the shards, but no scan of a dataset. Throws
// InputError if there is nothing to show: the file does not exist or is of no known kind, the manifest or a single scan
// cannot be read, or the sensor does not exist.
std::unique_ptr<FrameSource> openFrames(const ViewInput& input);

// Returns the index of the frame that `wanted` names: by its key, by a part of the key that occurs in no other key, or
// by its index from 0; an empty `wanted` is the middle frame. Throws InputError that lists the most similar keys.
std::size_t findFrame(const FrameSource& source, const std::string& wanted);

}  // namespace scanmill
