#pragma once

// The charts of a study's report: SVG, or empty where there is nothing to show.

#include <cstddef>
#include <string>

#include "study/tradeoff/study.h"

namespace scanmill {

inline constexpr int kReportWidth = 1160;       // pixels, of a chart that stands alone
inline constexpr std::size_t kReportRows = 40;  // the most settings that a chart has rows for

std::string rangeFrontChart(const Study& study);  // speed against range error, wider than paretoSvg()
std::string wrongFrontChart(const Study& study);  // speed against wrong beams

// A line per setting that is shown over the bands of range or incidence.
std::string rangeErrorByRange(const Study& study);
std::string wrongByRange(const Study& study);
std::string nearestByRange(const Study& study);
std::string rangeErrorByIncidence(const Study& study);
std::string wrongByIncidence(const Study& study);
std::string nearestByIncidence(const Study& study);
std::string recallByThickness(const Study& study);
std::string recallByLength(const Study& study);

// A row per setting.
std::string rangeErrorByPlace(const Study& study);
std::string wrongByPlace(const Study& study);
std::string stagesChart(const Study& study);
// A row per class.
std::string wrongByClass(const Study& study);
std::string lostByClass(const Study& study);

std::string encodingsChart(const Study& study);
std::string ringsChart(const Study& study);

}  // namespace scanmill
