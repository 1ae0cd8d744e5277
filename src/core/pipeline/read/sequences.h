#pragma once

// Reads the keys `scenes` and `trajectories` of a pipeline: which trajectories are driven in which scene.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "config/fields.h"
#include "config/value.h"
#include "dataset/recording.h"
#include "sensors/trajectory.h"

namespace scanmill {

// One scene with one procedural seed, driven along one trajectory. All its frames belong to the same split.
struct Sequence {
  std::string scene;  // keyPart() of the scene file's name without its suffix
  std::filesystem::path sceneFile;
  std::uint64_t sceneSeed = 1;
  std::shared_ptr<const Trajectory> trajectory;  // null if the shots come from a recording
  std::string trajectoryName;
  std::uint32_t frames = 0;
  std::string split;
  bool moving = true;               // false: objects stand where they are when the drive begins
  std::vector<Value> without = {};  // items taken out of the scene, see scene/without.h

  bool sameScene(const Sequence& other) const;
  // Returns at most `most` frames, each in the middle of one of equally long parts of the sequence.
  std::vector<std::uint32_t> spreadFrames(std::uint32_t most) const;
  std::string key() const;                     // "street-s1-lane"
  std::string key(std::uint32_t frame) const;  // "street-s1-lane-000012"
};

// Durations of the sensors' revolutions (s).
struct Periods {
  double first = 0.1;  // period of the first sensor
  double longest = 0.1;
};

// Returns a text of lower-case letters, digits, '-' and '_': sample keys must hold no dot and no slash.
std::string keyPart(std::string text);

// Returns the value of a key. Throws InputError if the key is missing or its value is not a list, or an empty one.
const Value& requireList(Fields& fields, std::string_view key);

// Returns a sequence for each scene, seed and trajectory. Throws InputError.
std::vector<Sequence> readSequences(Fields& fields, const Periods& periods);
// Returns the sequences of a recording, which decides what was taken out of its scenes: throws InputError if the
// pipeline names another list `without`.
std::vector<Sequence> recordedSequences(const Recording& recording, Fields& fields);

}  // namespace scanmill
