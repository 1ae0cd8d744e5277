#pragma once

// Compares settings with limits of errors and with each other.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "evaluate/beam_errors.h"

namespace scanmill {

// Limits of errors; an absent limit allows any value. Range errors are those of beams that hit in both the truth and
// the test. Miss rates and labels are fractions from 0 to 1, as in GroupErrors.
struct ErrorLimits {
  std::optional<double> p95{}, p99{};  // upper limits of the range error (m)
  std::optional<double> missRate{};    // upper limit of GroupErrors::missRate()
  std::optional<double> labels{};      // lower limit of the fraction of correct labels
};

struct Candidate {
  double secondsPerBeam = 0;
  GroupErrors errors;
};

// Returns a text for each limit that a candidate exceeds, such as "p99 31 mm, but at most 20 mm are allowed"; empty
// if it keeps all limits.
std::vector<std::string> broken(const Candidate& candidate, const ErrorLimits& limits);

// True if `a` has a smaller fraction of wrong beams than `b`. Wrong are false negatives, false positives, unresolved
// beams and beams with a wrong class or instance. If the fractions are equal, compares the p99 of the range error, then
// its mean.
bool moreExact(const GroupErrors& a, const GroupErrors& b);

// Returns the index of the candidate that comes nearest to keeping all limits: the candidate for which the largest
// factor by which it exceeds a limit is smallest.
std::size_t nearestToHolding(std::span<const Candidate> candidates, const ErrorLimits& limits);

// Returns the indices of the Pareto front of two costs, sorted by increasing `a`. An item is on the front if no other
// item is better in one cost and at least as good in the other. Items with a cost of NaN are never on the front.
std::vector<std::size_t> paretoFront(std::span<const double> a, std::span<const double> b);

}  // namespace scanmill
