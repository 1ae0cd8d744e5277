#pragma once

// Writes the report of a trade-off study.

#include <string>
#include <string_view>

#include "study/tradeoff/study.h"

namespace scanmill {

// Returns the HTML page index.html with charts, tables and pictures. It needs no other file and no network.
std::string studyReport(const Study& study);

// Returns the command-line argument that selects a setting, quoted for a shell, such as "--set 'method={particle:
// {refine: none}}'".
std::string setArgument(const Setting& setting);

extern const std::string_view kTradeoffTemplate;  // contents of tradeoff.html

}  // namespace scanmill
