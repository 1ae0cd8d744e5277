#pragma once

#include <string>

#include "study/compare/compare.h"

namespace scanmill {

// Returns the HTML page of a comparison, which needs no other file. `date`: date on the page, such as "2026-11-23".
std::string comparisonPage(const SetComparison& comparison, const std::string& date);

// Returns the suggested value as text, such as "0.07" or "30 (the most)".
std::string nextText(const KeyChange& advice);

// Formats a stored value times `factor` with its unit, such as "12.3 mm"; "-" if it is NaN.
std::string figureText(double value, double factor, std::string_view unit);

extern const std::string_view kCompareTemplate;  // contents of compare.html

}  // namespace scanmill
