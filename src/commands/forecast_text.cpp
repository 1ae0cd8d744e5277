#include "commands/forecast_text.h"

#include <fmt/format.h>

#include "base/short_text.h"

namespace scanmill {

namespace {

// Joins two figures with units to a range: "11 s" and "26 s" become "11 to 26 s". The unit is written once if both
// figures have the same unit and `most` is a single figure, unlike "1 h 2 min".
std::string rangeText(const std::string& least, const std::string& most) {
  const std::size_t space = least.find(' ');  // before the unit
  const bool sameUnit =
      space != std::string::npos && most.find(' ') == most.rfind(' ') && most.ends_with(least.substr(space));
  return fmt::format("{} to {}", sameUnit ? least.substr(0, space) : least, most);
}

}  // namespace

SampleCosts sampleCosts(const Arguments& parsed, const Plan& plan) {
  return measureSampleCosts(plan, [&](const std::vector<std::string>& forecastOverrides) {
    return readPipeline(parsed.pipeline(), pipelineOverrides(parsed, forecastOverrides));
  });
}

std::string timeText(const Forecast& forecast) {
  const Estimate& s = forecast.seconds;
  return fmt::format("{} ({}) on {}", shortTime(s.expected), rangeText(shortTime(s.least), shortTime(s.most)),
                     pluralOf(static_cast<std::uint64_t>(forecast.threads), "thread"));
}

std::string sizeText(const Forecast& forecast) {
  const Estimate& b = forecast.bytes;
  return fmt::format("{} ({})", shortBytes(b.expected), rangeText(shortBytes(b.least), shortBytes(b.most)));
}

}  // namespace scanmill
