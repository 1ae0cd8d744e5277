#include "evaluate/limits.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "base/error.h"

namespace scanmill {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Limit {
  std::string_view key;  // name of the limit in messages
  bool agreement;        // true: lower limit of a fraction; false: upper limit of a length (m) or of a fraction
  bool length;
  std::optional<double> ErrorLimits::*allowed;
  double (*value)(const Candidate&);
};

constexpr std::array<Limit, 4> kLimits{{
    {"p95", false, true, &ErrorLimits::p95, [](const Candidate& c) { return c.errors.range.p95; }},
    {"p99", false, true, &ErrorLimits::p99, [](const Candidate& c) { return c.errors.range.p99; }},
    {"miss_rate", false, false, &ErrorLimits::missRate, [](const Candidate& c) { return c.errors.missRate(); }},
    {"labels", true, false, &ErrorLimits::labels, [](const Candidate& c) { return c.errors.labels(); }},
}};

bool holds(const Limit& limit, double value, double allowed) {
  return limit.agreement ? value >= allowed : value <= allowed;
}

// Returns the factor by which a limit is exceeded; 1 if it is kept, infinity if the value is NaN. For agreements, the
// fractions that disagree are compared: 98 % instead of 99 % is a factor of 2. Limits and disagreements below 1e-6 are
// replaced by 1e-6 as divisors.
double excess(const Limit& limit, double value, double allowed) {
  constexpr double kLeast = 1e-6;
  if (holds(limit, value, allowed)) return 1;
  double factor = 1 + (value - allowed) / std::max(allowed, kLeast);
  if (limit.agreement) factor = 1 + (allowed - value) / std::max(1 - allowed, kLeast);
  return std::isnan(factor) ? kInfinity : factor;
}

double largestExcess(const Candidate& candidate, const ErrorLimits& limits) {
  double most = 1;
  for (const Limit& limit : kLimits) {
    if (const auto& allowed = limits.*limit.allowed) {
      most = std::max(most, excess(limit, limit.value(candidate), *allowed));
    }
  }
  return most;
}

// Describes an exceeded limit. The value is written with three digits, or with more if these are needed to show that
// the limit is exceeded.
std::string brokenText(const Limit& limit, double value, double allowed) {
  // Lengths are in millimetres if the limit is below one metre.
  const double unit = !limit.length ? 0.01 : allowed < 1 ? 1e-3 : 1;
  const char* const name = !limit.length ? " %" : allowed < 1 ? " mm" : " m";
  const std::string bound = limit.agreement ? fmt::format("but at least {:.9g}{} are required", allowed / unit, name)
                                            : fmt::format("but at most {:.9g}{} are allowed", allowed / unit, name);
  if (std::isnan(value)) return fmt::format("{} is unknown, {}", limit.key, bound);
  std::string figure;
  for (int digits = 3; digits <= 17; ++digits) {
    figure = fmt::format("{:.{}g}", value / unit, digits);
    if (!holds(limit, std::strtod(figure.c_str(), nullptr) * unit, allowed)) break;
  }
  return fmt::format("{} {}{}, {}", limit.key, figure, name, bound);
}

}  // namespace

std::vector<std::string> broken(const Candidate& candidate, const ErrorLimits& limits) {
  std::vector<std::string> texts;
  for (const Limit& limit : kLimits) {
    const auto& allowed = limits.*limit.allowed;
    if (!allowed) continue;
    const double value = limit.value(candidate);
    if (!holds(limit, value, *allowed)) texts.push_back(brokenText(limit, value, *allowed));
  }
  return texts;
}

bool moreExact(const GroupErrors& a, const GroupErrors& b) {
  const auto wrong = [](const GroupErrors& e) {
    const auto beams = static_cast<double>(std::max<std::uint64_t>(e.beams, 1));
    return static_cast<double>(e.falseNegatives + e.falsePositives + e.unresolved + e.bothHit - e.sameLabel) / beams;
  };
  if (wrong(a) != wrong(b)) return wrong(a) < wrong(b);
  return a.range.p99 != b.range.p99 ? a.range.p99 < b.range.p99 : a.range.mean < b.range.mean;
}

std::size_t nearestToHolding(std::span<const Candidate> candidates, const ErrorLimits& limits) {
  if (candidates.empty()) throw Error("there is no setting to choose from");
  // The cheaper of two candidates is returned if both exceed limits by the same factor.
  const auto order = [&](const Candidate& c) { return std::pair(largestExcess(c, limits), c.secondsPerBeam); };
  return static_cast<std::size_t>(std::ranges::min_element(candidates, {}, order) - candidates.begin());
}

std::vector<std::size_t> paretoFront(std::span<const double> a, std::span<const double> b) {
  if (a.size() != b.size()) throw Error(fmt::format("{} and {} costs make no front", a.size(), b.size()));
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!std::isnan(a[i]) && !std::isnan(b[i])) order.push_back(i);
  }
  std::ranges::stable_sort(order,
                           [&](std::size_t l, std::size_t r) { return a[l] != a[r] ? a[l] < a[r] : b[l] < b[r]; });
  std::vector<std::size_t> front;
  for (const std::size_t i : order) {
    const bool better = front.empty() || b[i] < b[front.back()];
    const bool equal = !front.empty() && a[i] == a[front.back()] && b[i] == b[front.back()];
    if (better || equal) front.push_back(i);
  }
  return front;
}

}  // namespace scanmill
