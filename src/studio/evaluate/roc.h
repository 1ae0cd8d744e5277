#pragma once

#include <vector>

namespace scanmill {

// Returns how well two sets of values can be separated by a threshold: the area under the receiver operating
// characteristic (ROC) curve. This is the probability that a random value of `b` is greater than a random value of `a`,
// where equal values count half (Hanley and McNeil, "The meaning and use of the area under a receiver operating
// characteristic (ROC) curve", Radiology 143, 1982). At 0.5 no threshold helps; at 0 or 1 a threshold separates the
// sets perfectly. Both sets must have values, none of them NaN.
double rocArea(std::vector<float> a, std::vector<float> b);

}  // namespace scanmill
