#pragma once

// What a trade-off study compares: the key `tradeoff:` of a pipeline. All of it may be left out.
//
//   tradeoff:
//     settings:                     # see pipeline/settings.h
//       - ray_tracing
//       - {depth_camera: {resolution: [512, 1024, 2048], sampling: [plane, nearest]}}
//     encodings: [pcd, {draco: {max_error_mm: [1, 10]}}]
//     rings: [16, 64, 256]          # time the first setting of each method with so many rings too (default: none)
//     sequence: street-s1-lane      # which of the pipeline's sequences (default: the first)
//     shots: 8                      # at most so many of its frames
//     repeats: 3                    # timed scans of each
//     budget_s: 300                 # how long it may take, about

#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/settings.h"
#include "study/tradeoff/study.h"

namespace scanmill {

struct StudyEncoding {
  std::string name;
  std::string options;
  FormatChoice choice;
};

struct StudyChoice {
  std::vector<MethodSetting> settings;
  std::vector<StudyEncoding> encodings;
  std::vector<std::uint32_t> rings;
  std::size_t sequence = 0;
  std::uint32_t shots = 8;
  int repeats = 3;
  double budgetSeconds = 300;
};

// Every setting's options are checked. Throws InputError with the place.
StudyChoice readStudyChoice(const Pipeline& pipeline);

// What is compared where a pipeline does not say: all methods, each with its shortcuts one by one.
std::vector<MethodSetting> defaultSettings();

}  // namespace scanmill
