#pragma once

// Which of several settings is the cheapest that is good enough.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "config/value.h"
#include "evaluate/beam_errors.h"

namespace scanmill {

// What a user accepts. A limit that is absent accepts anything. Range errors are of the beams that both hit; rates and
// labels are shares from 0 to 1, as GroupErrors has them.
struct ErrorLimits {
  std::optional<double> mean, rms, median, p95, p99, p999, max;  // of the range error (m), at most
  std::optional<double> intensity;                               // the mean of the intensity's error, at most
  std::optional<double> missRate;                                // at most
  std::optional<double> labels, classes, instances;              // at least
  std::optional<double> minRate;                                 // beams/s, at least
};

// Reads {max_error: {p99: 2cm, miss_rate: 0.1%, labels: 99.5%, ...}, min_rate: 5e6}, where either key may be left out.
// Lengths take mm, cm or m, shares take % or a number from 0 to 1. `errors` and `rate` are the values of these keys, or
// null. Throws InputError.
ErrorLimits readErrorLimits(const Value* errors, const Value* rate);

struct Candidate {
  double secondsPerBeam = 0;
  GroupErrors errors;
};

// The limits that a candidate breaks, in words with figures ("p99 31 mm, 20 mm allowed"); empty where it holds all.
std::vector<std::string> broken(const Candidate& candidate, const ErrorLimits& limits);

// Every limit that is asked for and what the candidate has ("p99 1.2 mm, 20 mm allowed"), whether it holds or not.
std::vector<std::string> limitTexts(const Candidate& candidate, const ErrorLimits& limits);

// Whether `a` has fewer wrong beams than `b`: false negatives, false positives, unresolved ones and those with another
// class or instance. Of equals the one with the smaller p99, then the smaller mean, of the range error is more exact.
bool moreExact(const GroupErrors& a, const GroupErrors& b);

// The index of the best candidate among those that hold all limits. The one that costs least is the best, but costs
// that differ by less than a tenth, the noise of time, count as equal, and then the most exact is. Where nothing but a
// rate is asked for, the most exact of all that are fast enough is the best. Absent where no candidate holds.
std::optional<std::size_t> bestThatHolds(std::span<const Candidate> candidates, const ErrorLimits& limits);

// The index of the candidate that costs least among those that hold all limits; of equals the first. Absent where none
// holds.
std::optional<std::size_t> cheapest(std::span<const Candidate> candidates, const ErrorLimits& limits);
// The index of the candidate that comes nearest to holding: the largest factor by which it exceeds a limit is the
// least.
std::size_t nearestToHolding(std::span<const Candidate> candidates, const ErrorLimits& limits);

// Indices of the Pareto front of two costs, in the order of rising `a`: for each of them no other is at most as costly
// in both and less costly in one. What costs NaN is on no front.
std::vector<std::size_t> paretoFront(std::span<const double> a, std::span<const double> b);

}  // namespace scanmill
