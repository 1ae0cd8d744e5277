#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include "base/short_text.h"
#include "study/figure_text.h"
#include "study/tradeoff/study.h"

namespace scanmill {

namespace {

// Relative difference up to which the advice treats times as equal, since repeated measurements may differ as much.
constexpr double kSameTime = 0.10;
constexpr double kAny = std::numeric_limits<double>::infinity();

// A use of the scans, with the largest errors that it tolerates. Error rates are fractions of the beams.
struct Need {
  const char* name;
  const char* limits;         // the limits below in words; empty: none
  double p95 = kAny;          // limit of the 95th percentile of the range error (m)
  double p99 = kAny;          // limit of the 99th percentile of the range error (m)
  double missRate = kAny;     // limit of GroupErrors::missRate()
  double wrongLabels = kAny;  // limit of 1 - GroupErrors::labels()
};
const std::array<Need, 4> kNeeds{{
    {.name = "exact ranges and labels",
     .limits = "99 % of the ranges within 1 mm, 99.99 % of the labels and all but 0.01 % of the beams",
     .p99 = 1e-3,
     .missRate = 1e-4,
     .wrongLabels = 1e-4},
    {.name = "centimetres",
     .limits = "99 % of the ranges within 2 cm, 99.5 % of the labels and all but 0.2 % of the beams",
     .p99 = 0.02,
     .missRate = 2e-3,
     .wrongLabels = 5e-3},
    {.name = "a decimetre for 95 % of the beams",
     .limits = "95 % of the ranges within 10 cm, 95 % of the labels and all but 1 % of the beams",
     .p95 = 0.1,
     .missRate = 0.01,
     .wrongLabels = 0.05},
    {.name = "speed at any price", .limits = ""},
}};

using Results = std::vector<const SettingResult*>;

const GroupErrors& errorsOf(const SettingResult& result) {
  return result.measured.errors.all;
}

double scanSecondsOf(const SettingResult& result) {
  return result.measured.cost.scanSeconds;
}

// Returns the largest ratio of an error to its limit: at most 1 if all limits are kept, infinite for an unknown error.
double largestRatio(const GroupErrors& e, const Need& need) {
  constexpr double kRounding = 1e-9;  // rounding error of fractions such as 1 - 0.9999
  double largest = 0;
  for (const auto& [error, limit] :
       {std::pair(e.range.p95, need.p95), std::pair(e.range.p99, need.p99), std::pair(e.missRate(), need.missRate),
        std::pair(1 - e.labels() - kRounding, need.wrongLabels)}) {
    if (limit < kAny) largest = std::max(largest, std::isnan(error) ? kAny : error / limit);
  }
  return largest;
}

// Returns the fastest of the results, of which there must be one. Among results at most kSameTime slower, prefers
// default options, then the fewest wrong beams, then the least range error.
const SettingResult& fastestOf(Results results) {
  const double least = scanSecondsOf(*std::ranges::min(results, {}, [](const auto* r) { return scanSecondsOf(*r); }));
  std::erase_if(results, [&](const auto* r) { return scanSecondsOf(*r) > least * (1 + kSameTime); });
  return *std::ranges::min(results, {}, [](const SettingResult* r) {
    return std::tuple(!isDefault(r->setting), wrongShare(errorsOf(*r)), errorsOf(*r).range.p99);
  });
}

std::string p99Text(const GroupErrors& errors) {
  const double p99 = rangeP99(errors);
  return p99 == 0 ? "exact" : std::isnan(p99) ? "unknown" : "within " + metresText(p99);
}

// Returns the speed and the errors of a setting in words. `tracing`: the result of ray tracing with defaults, with
// which the speed is compared; null if it was not measured.
std::string figuresOf(const Study& study, const SettingResult& result, const SettingResult* tracing) {
  const GroupErrors& e = errorsOf(result);
  std::string text = fmt::format("{} beams a second", shortNumber(beamsPerSecond(study, result)));
  if (tracing != nullptr && tracing != &result && scanSecondsOf(result) > 0) {
    text += fmt::format(", {} x as fast as ray tracing with defaults",
                        factorText(scanSecondsOf(*tracing) / scanSecondsOf(result)));
  }
  text +=
      fmt::format("; 99 % of the ranges {}; {} of the labels agree; {} of the beams are false negatives or positives",
                  p99Text(e), shareText(e.labels()), shareText(e.missRate()));
  if (std::ranges::find(study.refused, result.setting.method) != study.refused.end()) {
    text += fmt::format(
        ". The pipeline cannot use {}, since it has light_paths or objects that move: leave these out (`moving: false` "
        "beside the scene) to take it",
        result.setting.method);
  }
  return text + ".";
}

}  // namespace

std::vector<Advice> advise(const Study& study) {
  Results measured;
  for (const std::size_t i : measuredSettings(study)) measured.push_back(&study.settings[i]);
  if (measured.empty()) return {};
  const std::optional<std::size_t> tracingIndex = tracingDefault(study);
  const SettingResult* const tracing = tracingIndex ? &study.settings[*tracingIndex] : nullptr;
  std::vector<Advice> advice;
  for (const Need& need : kNeeds) {
    const std::string needText = std::string("For ") + need.name;
    const auto ratioToLimits = [&](const SettingResult* r) { return largestRatio(errorsOf(*r), need); };
    Results goodEnough;
    std::ranges::copy_if(measured, std::back_inserter(goodEnough),
                         [&](const auto* r) { return ratioToLimits(r) <= 1; });
    if (goodEnough.empty()) {
      const SettingResult& nearest = **std::ranges::min_element(measured, {}, ratioToLimits);
      advice.push_back({needText, "",
                        fmt::format("No setting that was measured keeps {}. The nearest is {}: {}", need.limits,
                                    nearest.setting.name, figuresOf(study, nearest, tracing))});
      continue;
    }
    const SettingResult& best = fastestOf(goodEnough);
    const auto earlier = std::ranges::find(advice, best.setting.name, &Advice::setting);
    if (earlier != advice.end()) {
      earlier->need += std::string("; for ") + need.name;
    } else {
      advice.push_back({needText, best.setting.name, figuresOf(study, best, tracing)});
    }
  }
  return advice;
}

}  // namespace scanmill
