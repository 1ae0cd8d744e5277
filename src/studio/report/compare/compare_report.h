#pragma once

#include <string>

#include "study/compare/compare.h"

namespace scanmill {

// Returns the page of a comparison, which needs no other file. `date`: "2026-11-23".
std::string comparisonPage(const SetComparison& comparison, const std::string& date);

// Returns the suggested value as text: "0.07", "30 (the most)".
std::string nextText(const KeyChange& advice);

// Formats a stored value as "12.3 mm"; "-" if it is NaN.
std::string figureText(double value, double factor, std::string_view unit);

extern const std::string_view kCompareTemplate;  // compare.html

}  // namespace scanmill
