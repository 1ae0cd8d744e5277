#pragma once

#include <vector>

namespace scanmill {

// The area under the receiver operating characteristic of telling two sets apart by a value: the probability that a
// value of `b` is greater than one of `a`, ties counting half (Hanley and McNeil, "The meaning and use of the area
// under a receiver operating characteristic (ROC) curve", Radiology 143, 1982). 0.5: they do not differ; 0 or 1: one
// value tells. Both must have values, without NaN.
double rocArea(std::vector<float> a, std::vector<float> b);

}  // namespace scanmill
