#pragma once

// Reads the keys `scenes` and `trajectories` of a pipeline: which trajectories are driven in which scenes. Installed
// because pipeline/read/pipeline.h includes it.
//
//   const std::string firstSample = plan.pipeline.sequences.front().key(0);  // "street-s1-lane-000000"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "config/fields.h"
#include "config/value.h"
#include "dataset/recording.h"

namespace scanmill {

class Trajectory;

// One scene with one procedural seed, driven along one trajectory. All its frames belong to the same split.
struct Sequence {
  std::string scene;  // the scene file's name without its suffix, in the form of keyPart()
  std::filesystem::path sceneFile;
  std::uint64_t sceneSeed = 1;
  std::shared_ptr<const Trajectory> trajectory;  // null if the shots come from a recording
  std::string trajectoryName;
  std::uint32_t frames = 0;
  std::string split;
  bool moving = true;               // false: objects stay at their positions at time 0 s
  std::vector<Value> without = {};  // classes, names or ids of objects to remove from the scene, see scene/without.h

  bool sameScene(const Sequence& other) const;
  // Returns at most `most` frame numbers, spread evenly over the sequence.
  std::vector<std::uint32_t> spreadFrames(std::uint32_t most) const;
  std::string key() const;  // key of the sequence, such as "street-s1-lane": scene, seed and trajectory
  std::string key(std::uint32_t frame) const;  // key of a sample, such as "street-s1-lane-000012"
};

// Durations of the sensors' revolutions (s).
struct Periods {
  double first = 0.1;  // duration of the first sensor's revolution (s)
  double longest = 0.1;
};

// Returns the text in lower case, with '_' in place of all characters but letters, digits, '-' and '_': sample keys
// must not contain dots or slashes.
std::string keyPart(std::string text);

// Returns the value of a key. Throws InputError if the key is missing, or if its value is no list or an empty one.
const Value& requireList(Fields& fields, std::string_view key);

// Returns one sequence for each combination of scene, seed and trajectory. `periods`: durations of the sensors'
// revolutions. Calls `checkFrames` with how many frames there are at least, at first before any scene is read. Throws
// InputError.
std::vector<Sequence> readSequences(Fields& fields, const Periods& periods,
                                    const std::function<void(std::uint64_t)>& checkFrames);
// Returns the sequences of a recording. Throws InputError if the pipeline's key `without` differs from the recording's,
// since objects cannot be removed from recorded hits.
std::vector<Sequence> recordedSequences(const Recording& recording, Fields& fields);

}  // namespace scanmill
