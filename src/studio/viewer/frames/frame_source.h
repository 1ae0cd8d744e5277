#pragma once

// What the viewer shows: the samples of a dataset or a shard, a single scan, or a scene.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/vec.h"
#include "scan/scan.h"
#include "scene/ontology.h"
#include "sensors/beams.h"

namespace scanmill {

// One scan of a sample, and what is known of it besides its columns.
struct ViewScan {
  std::string name;    // what tells it from the sample's others: "top", "top, particle", "out/b: top"
  std::string sensor;  // these two are empty where unknown
  std::string method;
  Scan scan;
  std::optional<Pose> worldFromSensor;     // at the start of the turn
  double time = 0;                         // s since the start of the sequence
  std::vector<float> error;                // m, one per point, not negative; NaN where unknown; empty: nothing is known
  std::string errorTitle;                  // "distance to the twin (m)", "range error (m)"
  std::shared_ptr<const BeamTable> beams;  // of the dataset's sensor; null where unknown
  std::string whyNoError{};                // what NaN means among errors: "no partner in the twin"; may be empty
};

struct ViewFrame {
  std::string key;
  std::vector<ViewScan> scans;
  std::vector<std::string> problems;  // what of it could not be loaded, one line each
};

struct SceneChoice {
  std::filesystem::path file;
  std::uint64_t seed = 1;
  bool operator==(const SceneChoice&) const = default;
};

// What somebody wants to see.
struct ViewInput {
  std::filesystem::path path;  // a dataset's folder, a shard, a scan of any known format, or a scene (.yaml)
  std::vector<std::filesystem::path> over{};  // further datasets, shards or scans: samples are joined by their keys, a
                                              // single scan with every sample
  std::filesystem::path twin{};               // the noise-free dataset, shard or scan; empty: none
  std::string sensor{};                       // only this one's scans; empty: all
  std::filesystem::path ontology{};           // labels/*.yaml, in place of the dataset's; empty: the dataset's
  std::filesystem::path scene{};              // in place of the dataset's; empty: that which the manifest names
};

class FrameSource {
 public:
  virtual ~FrameSource() = default;
  virtual std::string title() const = 0;  // the folder's or the file's name
  // Of the frames, in their order; one for a single scan or a scene.
  virtual const std::vector<std::string>& keys() const = 0;
  virtual const Ontology* ontology() const = 0;  // null where unknown
  virtual bool isScene() const = 0;              // frames without scans: only scene() is to be seen
  // From any thread. Throws nothing for what is wrong with the data: a damaged or missing shard, a member that does not
  // decode, a sample that a further dataset lacks are problems of the frame, with the file's name and what to do.
  virtual ViewFrame load(std::size_t frame) const = 0;
  // Of the frame's sequence, in the order of its frames: worldFromSensor of each one's first scan; empty where unknown.
  virtual std::vector<Pose> trajectory(std::size_t frame) const = 0;
  // What the frame was made of; none where that is unknown or its file is not there, and then `why` says so.
  virtual std::optional<SceneChoice> scene(std::size_t frame, std::string& why) const = 0;
  // Ids of the classes that any frame holds, ascending; empty where that is unknown.
  virtual std::vector<std::uint16_t> classes() const { return {}; }
  // Frames that cannot be shown, as far as is known by now, ascending. From any thread.
  virtual std::vector<std::size_t> damaged() const { return {}; }
};

// Throws InputError for what makes it senseless to go on: no such file, a file of no known kind, a manifest that cannot
// be read, a sensor that there is not, a single scan that does not decode. Reads the manifest and the directories of
// shards, no scan of a dataset.
std::unique_ptr<FrameSource> openFrames(const ViewInput& input);

// The frame of a key, or of an index from 0, or the only key that holds `wanted`; empty: the middle one. Throws
// InputError with the nearest keys.
std::size_t findFrame(const FrameSource& source, const std::string& wanted);

}  // namespace scanmill
