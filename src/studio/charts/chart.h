#pragma once

// Charts as SVG: text stays text, no display is needed, and a browser opens them without a network. Every member has an
// initialiser, so that users may name just those they mean.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/vec.h"

namespace scanmill {

enum class AxisScale { Linear, Log };

struct ChartAxis {
  std::string title{};  // with its unit: "range error, 99th percentile (m)"
  AxisScale scale = AxisScale::Linear;
  // "m", "s", "B" ... are written with prefixes (10 µm, 1 mm), "%" makes per cent of shares; empty: 0.001, 10 k.
  std::string unit{};
  std::optional<double> low{}, high{};  // absent: from the data; widened where data lie beyond
  // On a logarithmic axis values of zero and below lie on a line of their own beside it, named so: "exact".
  std::string zero = "0";
  std::vector<std::string> names{};  // of 0, 1, 2, ... in place of numbers; on the y axis they run downwards
};

enum class ChartMark { Dots, Line, LineAndDots, Bars };

struct ChartSeries {
  std::string name{};     // in the legend, where those of one name and colour share an entry; empty: none
  std::size_t color = 0;  // of the palette, which colour-blind people can tell apart (Okabe and Ito); also the shape
  ChartMark mark = ChartMark::Dots;
  bool emphasised = false;             // larger, drawn on top: the Pareto front
  bool labelsFirst = false;            // labels that no other may displace, and that stand even where room is scarce
  std::vector<Vec2d> points{};         // one that is not finite is left out, and a line broken there
  std::vector<Vec2d> spans{};          // empty, or per point: the low and high end of an error bar in y
  std::vector<std::string> labels{};   // empty, or per point: written beside it where there is room ("": none)
  std::vector<std::string> details{};  // empty, or per point: shown when pointed at
  // Empty, or per bar: "#rrggbb" in place of the palette's colour; the legend shows the first.
  std::vector<std::string> fills{};
};

struct Chart {
  std::string title{};
  std::string note{};  // below the title: what is shown, on which data
  ChartAxis x{}, y{};
  // Bars stand on the x axis, whose names their points' x count; with names on the y axis they lie, and y counts.
  std::vector<ChartSeries> series{};
  bool stacked = false;  // bars of one name upon each other, on linear axes
  int width = 860;       // pixels
  int height = 480;
};

// A whole SVG document, light or dark as the reader prefers. Without any finite point it says "no data".
std::string drawSvg(const Chart& chart);

}  // namespace scanmill
