#pragma once

// Provides the frames that the viewer shows: the samples of a dataset or of a shard, a single scan, or a scene.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/vec.h"
#include "dataset/names.h"
#include "dataset/objects.h"
#include "scan/scan.h"
#include "scene/ontology.h"
#include "sensors/beams.h"
#include "viewer/coloring.h"

namespace scanmill {

// One scan of a sample, with data that are not in its columns.
struct ViewScan {
  std::string name;              // unique within the sample, such as "top", "top, particle" or "out/b: top"
  std::string sensor;            // name of the sensor; empty if unknown
  std::uint32_t revolution = 0;  // index among the sensor's revolutions in the sample
  std::string method;            // name of the method; empty if unknown
  std::size_t store = 0;         // 0: the scan is from ViewInput::path; n: from entry n - 1 of ViewInput::over
  Scan scan;
  // Positions of the points (m) in the sensor's frame at the start of the revolution; empty: Scan::position has them.
  std::vector<Vec3f> placed{};
  std::optional<Pose> worldFromSensor;  // sensor pose at the start of the revolution; absent if unknown
  double time = 0;                      // time since the start of the sequence (s)
  std::vector<float> error;             // error of each point (m), at least 0; NaN: unknown; empty: all unknown
  // Title of the legend for `error`, such as "distance to the reference (m)" or "range error (m)".
  std::string errorTitle;
  std::shared_ptr<const BeamTable> beams;  // beam table of the sensor; null if unknown
  std::string whyNoError{};            // what NaN in `error` means, such as "no partner in the reference"; may be empty
  std::optional<Coloring> coloring{};  // the colours in which the scan is always shown; absent: the user chooses

  const std::vector<Vec3f>& drawnPositions() const { return placed.empty() ? scan.position : placed; }
};

struct ViewFrame {
  std::string key;
  std::vector<ViewScan> scans;
  std::vector<std::string> problems;       // one line for each part of the frame that could not be loaded
  std::vector<ObjectRecord> objects{};     // the sample's list of objects; empty if the dataset has no such lists
  double objectTime = 0;                   // time of ObjectRecord::worldFromBox (s since the start of the sequence)
  std::optional<Pose> worldFromVehicle{};  // pose of the ego vehicle; absent if it was not modelled or is unknown
};

struct SceneChoice {
  std::filesystem::path file;
  std::uint64_t seed = 1;
  double time = 0;  // time for which moving objects are shown (s since the drive began)
  // File of an ontology that replaces the scene's ontology; empty: the scene's ontology is used.
  std::filesystem::path ontology{};
  bool operator==(const SceneChoice&) const = default;
};

// The user's choice of what to show. Empty members mean that nothing was chosen.
struct ViewInput {
  std::filesystem::path path;  // folder of a dataset, a shard, a scan of any known format, or a scene (.yaml)
  // Further datasets, shards or scans to show on top. Samples with the same key are combined; a single scan is combined
  // with every sample.
  std::vector<std::filesystem::path> over{};
  std::filesystem::path reference{};  // noise-free reference of the scans: a dataset, a shard or a scan
  std::string sensor{};               // if not empty, only scans of this sensor are shown
  // File of an ontology that replaces the dataset's ontology.
  std::filesystem::path ontology{};
  // File of the scene that was scanned; empty: the file that the manifest names.
  std::filesystem::path scene{};
  // Seed of `scene`, or of `path` if this is a scene; absent: the seed of the dataset's sequence or, without one, 1.
  std::optional<std::uint64_t> seed{};
};

// A list of frames, each of which is loaded when it is requested.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  // Returns the name of the folder or file that is shown.
  virtual std::string title() const = 0;
  // Returns the names of the frames, in the order in which they are shown. A single scan or a scene is one frame.
  virtual const std::vector<std::string>& keys() const = 0;
  // Returns the names and colours of classes; null if they are unknown.
  virtual const Ontology* ontology() const = 0;
  // True if a scene is shown without scans. Then the source has one frame without scans, and scene() returns the scene.
  virtual bool isScene() const { return false; }
  // If the frame is a map of a sequence, returns the source of the sequence's samples; otherwise null.
  virtual std::shared_ptr<const FrameSource> samples() const { return nullptr; }
  // Returns the index of a frame. `name`: the frame's key, a part of the key that no other key contains, or its index
  // from 0; empty: the middle frame. Throws InputError if there is no such frame; the message lists similar keys.
  virtual std::size_t find(const std::string& name) const { return findKey(keys(), name, title()); }
  // Loads a frame. May be called from any thread. Does not throw for faults in the data, such as a damaged or missing
  // shard, a member that cannot be decoded, or a sample that is missing in a further dataset. These are reported in
  // ViewFrame::problems, with the file and what to do.
  virtual ViewFrame load(std::size_t frame) const = 0;
  // Makes a load() on another thread return soon, with an incomplete frame, if it would take long.
  virtual void stop() const {}
  // Returns the trajectory of the sequence that contains the frame: in each frame, the pose worldFromSensor of the
  // first shown scan with a known pose. Returns nothing if the poses are unknown.
  virtual std::vector<Pose> trajectory(std::size_t /*frame*/) const { return {}; }
  // Returns the scene in which the frame was scanned. If it is unknown or missing, returns nothing and sets `why`.
  virtual std::optional<SceneChoice> scene(std::size_t /*frame*/, std::string& /*why*/) const { return {}; }
  // Returns the scene file of the ego vehicle; nothing if there is none, or if the file is missing.
  virtual std::optional<std::filesystem::path> vehicle() const { return {}; }
  // Returns the ids of all classes that occur in the frames, ascending; empty if this is unknown.
  virtual std::vector<std::uint16_t> classes() const { return {}; }
};

// A source of one frame: a scan in memory, or a scene without scans.
class OneFrame final : public FrameSource {
 public:
  explicit OneFrame(ViewFrame frame, std::optional<SceneChoice> scene = {}, std::optional<Ontology> ontology = {})
      : keys_{frame.key}, frame_(std::move(frame)), scene_(std::move(scene)), ontology_(std::move(ontology)) {}
  std::string title() const override { return frame_.key; }
  const std::vector<std::string>& keys() const override { return keys_; }
  const Ontology* ontology() const override { return ontology_ ? &*ontology_ : nullptr; }
  bool isScene() const override { return scene_.has_value(); }
  ViewFrame load(std::size_t) const override { return frame_; }
  std::optional<SceneChoice> scene(std::size_t, std::string&) const override { return scene_; }

 private:
  std::vector<std::string> keys_;
  ViewFrame frame_;
  std::optional<SceneChoice> scene_;
  std::optional<Ontology> ontology_;
};

// Opens what the user wants to see. Reads the manifest and the directories of shards, but no scans of a dataset. Throws
// InputError if nothing can be shown: the file does not exist or is of an unknown kind, the manifest or a single scan
// cannot be read, or there is no such sensor.
std::unique_ptr<FrameSource> openFrames(const ViewInput& input);

constexpr double kFinestMapVoxel = 0.05;         // least edge of a map's voxels (m)
constexpr std::size_t kMostMapPoints = 3000000;  // largest number of points of a map

// Returns a source of one frame: a map of the sequence to which a sample belongs. `name`: a part of the sequence's name
// that no other sequence has, or a sample, see FrameSource::find(). The
// map has the points of all samples of the sequence, in the level frame of the first sensor pose, thinned to one point
// per voxel. If these are more than `mostPoints`, the edge of the voxels is doubled until they are not. Each method,
// and each entry of ViewInput::over, has its own map. Throws InputError for a scene, or if there is no such sample.
std::shared_ptr<const FrameSource> mapOf(std::shared_ptr<const FrameSource> samples, const std::string& name,
                                         std::size_t mostPoints = kMostMapPoints);

}  // namespace scanmill
