#pragma once

// Finds the cheapest of several settings that keep given error limits.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "config/value.h"
#include "evaluate/beam_errors.h"

namespace scanmill {

// The limits that a user sets for errors and rate; an absent limit allows any value. Range errors are those of beams
// that hit in both the truth and the test. Miss rates and labels are fractions from 0 to 1, as in GroupErrors.
struct ErrorLimits {
  std::optional<double> mean{}, rms{}, median{}, p95{}, p99{}, p999{}, max{};  // upper limits of the range error (m)
  std::optional<double> intensity{};  // upper limit of the mean intensity error
  std::optional<double> missRate{};   // upper limit of GroupErrors::missRate()
  // Lower limits of the fractions of correct labels, classes and instances.
  std::optional<double> labels{}, classes{}, instances{};
  std::optional<double> minRate{};  // lower limit of the rate (beams/s)
};

// Reads limits such as {max_error: {p99: 2cm, miss_rate: 0.1%, labels: 99.5%}, min_rate: 5e6}. `errors` and `rate` are
// the values of these two keys; null if a key is absent. Lengths need the unit mm, cm or m; fractions have a % sign or
// are numbers from 0 to 1. Throws InputError.
ErrorLimits readErrorLimits(const Value* errors, const Value* rate);

struct Candidate {
  double secondsPerBeam = 0;
  GroupErrors errors;
};

// Returns a text for each limit that a candidate exceeds, such as "p99 31 mm, but at most 20 mm are allowed"; empty
// if it keeps all limits.
std::vector<std::string> broken(const Candidate& candidate, const ErrorLimits& limits);

// Returns a text for each limit that is set, whether kept or exceeded, with the candidate's value, such as "p99 1.2 mm,
// at most 20 mm".
std::vector<std::string> limitTexts(const Candidate& candidate, const ErrorLimits& limits);

// True if `a` has a smaller fraction of wrong beams than `b`. Wrong are false negatives, false positives, unresolved
// beams and beams with a wrong class or instance. If the fractions are equal, compares the p99 of the range error, then
// its mean.
bool moreExact(const GroupErrors& a, const GroupErrors& b);

// Returns the index of the best candidate that keeps all limits; nothing if there is none. The best is the most exact
// candidate among those that cost at most a tenth more than the cheapest one, since timing noise hides such
// differences. If only the rate is limited, the best is the most exact of all candidates that are fast enough.
std::optional<std::size_t> bestThatHolds(std::span<const Candidate> candidates, const ErrorLimits& limits);

// Returns the index of the cheapest candidate that keeps all limits, the first of several with equal cost; nothing if
// there is none.
std::optional<std::size_t> cheapest(std::span<const Candidate> candidates, const ErrorLimits& limits);
// Returns the index of the candidate that comes nearest to keeping all limits: the candidate for which the largest
// factor by which it exceeds a limit is smallest.
std::size_t nearestToHolding(std::span<const Candidate> candidates, const ErrorLimits& limits);

// Returns the indices of the Pareto front of two costs, sorted by increasing `a`. An item is on the front if no other
// item is better in one cost and at least as good in the other. Items with a cost of NaN are never on the front.
std::vector<std::size_t> paretoFront(std::span<const double> a, std::span<const double> b);

}  // namespace scanmill
