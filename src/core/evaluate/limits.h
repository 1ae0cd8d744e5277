#pragma once

// Which of several settings is the cheapest that is good enough.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "config/value.h"
#include "evaluate/beam_errors.h"

namespace scanmill {

// What a user accepts; absent: anything. Range errors in m over the beams that both hit; rates and labels are shares
// (0 to 1) as GroupErrors has them.
struct ErrorLimits {
  std::optional<double> mean, rms, median, p95, p99, p999, max;  // at most (m)
  std::optional<double> intensity;                               // the mean of its error, at most
  std::optional<double> missRate;                                // at most
  std::optional<double> labels, classes, instances;              // at least
  std::optional<double> minRate;                                 // beams/s, at least
};

// YAML: {max_error: {p99: 2cm, miss_rate: 0.1%, labels: 99.5%, ...}, min_rate: 5e6}, either or both. Lengths take mm,
// cm or m, shares % or a number from 0 to 1. `errors` and `rate` are the values of these keys, or null. Throws
// InputError.
ErrorLimits readErrorLimits(const Value* errors, const Value* rate);

struct Candidate {
  double secondsPerBeam = 0;
  GroupErrors errors;
};

// What of the limits does not hold, in words with figures ("p99 31 mm, 20 mm allowed"); empty: all hold.
std::vector<std::string> broken(const Candidate& candidate, const ErrorLimits& limits);

// What of the limits was asked and what it came to ("p99 1.2 mm, 20 mm allowed"), whether it holds or not.
std::vector<std::string> limitTexts(const Candidate& candidate, const ErrorLimits& limits);

// Fewer beams that are lost, spurious or given another class or instance; of equals a smaller p99, then mean, of the
// range error.
bool moreExact(const GroupErrors& a, const GroupErrors& b);

// Of those that hold all limits the one that costs least; of those within a tenth of its cost, which is the noise of
// time, the most exact. Where nothing but a rate is asked for, the most exact of all that are fast enough. Empty: none
// holds.
std::optional<std::size_t> bestThatHolds(std::span<const Candidate> candidates, const ErrorLimits& limits);

// The one that costs least among those that hold all limits; of equals the first. Empty: none holds.
std::optional<std::size_t> cheapest(std::span<const Candidate> candidates, const ErrorLimits& limits);
// The one that comes nearest to holding: the least of the largest factor by which a limit is exceeded.
std::size_t nearestToHolding(std::span<const Candidate> candidates, const ErrorLimits& limits);

// Indices of the Pareto front of two costs, both the less the better: no other is at most as costly in both and less in
// one. In the order of rising `a`. NaN is on no front.
std::vector<std::size_t> paretoFront(std::span<const double> a, std::span<const double> b);

}  // namespace scanmill
