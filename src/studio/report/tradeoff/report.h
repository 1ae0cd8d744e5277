#pragma once

// The report of a trade-off study.

#include <string>
#include <string_view>

#include "study/tradeoff/study.h"

namespace scanmill {

// Returns the page index.html, with charts, tables and pictures; it needs no other file and no network.
std::string studyReport(const Study& study);

// Returns "--set 'method={particle: {refine: none}}'", quoted for a shell.
std::string setArgument(const Setting& setting);

extern const std::string_view kTradeoffTemplate;  // tradeoff.html

}  // namespace scanmill
