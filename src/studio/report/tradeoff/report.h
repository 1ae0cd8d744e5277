#pragma once

// The report of a trade-off study.

#include <string>

#include "study/tradeoff/study.h"

namespace scanmill {

// The page index.html, with charts, tables and pictures; it needs no other file and no network.
std::string studyReport(const Study& study);

}  // namespace scanmill
