#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "base/short_text.h"
#include "study/figure_text.h"
#include "study/tradeoff/study.h"
#include "study/tradeoff/study_figures.h"

namespace scanmill {

namespace {

// Relative difference below which times count as equal; repeated measurements differ by this much.
constexpr double kSameTime = 0.10;
constexpr double kAny = std::numeric_limits<double>::infinity();

// A use of the scans and the errors that it tolerates; fractions are of beams.
struct Need {
  const char* name;
  const char* limits;         // the limits below in words; empty: none
  double p95 = kAny;          // of the range error (m)
  double p99 = kAny;          // of the range error (m)
  double missRate = kAny;     // of GroupErrors::missRate()
  double wrongLabels = kAny;  // of 1 - GroupErrors::labels()
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

// Returns the largest factor by which errors exceed a limit; at most 1 if they keep all, infinite if one is unknown.
double excess(const GroupErrors& e, const Need& need) {
  constexpr double kRounding = 1e-9;  // of fractions such as 1 - 0.9999
  double most = 0;
  for (const auto& [value, limit] :
       {std::pair(e.range.p95, need.p95), std::pair(e.range.p99, need.p99), std::pair(e.missRate(), need.missRate),
        std::pair(1 - e.labels() - kRounding, need.wrongLabels)}) {
    if (limit < kAny) most = std::max(most, std::isnan(value) ? kAny : value / limit);
  }
  return most;
}

bool moreExact(const SettingResult& a, const SettingResult& b) {
  const auto order = [](const GroupErrors& e) { return std::pair(wrongShare(e), e.range.p99); };
  return order(errorsOf(a)) < order(errorsOf(b));
}

// Returns the fastest setting. Among those about as fast, prefers one with default options, then the most exact.
const SettingResult& fastestOf(const Results& results) {
  const double least =
      scanSecondsOf(**std::ranges::min_element(results, {}, [](const auto* r) { return scanSecondsOf(*r); }));
  const SettingResult* best = nullptr;
  for (const SettingResult* result : results) {
    if (scanSecondsOf(*result) > least * (1 + kSameTime)) continue;
    const bool plain = isDefault(result->setting);
    if (best == nullptr || (plain != isDefault(best->setting) ? plain : moreExact(*result, *best))) {
      best = result;
    }
  }
  return *best;
}

std::string p99Text(const GroupErrors& errors) {
  const double p99 = rangeP99(errors);
  return p99 == 0 ? "exact" : std::isnan(p99) ? "unknown" : "within " + metresText(p99);
}

// Returns the figures of a setting in words, beside those of ray tracing with defaults (null: not measured).
std::string figuresOf(const Study& study, const SettingResult& result, const SettingResult* rays) {
  const GroupErrors& e = errorsOf(result);
  std::string text = fmt::format("{} beams a second", shortNumber(beamsPerSecond(study, result)));
  if (rays != nullptr && rays != &result && scanSecondsOf(result) > 0) {
    text += fmt::format(", {} x as fast as ray tracing with defaults",
                        factorText(scanSecondsOf(*rays) / scanSecondsOf(result)));
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
  const std::optional<std::size_t> base = tracingDefault(study);
  const SettingResult* const rays = base ? &study.settings[*base] : nullptr;
  std::vector<Advice> advice;
  for (const Need& need : kNeeds) {
    const auto exceeds = [&](const SettingResult* r) { return excess(errorsOf(*r), need); };
    Results good;
    std::ranges::copy_if(measured, std::back_inserter(good), [&](const auto* r) { return exceeds(r) <= 1; });
    if (!good.empty()) {
      const SettingResult& best = fastestOf(good);
      const auto same = std::ranges::find(advice, best.setting.name, &Advice::setting);
      if (same != advice.end()) {
        same->need += std::string("; for ") + need.name;
      } else {
        advice.push_back({std::string("For ") + need.name, best.setting.name, figuresOf(study, best, rays)});
      }
      continue;
    }
    const SettingResult& nearest = **std::ranges::min_element(measured, {}, exceeds);
    advice.push_back({std::string("For ") + need.name, "",
                      fmt::format("No setting that was measured keeps {}. The nearest is {}: {}", need.limits,
                                  nearest.setting.name, figuresOf(study, nearest, rays))});
  }
  return advice;
}

}  // namespace scanmill
