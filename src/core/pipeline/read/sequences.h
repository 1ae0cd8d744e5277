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
  std::string split;
  bool moving = true;               // false: objects stay at their positions at time 0 s
  std::vector<Value> without = {};  // classes, names or ids of objects to remove from the scene, see takeOut()

  // True if sensors of different rates turn without a break from the start of the sequence: the time from frame to
  // frame is not longer than a revolution of the slowest sensor, and not shorter than one of the fastest.
  bool turnsWithoutBreak(const Periods& periods) const;
  // Returns when the revolutions of a sensor that belong to the frame begin (s after the frame's start, may be
  // negative). `period`: duration of the sensor's revolution (s). If the sensors turn without a break, these are the
  // revolutions that end after the frame's start and not after the next frame's: several of a fast sensor, at times
  // none of a slow one. Otherwise all sensors begin to turn with each frame, and the frame has the revolutions that end
  // within one of the slowest sensor; only the first one if the next frame begins before that.
  std::vector<double> revolutions(std::uint32_t frame, double period, const Periods& periods) const;
  double totalRevolutions(double period, const Periods& periods) const;        // of all frames
  std::uint32_t mostRevolutions(double period, const Periods& periods) const;  // of one frame

  bool sameScene(const Sequence& other) const;
  // Returns at most `most` frame numbers, spread evenly over the sequence.
  std::vector<std::uint32_t> spreadFrames(std::uint32_t most) const;
  std::string sceneName() const;  // the scene with its seed, such as "street-s1"
  std::string key() const;        // key of the sequence, such as "street-s1-lane": scene, seed and trajectory
  std::string key(std::uint32_t frame) const;  // key of a sample, such as "street-s1-lane-000012"
};

// Returns the text as a part of sample keys, which are ASCII without dots and slashes: letters in lower case, the code
// of each other character of Unicode ("u5317"), and '_' in place of all further characters but digits, '-' and '_'.
std::string keyPart(std::string_view text);

// Returns one sequence for each combination of scene, seed and trajectory. `period`: duration of the slowest sensor's
// revolution (s). Calls `checkFrames` with how many frames there are at least, at first before any scene is read.
// Throws InputError.
std::vector<Sequence> readSequences(Fields& fields, double period,
                                    const std::function<void(std::uint64_t)>& checkFrames);
// Returns the sequences of a recording. Throws InputError if the pipeline's key `without` differs from the recording's,
// since objects cannot be removed from recorded hits.
std::vector<Sequence> recordedSequences(const Recording& recording, Fields& fields);

}  // namespace scanmill
