#pragma once

// The choices of a trade-off study: the key `tradeoff:` of a pipeline. All of its parts are optional.
//
//   tradeoff:
//     settings:                     # see evaluate/settings.h
//       - ray_tracing
//       - {depth_camera: {resolution: [512, 1024, 2048], sampling: [plane, nearest]}}
//     encodings: [pcd, {draco: {max_error_mm: [1, 10]}}]
//     rings: [16, 64, 256]          # also times each method's first setting at these numbers of rings (default: none)
//     sequence: street-s1-lane      # the sequence of the pipeline that is scanned (default: the first)
//     shots: 8                      # number of frames of the sequence to scan, at most
//     repeats: 3                    # timed scans per frame
//     budget_s: 300                 # approximate time of the study

#include <cstdint>
#include <string>
#include <vector>

#include "evaluate/settings.h"
#include "study/tradeoff/study.h"

namespace scanmill {

struct StudyEncoding {
  std::string name;
  std::string options;
  ChosenFormat choice;
};

struct StudyChoice {
  std::vector<MethodSetting> settings;
  std::vector<StudyEncoding> encodings;
  std::vector<std::uint32_t> rings;
  std::size_t sequence = 0;  // index into Pipeline::sequences
  std::uint32_t shots = 8;
  int repeats = 3;
  double budgetSeconds = 300;
};

// Reads the key. Checks the options of every setting, and of the pipeline's own method if that is `method: auto`.
// Throws InputError that names the place in the pipeline.
StudyChoice readStudyChoice(const Pipeline& pipeline);

// Returns the settings of a pipeline that names none: all methods, each with one shortcut at a time.
std::vector<MethodSetting> defaultSettings();

}  // namespace scanmill
