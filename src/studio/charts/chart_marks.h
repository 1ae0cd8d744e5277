#pragma once

// What stands for the data in a chart.

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

// <path> of the mark that goes with a colour, around (x, y).
std::string drawMark(std::size_t color, double x, double y, bool emphasised, bool dim, const std::string& detail);
// <path> of a line through pixels, broken at points that are not finite.
std::string drawLine(std::size_t color, const std::vector<Vec2d>& pixels, bool emphasised, bool dim);

// Where each point of a series ends, of stacked bars: indexed as the series, then as their points. The same as the
// points' own values elsewhere.
std::vector<std::vector<double>> barEnds(const Chart& chart);

// Attributes of a bar's colour: its own, or else its series'; `more` are further classes.
std::string barPaint(const ChartSeries& series, std::size_t bar, const std::string& more = "");

// Bars, error bars, lines, dots and labels of all series.
std::string drawSeries(const Chart& chart, const AxisMap& x, const AxisMap& y, const ChartBox& plot);

}  // namespace scanmill
