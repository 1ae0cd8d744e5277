#pragma once

// Charts, which are drawn as SVG files for papers, and as JSON by the script of a page (report/page/charts.js). Every
// member has an initialiser, so that designated initialisers may name any subset of the members.

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
  // The ends of the axis. If absent, they follow from the data; data beyond them widen the axis.
  std::optional<double> low{}, high{};
  // On a logarithmic axis, values of zero and below lie on a separate line beside it; this is the line's name.
  std::string zero = "0";
  // Names for the values 0, 1, 2 and so on; on the y axis they run downwards.
  std::vector<std::string> names{};
};

enum class ChartMark { Dots, Line, LineAndDots, Bars };

struct ChartSeries {
  // The name in the legend, where series of the same name and colour share an entry; a series without a name has no
  // entry.
  std::string name{};
  // The index in the palette, whose colours colour-blind people can tell apart (Okabe and Ito). It also sets the mark's
  // shape.
  std::size_t color = 0;
  ChartMark mark = ChartMark::Dots;
  bool emphasised = false;  // larger and drawn on top, as the Pareto front is
  bool labelsFirst =
      false;  // the series' labels precede those of other series, and are drawn even if there is little room
  std::vector<Vec2d> points{};  // a point that is not finite is left out, and a line is broken there
  // The following lists are empty, or have an entry for each point.
  std::vector<Vec2d> spans{};          // the low and high end of an error bar in y
  std::vector<std::string> labels{};   // written beside the point if there is room; an empty label is not written
  std::vector<std::string> details{};  // shown when the pointer is on the point
  std::vector<std::string> fills{};  // "#rrggbb" of a bar in place of the palette's colour; the legend shows the first
};

struct Chart {
  std::string name{};  // the name of the chart's file, and of its element in a page
  std::string title{};
  std::string note{};  // written below the title: what is shown, on which data
  ChartAxis x{}, y{};
  // A vertical bar stands on the x axis, at the name whose number is its point's x. If the y axis has names, bars are
  // horizontal, each at the name whose number is its point's y.
  std::vector<ChartSeries> series{};
  bool stacked = false;  // bars at the same name are stacked; for linear axes
  int width = 860;       // pixels
  int height = 480;      // pixels
};

// True if any point can be drawn.
bool hasPoints(const Chart& chart);

// Formats a number as an axis with this unit does: "0.001", "10 k", "1 M"; "10 µm"; "0.1 %".
std::string axisNumber(double value, const std::string& unit);

// Draws an SVG document in the reader's preferred colour scheme, light or dark. Text stays text elements. Without any
// finite point the chart says "no data".
std::string drawSvg(const Chart& chart);

// Returns the JSON that charts.js reads: {stacked, x, y, series}. Values that are not finite are null.
std::string chartJson(const Chart& chart);

}  // namespace scanmill
