#pragma once

// Charts, which are drawn as SVG files for papers, and as JSON by the script of a page (report/page/charts.js). Every
// member has an initialiser, so that users may name just those that they mean.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/vec.h"

namespace scanmill {

inline constexpr std::size_t kChartColors = 8;  // in the palette

enum class AxisScale { Linear, Log };

struct ChartAxis {
  std::string title{};  // with its unit: "range error, 99th percentile (m)"
  AxisScale scale = AxisScale::Linear;
  // Units such as "m", "s" and "B" are written with prefixes (10 µm, 1 mm), and "%" makes per cent of shares. Without a
  // unit, numbers are written as 0.001 and 10 k.
  std::string unit{};
  // The ends of the axis. They follow from the data where absent, and are widened where data lie beyond.
  std::optional<double> low{}, high{};
  // On a logarithmic axis values of zero and below lie on a line of their own beside it, which has this name.
  std::string zero = "0";
  // Names that stand for the numbers 0, 1, 2 and so on; on the y axis they run downwards.
  std::vector<std::string> names{};
};

enum class ChartMark { Dots, Line, LineAndDots, Bars };

struct ChartSeries {
  // The name in the legend, where series of one name and colour share an entry; one without a name has no entry.
  std::string name{};
  // The place in the palette, whose colours colour-blind people can tell apart (Okabe and Ito). The mark's shape
  // follows from it, too.
  std::size_t color = 0;
  ChartMark mark = ChartMark::Dots;
  bool emphasised = false;      // larger and drawn on top, as the Pareto front is
  bool labelsFirst = false;     // its labels displace those of other series, and stand even where room is scarce
  std::vector<Vec2d> points{};  // a point that is not finite is left out, and a line is broken there
  // The following lists are empty, or have an entry for each point.
  std::vector<Vec2d> spans{};          // the low and high end of an error bar in y
  std::vector<std::string> labels{};   // written beside the point where there is room; an empty one is not written
  std::vector<std::string> details{};  // shown when the point is pointed at
  std::vector<std::string> fills{};  // "#rrggbb" in place of the palette's colour of a bar; the legend shows the first
};

struct Chart {
  std::string name{};  // of its file, and of its place in a page
  std::string title{};
  std::string note{};  // stands below the title: what is shown, on which data
  ChartAxis x{}, y{};
  // A bar stands on the x axis, at the name whose number is its point's x. Where the y axis has names, bars lie, each
  // at the name whose number is its point's y.
  std::vector<ChartSeries> series{};
  bool stacked = false;  // bars at one name stand upon each other; for linear axes
  int width = 860;       // pixels
  int height = 480;      // pixels
};

// Whether any point can be drawn.
bool hasPoints(const Chart& chart);

// A number as an axis with this unit writes it: "0.001", "10 k", "1 M"; "10 µm"; "0.1 %".
std::string axisNumber(double value, const std::string& unit);

// Draws a whole SVG document, light or dark as the reader prefers. Text stays text. Without any finite point it says
// "no data".
std::string drawSvg(const Chart& chart);

// The JSON that charts.js reads: {stacked, x, y, series}. Values that are not finite are null.
std::string chartJson(const Chart& chart);

}  // namespace scanmill
