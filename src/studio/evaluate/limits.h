#pragma once

// Finds the cheapest of several settings that keep given error limits.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "config/value.h"
#include "evaluate/beam_errors.h"

namespace scanmill {

// The errors and the rate that a user accepts. An absent limit accepts anything. Range errors are of the beams that
// both hit; miss rates and labels are shares from 0 to 1, as in GroupErrors.
struct ErrorLimits {
  std::optional<double> mean, rms, median, p95, p99, p999, max;  // greatest allowed range errors (m)
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

// Returns the limits that a candidate breaks, with figures ("p99 31 mm, 20 mm allowed"); empty if it holds all limits.
std::vector<std::string> broken(const Candidate& candidate, const ErrorLimits& limits);

// Returns each limit that is asked for, with the candidate's value ("p99 1.2 mm, at most 20 mm"), whether it holds or
// not.
std::vector<std::string> limitTexts(const Candidate& candidate, const ErrorLimits& limits);

// True if `a` has a smaller share of wrong beams than `b`: false negatives, false positives, unresolved beams and beams
// with another class or instance. For equal shares, the smaller p99, then the smaller mean, of the range error decides.
bool moreExact(const GroupErrors& a, const GroupErrors& b);

// Returns the index of the best candidate among those that hold all limits; nothing if no candidate holds them. The
// best is the most exact of those that cost at most a tenth more than the cheapest: timing noise makes such costs count
// as equal. If only a rate is asked for, the best is the most exact of all that are fast enough.
std::optional<std::size_t> bestThatHolds(std::span<const Candidate> candidates, const ErrorLimits& limits);

// Returns the index of the first candidate with the least cost among those that hold all limits; nothing if none holds
// them.
std::optional<std::size_t> cheapest(std::span<const Candidate> candidates, const ErrorLimits& limits);
// Returns the index of the candidate that comes nearest to holding all limits: the one for which the largest factor by
// which it exceeds a limit is smallest.
std::size_t nearestToHolding(std::span<const Candidate> candidates, const ErrorLimits& limits);

// Returns the indices of the Pareto front of two costs, sorted by rising `a`. An item is on the front if no other item
// is at most as costly in both costs and less costly in one. Items with a cost of NaN are never on the front.
std::vector<std::size_t> paretoFront(std::span<const double> a, std::span<const double> b);

}  // namespace scanmill
