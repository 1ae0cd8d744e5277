#pragma once

// Charts, drawn as SVG for files and pages. All members have initialisers, so designated initialisers may omit some.

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/vec.h"

namespace scanmill {

inline constexpr std::size_t kChartColors = 8;  // number of colours in the palette

enum class AxisScale { Linear, Log };

struct ChartAxis {
  std::string title{};  // title with the unit, such as "range error, 99th percentile (m)"
  AxisScale scale = AxisScale::Linear;
  // The unit of the numbers. Units such as "m", "s" and "B" get SI prefixes (10 µm, 1 mm); with "%", numbers are
  // fractions and are written in per cent (0.1 as 10 %). Without a unit, numbers are written like 0.001 and 10 k.
  std::string unit{};
  // The ends of the axis. The data determine an absent end. If data lie beyond an end, the axis is extended.
  std::optional<double> low{}, high{};
  // Label of the band at the start of a logarithmic axis. Values of zero and below are drawn in this band.
  std::string zero = "0";
  // Labels for the values 0, 1, 2 and so on, instead of numbers. Value 0 of a y axis is at the top.
  std::vector<std::string> names{};
};

enum class ChartMark { Dots, Line, LineAndDots, Bars };

struct ChartSeries {
  // The name in the legend; empty: the legend omits the series. Series with the same name and colour share an entry.
  std::string name{};
  // Index in the palette, whose colours colour-blind people can distinguish (Okabe and Ito). The index also determines
  // the shape of the marks and the dashes of the lines.
  std::size_t color = 0;
  ChartMark mark = ChartMark::Dots;
  bool emphasised = false;      // drawn larger and above other series, for instance the Pareto front
  bool labelsFirst = false;     // labels are placed before other series' labels, if necessary far from their points
  std::vector<Vec2d> points{};  // points that are not finite are not drawn, and interrupt lines
  // Each of the following lists is empty or has one entry per point.
  // Texts that are drawn beside the point, or at the end of the bar, if there is room; an empty text is not drawn.
  std::vector<std::string> labels{};
  std::vector<std::string> details{};  // text that is shown when the pointer is on the point
  std::vector<std::string> fills{};    // "#rrggbb" colours of bars instead of the palette's; the legend shows the first

  void add(const Vec2d& point, std::string detail) {
    points.push_back(point);
    details.push_back(std::move(detail));
  }
};

struct Chart {
  std::string name{};  // name of the chart in the template of a page, and of its file without suffix
  std::string title{};
  std::string note{};  // text below the title: what is shown, from which data
  ChartAxis x{}, y{};
  // The series of the chart. Bars are vertical, and point.x is an index in the names of the x axis. If the y axis has
  // names, bars are horizontal, and point.y is an index in these names.
  std::vector<ChartSeries> series{};
  bool stacked = false;  // true: bars at the same name of an axis are stacked; not for logarithmic axes
  int width = 860;       // width of the drawing in pixels
  int height = 480;      // height in pixels; the drawing is higher if title, note or legend have several lines
};

// True if at least one point is finite and can be drawn.
bool hasPoints(const Chart& chart);

// Returns an SVG document with a light and a dark colour scheme; the reader's settings decide which is shown. Labels
// are text elements, not outlines. If no point is finite, the chart shows "no data".
std::string drawSvg(const Chart& chart);

}  // namespace scanmill
