#pragma once

// Forecasts the time and the size of a dataset, in words.

#include <string>

#include "commands/arguments.h"
#include "pipeline/run/forecast.h"

namespace scanmill {

// Measures the costs of the scenes and frames of the command's pipeline on this machine. Throws Error if the pipeline
// cannot scan the small town that forecasts use.
SampleCosts sampleCosts(const Arguments& parsed, const Plan& plan);

// Returns the forecast of the time and its range as a text such as "17 s (11 to 26 s) on 2 threads".
std::string timeText(const Forecast& forecast);
// Returns the forecast of the size and its range as a text such as "410 MiB (342 to 492 MiB)".
std::string sizeText(const Forecast& forecast);

}  // namespace scanmill
