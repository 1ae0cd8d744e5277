#pragma once

#include <vector>

namespace scanmill {

// Returns the area under the receiver operating characteristic (ROC) curve for telling two sets apart by a threshold on
// their values: the probability that a value of `b` is greater than one of `a`, ties counting half (Hanley and McNeil,
// "The meaning and use of the area under a receiver operating characteristic (ROC) curve", Radiology 143, 1982). At 0.5
// no threshold helps; at 0 or 1 a threshold separates the sets. Both sets must have values, without NaN.
double rocArea(std::vector<float> a, std::vector<float> b);

}  // namespace scanmill
