#pragma once

// Reads the options of a trade-off study, which are the key `tradeoff:` of a pipeline. All keys in it are optional.
//
//   tradeoff:
//     settings:                     # see evaluate/settings.h
//       - ray_tracing
//       - {depth_camera: {resolution: [512, 1024, 2048], sampling: [plane, nearest]}}
//     encodings: [pcd, {draco: {max_error_mm: [1, 10]}}]
//     sequence: street-s1-lane      # key of the sequence to scan (default: the first)
//     shots: 8                      # maximum number of frames to scan
//     repeats: 3                    # least number of timed scans per frame
//     budget_s: 300                 # approximate duration of the study

#include <cstdint>
#include <span>
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
  std::size_t sequence = 0;  // index in Pipeline::sequences
  std::uint32_t shots = 8;
  int repeats = 3;
  double budgetSeconds = 300;
};

// Reads the key `tradeoff` of a pipeline and checks the options of all settings. Throws InputError with file
// and line.
StudyChoice readStudyChoice(const Pipeline& pipeline);

// Returns the settings that are measured if the pipeline lists none: all methods with their defaults, and variations
// with one or several options changed.
std::vector<MethodSetting> defaultSettings();

// Encodes and decodes each scan `repeats` times on one thread and uses the shortest time of each scan. Rates and sizes
// are per return; misses in organised scans need bytes, but do not count as points. The error is the distance between
// decoded and original positions.
EncodingResult measureEncoding(const StudyEncoding& encoding, std::span<const Scan> scans, int repeats);

}  // namespace scanmill
