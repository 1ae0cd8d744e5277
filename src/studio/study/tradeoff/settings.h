#pragma once

// What a trade-off study compares: the key `tradeoff:` of a pipeline, every part of which may be left out.
//
//   tradeoff:
//     settings:                     # see evaluate/settings.h
//       - ray_tracing
//       - {depth_camera: {resolution: [512, 1024, 2048], sampling: [plane, nearest]}}
//     encodings: [pcd, {draco: {max_error_mm: [1, 10]}}]
//     rings: [16, 64, 256]          # time the first setting of each method with so many rings, too (default: none)
//     sequence: street-s1-lane      # which of the pipeline's sequences is scanned (default: the first)
//     shots: 8                      # at most so many of the sequence's frames are scanned
//     repeats: 3                    # so many scans of each frame are timed
//     budget_s: 300                 # how long the study may take, about

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

// Reads the key and checks the options of every setting, and those of the pipeline's own `method: auto`, where it says
// so. Throws InputError with the place.
StudyChoice readStudyChoice(const Pipeline& pipeline);

// The settings that are compared where a pipeline names none: all methods, each with its shortcuts one by one.
std::vector<MethodSetting> defaultSettings();

}  // namespace scanmill
