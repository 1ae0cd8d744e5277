#include "commands/forecast_text.h"

#include <fmt/format.h>

#include "base/short_text.h"

namespace scanmill {

namespace {

// Returns a range such as "11 to 26 s". The unit is written once if both ends have the same unit.
std::string rangeText(const std::string& least, const std::string& most) {
  const std::size_t unit = least.find(' ');
  const bool same =
      unit != std::string::npos && most.find(' ') == most.rfind(' ') && most.ends_with(least.substr(unit));
  return fmt::format("{} to {}", same ? least.substr(0, unit) : least, most);
}

}  // namespace

std::optional<SampleCosts> sampleCosts(const Arguments& parsed, const Plan& plan, std::vector<std::string> overrides,
                                       std::string* why) {
  const Reread reread = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all = overrides;
    all.insert(all.end(), more.begin(), more.end());
    return readPipeline(parsed.pipeline(), all);
  };
  try {
    return measureSampleCosts(plan, reread);
  } catch (const Error& failure) {
    if (why != nullptr) *why = failure.what();
    return std::nullopt;
  }
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
