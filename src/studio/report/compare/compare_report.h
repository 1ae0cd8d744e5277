#pragma once

#include <string>

#include "study/compare/compare.h"

namespace scanmill {

// The page of a comparison, which needs no other file. `date`: "2026-11-23".
std::string comparisonPage(const SetComparison& comparison, const std::string& date);

// The value to try: "0.07", "30 (the most)".
std::string nextText(const KeyChange& advice);

// "12.3 mm" of a stored value; "-" where there is none.
std::string figureText(double value, double factor, std::string_view unit);

extern const std::string_view kCompareTemplate;  // compare.html

}  // namespace scanmill
