#pragma once

// How long a dataset takes and how large it becomes, in words.

#include <optional>
#include <string>

#include "commands/arguments.h"
#include "pipeline/run/forecast.h"

namespace scanmill {

// Measures what the scenes and frames of the command's pipeline cost on this machine; `overrides`: all arguments of
// --set. Null if the small town cannot stand for the pipeline's scenes; `why` then says why not.
std::optional<SampleCosts> sampleCosts(const Arguments& parsed, const Plan& plan, std::vector<std::string> overrides,
                                       std::string* why = nullptr);

// "17 s (11 to 26 s) on 2 threads".
std::string timeText(const Forecast& forecast);
// "410 MiB (342 to 492 MiB)".
std::string sizeText(const Forecast& forecast);

}  // namespace scanmill
