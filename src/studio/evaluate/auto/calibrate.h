#pragma once

// Chooses a method and its options for pipelines with `method: auto`: the cheapest setting that is as exact, or as
// fast, as the pipeline requires.
//
//   method:
//     auto:
//       max_error: {p99: 2cm, miss_rate: 0.1%, labels: 99.5%}   # see evaluate/limits.h
//       min_rate: 5e6            # beams/s for tracing and all set-ups, without effects and encoding
//       settings: [...]          # candidates, see evaluate/settings.h (default: a few of each method)
//       shots: 3                 # number of frames on which settings are measured, in at most three scenes
//
// Every setting is measured on these frames, and its hits are compared with exact hits (evaluate/exact/exact.h). The
// range and intensity errors of a setting are the largest over all measured scenes; its miss rate and its labels are
// those of all measured beams. Its cost is the time that the complete pipeline would take. A setting that is not exact
// enough on one scene is not measured on further scenes. Costs that differ by less than a tenth count as equal, because
// of timing noise; among equal costs the most exact setting is chosen. If the pipeline limits only the rate, the most
// exact setting that is fast enough is chosen. Since times are measured, the choice may differ from run to run if two
// settings are about equally good.

#include <atomic>
#include <string>
#include <vector>

#include "dataset/manifest.h"
#include "evaluate/limits.h"
#include "evaluate/settings.h"
#include "pipeline/plan/plan.h"

namespace scanmill {

struct AutoChoice {
  ErrorLimits limits;
  std::vector<MethodSetting> settings;
  std::uint32_t shots = 3;
};

// Reads the options of `method: auto`. Throws InputError with file and line; also if the intensity error is limited but
// no effect sets the intensity.
AutoChoice readAutoChoice(const Pipeline& pipeline);

// Throws InputError if the method of the pipeline is `auto` and its options are wrong, see readAutoChoice().
void checkAutoChoice(const Pipeline& pipeline);

struct CalibratedSetting {
  MethodSetting setting;
  std::string failure;  // why the setting cannot be chosen; empty: it can be chosen
  Candidate candidate;
};

struct Calibration {
  std::vector<CalibratedSetting> settings;  // results of all settings, in the pipeline's order
  std::size_t chosen = 0;                   // index of the chosen setting
  std::string why;                          // the reason for the choice, as a sentence with figures

  MethodRecord record() const;
};

// Measures the settings of a plan with `method: auto`, and chooses one of them. Throws Error if no setting keeps the
// limits; the message states the setting that comes nearest to the limits, and which of them it exceeds. Also throws
// Error if `*stop` becomes true; `stop` may be null.
Calibration calibrate(const Plan& plan, bool quiet, const std::atomic<bool>* stop = nullptr);

// Returns the index of the setting to choose from measured settings, by the rules at the top of this file. `where`:
// position of the pipeline's key `method`, for messages.
std::size_t chooseSetting(const std::vector<CalibratedSetting>& settings, const ErrorLimits& limits,
                          const Location& where);

}  // namespace scanmill
