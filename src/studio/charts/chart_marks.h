#pragma once

// Draws what stands for the data in a chart: dots, lines, bars and labels.

#include <cmath>
#include <string>
#include <vector>

#include "charts/axis_map.h"
#include "charts/chart.h"
#include "charts/label_places.h"

namespace scanmill {

constexpr double kLabelFont = 11.5;  // pixels

inline bool isDrawn(const Vec2d& point) {
  return std::isfinite(point.x) && std::isfinite(point.y);
}

// The <path> of the mark that goes with a colour, around (x, y).
std::string drawMark(std::size_t color, double x, double y, bool emphasised, bool dim, const std::string& detail);
// The <path> of a line through pixels, broken at points that are not finite.
std::string drawLine(std::size_t color, const std::vector<Vec2d>& pixels, bool emphasised, bool dim);

// The values at which the bars end, first by the series, then by their points. They are the points' own values, but for
// stacked bars.
std::vector<std::vector<double>> barEnds(const Chart& chart);

// The attributes that give a bar its own colour, or else that of its series. `more` are further CSS classes.
std::string barPaint(const ChartSeries& series, std::size_t bar, const std::string& more = "");

// Draws the bars, error bars, lines, dots and labels of all series.
std::string drawSeries(const Chart& chart, const AxisMap& x, const AxisMap& y, const ChartBox& plot);

}  // namespace scanmill
