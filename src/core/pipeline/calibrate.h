#pragma once

// `method: auto`: the cheapest setting that is as exact, or as fast, as the pipeline asks for.
//
//   method:
//     auto:
//       max_error: {p99: 2cm, miss_rate: 0.1%, labels: 99.5%}   # see evaluate/limits.h
//       min_rate: 5e6            # beams/s of tracing, all set-ups included; effects and encoding are not
//       settings: [...]          # to choose from, see pipeline/settings.h (default: a few of each method)
//       shots: 3                 # so many frames are calibrated on, spread over all sequences
//
// Of settings whose costs differ by less than a tenth, the noise of time, the most exact is taken; where nothing but a
// rate is asked for, the most exact that is fast enough. Times decide: the choice may differ from run to run where two
// settings are about as good, but not what it says of itself. Every setting is measured on these frames against the
// truth (methods/exact/exact.h). Its errors are the worst of the scenes that the frames are of; its cost is what the
// whole pipeline would take by it. One that is not exact enough on a scene is not measured on the next.

#include <atomic>
#include <string>
#include <vector>

#include "dataset/manifest.h"
#include "evaluate/limits.h"
#include "pipeline/plan.h"
#include "pipeline/settings.h"

namespace scanmill {

struct AutoChoice {
  ErrorLimits limits;
  std::vector<MethodSetting> settings;
  std::uint32_t shots = 3;
};

// Of the options of `auto`. Throws InputError with the place.
AutoChoice readAutoChoice(const Value& options);

struct CalibratedSetting {
  MethodSetting setting;
  std::string failure;  // why it could not be measured; then all else is empty
  Candidate candidate;
};

struct Calibration {
  std::vector<CalibratedSetting> settings;  // in the order in which they were named
  std::size_t chosen = 0;
  std::string why;  // "p99 0.0 mm, labels 100.00 %, 31.2 M beams/s: the fastest of 9 that hold; ..."

  MethodRecord record() const;
};

// For a plan whose method is `auto`. Throws Error, with the nearest setting and what it lacks, where none holds.
Calibration calibrate(const Plan& plan, bool quiet, const std::atomic<bool>* stop = nullptr);

// The same choice from what was measured. `where` is of the pipeline's method.
std::size_t chooseSetting(const std::vector<CalibratedSetting>& settings, const ErrorLimits& limits,
                          const Location& where);

}  // namespace scanmill
