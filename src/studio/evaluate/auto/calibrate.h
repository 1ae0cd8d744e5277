#pragma once

// `method: auto` chooses the cheapest setting that is as exact, or as fast, as the pipeline asks for.
//
//   method:
//     auto:
//       max_error: {p99: 2cm, miss_rate: 0.1%, labels: 99.5%}   # see evaluate/limits.h
//       min_rate: 5e6            # beams/s of tracing, all set-ups included; effects and encoding are not
//       settings: [...]          # to choose from, see evaluate/settings.h (default: a few of each method)
//       shots: 3                 # number of frames on which settings are measured, spread over all sequences
//
// Every setting is measured on these frames against the truth (evaluate/exact/exact.h). Its errors are the worst of the
// scenes that the frames show; its cost is the time that the whole pipeline would take with it. A setting that is not
// exact enough on a scene is not measured on the next. Costs that differ by less than a tenth, which is timing noise,
// count as equal, and then the most exact setting is taken. If only a rate is asked for, the most exact setting that is
// fast enough is taken. Since measured times decide, another run may choose another setting if two are about as good.

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

// Reads the options of a pipeline whose method is `auto`. Throws InputError with the place, also if there is a limit of
// the intensity error and no effect sets the intensity.
AutoChoice readAutoChoice(const Pipeline& pipeline);

// Makes the checks of readAutoChoice() if the method of the pipeline is `auto`.
void checkAutoChoice(const Pipeline& pipeline);

struct CalibratedSetting {
  MethodSetting setting;
  std::string failure;  // why it cannot be chosen; empty: it can
  Candidate candidate;
};

struct Calibration {
  std::vector<CalibratedSetting> settings;  // in the order in which the pipeline names them
  std::size_t chosen = 0;                   // the index of the setting that is taken
  std::string why;                          // a sentence with figures, for people

  MethodRecord record() const;
};

// Measures the settings of a plan whose method is `auto`, and chooses one. Throws Error if no setting holds the limits,
// naming the nearest one and the limits that it breaks; also if `stop` becomes true.
Calibration calibrate(const Plan& plan, bool quiet, const std::atomic<bool>* stop = nullptr);

// Returns the index of the setting that calibrate() chooses from the measured ones. `where` is the place of the
// pipeline's method, for messages.
std::size_t chooseSetting(const std::vector<CalibratedSetting>& settings, const ErrorLimits& limits,
                          const Location& where);

}  // namespace scanmill
