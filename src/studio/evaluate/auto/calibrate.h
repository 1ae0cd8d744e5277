#pragma once

// `method: auto` takes the cheapest setting that is as exact, or as fast, as the pipeline asks for.
//
//   method:
//     auto:
//       max_error: {p99: 2cm, miss_rate: 0.1%, labels: 99.5%}   # see evaluate/limits.h
//       min_rate: 5e6            # beams/s of tracing, all set-ups included; effects and encoding are not
//       settings: [...]          # to choose from, see evaluate/settings.h (default: a few of each method)
//       shots: 3                 # settings are measured on so many frames, spread over all sequences
//
// Every setting is measured on these frames against the truth (evaluate/exact/exact.h). Its errors are the worst of the
// scenes that the frames show; its cost is the time that the whole pipeline would take with it. A setting that is not
// exact enough on a scene is not measured on the next. Of settings whose costs differ by less than a tenth, the noise
// of time, the most exact is taken; where nothing but a rate is asked for, the most exact that is fast enough. Since
// times decide, another run may choose another setting where two are about as good.

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

// Reads the options of a pipeline whose method is `auto`. Throws InputError with the place, also where the pipeline can
// never keep a limit, since none of its effects sets the intensity.
AutoChoice readAutoChoice(const Pipeline& pipeline);

// The same check for any pipeline. One whose method is not `auto` has nothing to check.
void checkAutoChoice(const Pipeline& pipeline);

struct CalibratedSetting {
  MethodSetting setting;
  std::string failure;  // why it could not be measured; then the candidate is empty
  Candidate candidate;
};

struct Calibration {
  std::vector<CalibratedSetting> settings;  // in the order in which the pipeline names them
  std::size_t chosen = 0;                   // the index of the setting that is taken
  std::string why;                          // a sentence with figures, for people

  MethodRecord record() const;
};

// Measures the settings of a plan whose method is `auto`, and chooses. Throws Error where no setting holds the limits,
// with the nearest one and what it lacks; also where `stop` becomes true.
Calibration calibrate(const Plan& plan, bool quiet, const std::atomic<bool>* stop = nullptr);

// The index of the setting that calibrate() takes by what was measured. `where` is the place of the pipeline's method,
// for messages.
std::size_t chooseSetting(const std::vector<CalibratedSetting>& settings, const ErrorLimits& limits,
                          const Location& where);

}  // namespace scanmill
