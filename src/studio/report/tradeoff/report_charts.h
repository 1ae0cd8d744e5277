#pragma once

// Draws the charts of a study's report as SVG; a chart is empty where there is nothing to show.

#include <cstddef>
#include <string>

#include "study/tradeoff/study.h"

namespace scanmill {

inline constexpr int kReportWidth = 1160;       // pixels; the width of a chart that stands alone
inline constexpr std::size_t kReportRows = 40;  // a chart has rows for at most so many settings

// Speed against range error, as the file pareto.svg, which docs/tradeoff.md shows.
std::string paretoSvg(const Study& study);
// The same chart in the page's width, and speed against the share of wrong beams.
std::string rangeFrontChart(const Study& study);
std::string wrongFrontChart(const Study& study);

// Charts with a line per setting over the bands of range, of incidence, or of the sizes of things.
std::string rangeErrorByRange(const Study& study);
std::string wrongByRange(const Study& study);
std::string nearestByRange(const Study& study);
std::string rangeErrorByIncidence(const Study& study);
std::string wrongByIncidence(const Study& study);
std::string nearestByIncidence(const Study& study);
std::string recallByThickness(const Study& study);
std::string recallByLength(const Study& study);

// Charts with a row per setting.
std::string rangeErrorByPlace(const Study& study);
std::string wrongByPlace(const Study& study);
std::string stagesChart(const Study& study);
// Charts with a row per class.
std::string wrongByClass(const Study& study);
std::string falseNegativesByClass(const Study& study);

std::string encodingsChart(const Study& study);
std::string ringsChart(const Study& study);

}  // namespace scanmill
