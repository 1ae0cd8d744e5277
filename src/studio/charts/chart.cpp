#include "charts/chart.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "charts/axis_map.h"
#include "charts/chart_marks.h"
#include "charts/chart_style.h"
#include "charts/svg_text.h"

namespace scanmill {

namespace {

constexpr double kMargin = 16;  // pixels
constexpr double kTitleFont = 15, kNoteFont = 12, kTickFont = 11.5;
constexpr double kTurned = 0.5;  // rad, of names that are too long to lie side by side
constexpr double kNamesShare = 0.42,
                 kTurnedRoom = 90;  // the most that names take: of the width, and pixels of the height

struct AxisValues {
  std::vector<double> x, y;
};

// All that must have a place.
AxisValues valuesOf(const Chart& chart) {
  AxisValues values;
  const bool lying = !chart.y.names.empty();
  const std::vector<std::vector<double>> ends = barEnds(chart);
  for (std::size_t s = 0; s < chart.series.size(); ++s) {
    const ChartSeries& series = chart.series[s];
    for (std::size_t i = 0; i < series.points.size(); ++i) {
      const Vec2d& p = series.points[i];
      if (!isDrawn(p)) continue;
      values.x.push_back(lying ? ends[s][i] : p.x);
      values.y.push_back(lying ? p.y : ends[s][i]);
      // A label beyond a bar's end needs room.
      const bool labelled = i < series.labels.size() && !series.labels[i].empty();
      if (series.mark == ChartMark::Bars && labelled) (lying ? values.x : values.y).push_back(ends[s][i] * 1.12);
      if (i < series.spans.size() && isDrawn(series.spans[i])) {
        values.y.insert(values.y.end(), {series.spans[i].x, series.spans[i].y});
      }
    }
  }
  return values;
}

class ChartDrawing {
 public:
  explicit ChartDrawing(const Chart& chart)
      : chart_(chart),
        values_(valuesOf(chart)),
        width_(std::max(chart.width, 200)),
        height_(std::max(chart.height, 160)) {}

  std::string draw() {
    head();
    if (values_.x.empty()) {
      text("nodata muted", width_ / 2, (top_ + height_) / 2, "middle", "no data");
    } else {
      legend();
      axes();
    }
    return fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"smc\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
        "role=\"img\" aria-label=\"{2}\">\n{3}<rect class=\"page\" width=\"{0}\" height=\"{1}\" "
        "rx=\"6\"/>\n{4}</svg>\n",
        svgNumber(width_), svgNumber(height_), escapeXml(chart_.title), chartStyle(), out_);
  }

 private:
  void text(const char* kind, double x, double y, const char* anchor, const std::string& words,
            const std::string& more = "") {
    out_ += fmt::format("<text class=\"{}\" x=\"{}\" y=\"{}\" text-anchor=\"{}\"{}>{}</text>\n", kind, svgNumber(x),
                        svgNumber(y), anchor, more, escapeXml(words));
  }

  void stroke(const char* kind, double x0, double y0, double x1, double y1) {
    out_ += fmt::format("<path class=\"{}\" d=\"M{},{}L{},{}\"/>\n", kind, svgNumber(x0), svgNumber(y0), svgNumber(x1),
                        svgNumber(y1));
  }

  void head() {
    top_ = kMargin * 0.75;
    for (const std::string& line : wrapSvgText(chart_.title, kTitleFont, width_ - 2 * kMargin, true)) {
      text("title", kMargin, top_ + kTitleFont, "start", line);
      top_ += kTitleFont * 1.3;
    }
    for (const std::string& line : wrapSvgText(chart_.note, kNoteFont, width_ - 2 * kMargin)) {
      text("note muted", kMargin, top_ + kNoteFont + 2, "start", line);
      top_ += kNoteFont * 1.35;
    }
    top_ += 8;
  }

  void legend() {
    struct Entry {
      const ChartSeries* series;
      bool line = false, dot = false, bar = false;
    };
    std::vector<Entry> entries;
    for (const ChartSeries& s : chart_.series) {
      if (s.name.empty() || std::none_of(s.points.begin(), s.points.end(), isDrawn)) continue;
      auto entry = std::find_if(entries.begin(), entries.end(), [&](const Entry& e) {
        return e.series->name == s.name && e.series->color % kChartColors == s.color % kChartColors;
      });
      if (entry == entries.end()) entry = entries.insert(entries.end(), {&s});
      entry->line |= s.mark == ChartMark::Line || s.mark == ChartMark::LineAndDots;
      entry->dot |= s.mark == ChartMark::Dots || s.mark == ChartMark::LineAndDots;
      entry->bar |= s.mark == ChartMark::Bars;
    }
    if (entries.empty()) return;
    double x = kMargin, y = top_ + kTickFont;
    for (const Entry& entry : entries) {
      const std::string name = fitSvgText(entry.series->name, kTickFont, width_ - 2 * kMargin - 34);
      const double sample = entry.line ? 26 : 14;
      const double wide = sample + 6 + svgTextWidth(name, kTickFont);
      if (x > kMargin && x + wide > width_ - kMargin) {
        x = kMargin;
        y += kTickFont * 1.6;
      }
      const double middle = y - kTickFont * 0.35;
      out_ += "<g class=\"legend\">";
      if (entry.line) out_ += drawLine(entry.series->color, {{x, middle}, {x + sample, middle}}, false, false);
      if (entry.dot) out_ += drawMark(entry.series->color, x + sample / 2, middle, false, false, "");
      if (entry.bar) {
        out_ += fmt::format("<rect {} x=\"{}\" y=\"{}\" width=\"11\" height=\"11\"/>", barPaint(*entry.series, 0),
                            svgNumber(x), svgNumber(middle - 5.5));
      }
      text("entry", x + sample + 6, y, "start", name);
      out_ += "</g>\n";
      x += wide + 18;
    }
    top_ = y + 12;
  }

  void axes() {
    const bool bars = std::any_of(chart_.series.begin(), chart_.series.end(),
                                  [](const ChartSeries& s) { return s.mark == ChartMark::Bars; });
    const bool lying = !chart_.y.names.empty();
    ChartBox plot{kMargin, top_, width_ - kMargin - 8, height_ - kMargin};
    const std::vector<std::string> xTitle = wrapSvgText(chart_.x.title, kNoteFont, width_ * 0.8);
    plot.bottom -= kTickFont * 1.8 + kNoteFont * 1.35 * static_cast<double>(xTitle.size());
    if (!chart_.y.title.empty()) {
      text("axistitle muted", kMargin, plot.top + kNoteFont, "start", chart_.y.title);
      plot.top += kNoteFont * 1.9;
    }

    AxisMap y(chart_.y, values_.y, bars && !lying, plot.bottom - plot.top, kTickFont * 2.8);
    double names = y.zeroLine() ? svgTextWidth(chart_.y.zero, kTickFont) : 0;
    for (const AxisTick& tick : y.ticks()) names = std::max(names, svgTextWidth(tick.text, kTickFont));
    names = std::min(names, width_ * kNamesShare);
    plot.left += names + 9;

    AxisMap x(chart_.x, values_.x, bars && lying, plot.right - plot.left, kTickFont * 4.6);
    // Names of places that are too narrow for them are turned, and need room below and to the left.
    double widest = 0;
    for (const std::string& name : chart_.x.names) widest = std::max(widest, svgTextWidth(name, kTickFont));
    const double slot = (plot.right - plot.left) / std::max<double>(1, static_cast<double>(chart_.x.names.size()));
    const bool turned = widest > slot - 4;
    if (turned) {
      widest = std::min(widest, kTurnedRoom / std::sin(kTurned));
      plot.bottom -= widest * std::sin(kTurned);
      plot.left = std::max(plot.left, kMargin + widest * std::cos(kTurned) - slot / 2);
    }

    x.place(plot.left, plot.right);
    if (lying) {
      y.place(plot.top, plot.bottom);
    } else {
      y.place(plot.bottom, plot.top);
    }
    bands(x, y, plot);
    xTicks(x, plot, turned ? widest : 0);
    yTicks(y, plot, names);
    double below = height_ - kMargin * 0.6 - kNoteFont * 1.35 * (static_cast<double>(xTitle.size()) - 1);
    for (const std::string& line : xTitle) {
      text("axistitle muted", (plot.left + plot.right) / 2, below, "middle", line);
      below += kNoteFont * 1.35;
    }
    out_ += drawSeries(chart_, x, y, plot);
  }

  void bands(const AxisMap& x, const AxisMap& y, const ChartBox& plot) {
    const auto band = [&](double left, double top, double right, double bottom) {
      out_ += fmt::format("<rect class=\"band\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>\n", svgNumber(left),
                          svgNumber(top), svgNumber(right - left), svgNumber(bottom - top));
    };
    if (x.zeroLine()) band(plot.left, plot.top, x.bandEnd(), plot.bottom);
    if (y.zeroLine()) band(plot.left, y.bandEnd(), plot.right, plot.bottom);
  }

  void xTicks(const AxisMap& x, const ChartBox& plot, double turnedWidth) {
    const bool named = !chart_.x.names.empty();
    // What would run into the one before has no text.
    double before = -kMargin;
    const auto tick = [&](double at, const std::string& words) {
      if (!named) stroke("grid", at, plot.top, at, plot.bottom);
      stroke("axis", at, plot.bottom, at, plot.bottom + 4);
      const double below = plot.bottom + 6 + kTickFont;
      if (turnedWidth > 0) {
        text("tick", at, below - 2, "end", fitSvgText(words, kTickFont, turnedWidth),
             fmt::format(" transform=\"rotate(-{} {} {})\"", svgNumber(kTurned * 180 / 3.14159265358979), svgNumber(at),
                         svgNumber(below - 6)));
      } else {
        const double half = svgTextWidth(words, kTickFont) / 2;
        if (at - half < before && !named) return;
        text("tick", at, below, "middle", words);
        before = at + half + 5;
      }
    };
    if (x.zeroLine()) tick(*x.zeroLine(), chart_.x.zero);
    for (const AxisTick& t : x.ticks()) tick(x.at(t.value), t.text);
    for (const double minor : x.minorTicks()) stroke("axis", x.at(minor), plot.bottom, x.at(minor), plot.bottom + 2.5);
    stroke("axis", plot.left, plot.bottom, plot.right, plot.bottom);
  }

  void yTicks(const AxisMap& y, const ChartBox& plot, double room) {
    const auto tick = [&](double at, const std::string& words) {
      stroke("grid", plot.left, at, plot.right, at);
      const std::string fitting = fitSvgText(words, kTickFont, room + 1);
      if (fitting != words) out_ += fmt::format("<g><title>{}</title>", escapeXml(words));
      text("tick", plot.left - 8, at + kTickFont * 0.35, "end", fitting);
      if (fitting != words) out_ += "</g>\n";
    };
    for (const AxisTick& t : y.ticks()) tick(y.at(t.value), t.text);
    for (const double minor : y.minorTicks()) stroke("axis", plot.left - 2.5, y.at(minor), plot.left, y.at(minor));
    if (y.zeroLine()) tick(*y.zeroLine(), chart_.y.zero);
    stroke("axis", plot.left, plot.top, plot.left, plot.bottom);
  }

  const Chart& chart_;
  AxisValues values_;
  double width_, height_;
  double top_ = 0;  // below what is drawn
  std::string out_;
};

}  // namespace

bool hasPoints(const Chart& chart) {
  return std::any_of(chart.series.begin(), chart.series.end(),
                     [](const ChartSeries& s) { return std::any_of(s.points.begin(), s.points.end(), isDrawn); });
}

std::string drawSvg(const Chart& chart) {
  return ChartDrawing(chart).draw();
}

}  // namespace scanmill
