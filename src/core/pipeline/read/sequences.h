#pragma once

// Reads the keys `scenes` and `trajectories` of a pipeline: which scene is driven through along which way.

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

// One scene with one procedural seed, driven along one trajectory: the unit that splits never part.
struct Sequence {
  std::string scene;  // name of the scene file without its suffix, made fit for a key
  std::filesystem::path sceneFile;
  std::uint64_t sceneSeed = 1;
  std::shared_ptr<const Trajectory> trajectory;  // null where the shots come from a recording
  std::string trajectoryName;
  std::uint32_t frames = 0;
  std::string split;
  bool moving = true;               // false: objects stand where they are when the drive begins
  std::vector<Value> without = {};  // what is taken out of the scene, see scene/without.h

  bool sameScene(const Sequence& other) const;
  // At most so many frames, each in the middle of an equal part of the sequence.
  std::vector<std::uint32_t> spreadFrames(std::uint32_t most) const;
  std::string key() const;                     // "street-s1-lane"
  std::string key(std::uint32_t frame) const;  // "street-s1-lane-000012"
};

// How long revolutions of the sensors last (s).
struct Periods {
  double first = 0.1;  // of the first sensor
  double longest = 0.1;
};

// Lower-case letters, digits, '-' and '_': sample keys must hold no dot and no slash.
std::string keyPart(std::string text);

// The value of a key that must be there, and a list that is not empty. Throws InputError.
const Value& requireList(Fields& fields, std::string_view key);

// One for each scene, seed and trajectory. Throws InputError.
std::vector<Sequence> readSequences(Fields& fields, const Periods& periods);
// Those of a recording. Throws InputError where the pipeline takes other things out of its scenes than were taken out
// when it was made.
std::vector<Sequence> recordedSequences(const Recording& recording, Fields& fields);

}  // namespace scanmill
