#include "charts/chart_marks.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "charts/chart_style.h"
#include "charts/svg_text.h"

namespace scanmill {

namespace {

constexpr double kRadius = 4.5, kLargeRadius = 6.5;  // pixels
constexpr double kWidestBar = 26;

std::string numbers(const Vec2d& p) {
  return fmt::format("{},{}", svgNumber(p.x), svgNumber(p.y));
}

// Seven shapes of about the same weight, around the origin.
std::string shapePath(std::size_t shape, double r) {
  const auto polygon = [](const std::vector<Vec2d>& corners) {
    std::string d;
    for (const Vec2d& corner : corners) d += fmt::format("{}{}", d.empty() ? "M" : "L", numbers(corner));
    return d + "Z";
  };
  const double s = r * 0.89, d = r * 1.25, t = r * 1.2, c = r * 0.42, e = r * 1.15;
  switch (shape % 7) {
    case 0:
      return fmt::format("M{0},0A{1},{1} 0 1 1 {2},0A{1},{1} 0 1 1 {0},0Z", svgNumber(-r), svgNumber(r), svgNumber(r));
    case 1:
      return polygon({{-s, -s}, {s, -s}, {s, s}, {-s, s}});
    case 2:
      return polygon({{0, -d}, {d, 0}, {0, d}, {-d, 0}});
    case 3:
      return polygon({{0, -t}, {t, t * 0.75}, {-t, t * 0.75}});
    case 4:
      return polygon({{0, t}, {t, -t * 0.75}, {-t, -t * 0.75}});
    case 5:
      return polygon(
          {{-c, -e}, {c, -e}, {c, -c}, {e, -c}, {e, c}, {c, c}, {c, e}, {-c, e}, {-c, c}, {-e, c}, {-e, -c}, {-c, -c}});
    default:
      return polygon({{-s, -t}, {s, -t}, {e, 0}, {s, t}, {-s, t}, {-e, 0}});
  }
}

std::string titled(const std::string& detail) {
  return detail.empty() ? "" : fmt::format("<title>{}</title>", escapeXml(detail));
}

std::string at(const std::vector<std::string>& texts, std::size_t i) {
  return i < texts.size() ? texts[i] : "";
}

class SeriesDrawing {
 public:
  SeriesDrawing(const Chart& chart, const AxisMap& x, const AxisMap& y, const ChartBox& plot)
      : chart_(chart), x_(x), y_(y), plot_(plot), lying_(!chart.y.names.empty()), ends_(barEnds(chart)) {
    someEmphasised_ = std::any_of(chart.series.begin(), chart.series.end(), [](const auto& s) { return s.emphasised; });
  }

  std::string draw() {
    for (std::size_t s = 0; s < chart_.series.size(); ++s) {
      if (chart_.series[s].mark == ChartMark::Bars) bars(s);
    }
    for (const bool emphasised : {false, true}) {
      for (const ChartSeries& s : chart_.series) {
        if (s.emphasised == emphasised) spansAndLine(s);
      }
    }
    for (const bool emphasised : {false, true}) {
      for (const ChartSeries& s : chart_.series) {
        if (s.emphasised == emphasised && (s.mark == ChartMark::Dots || s.mark == ChartMark::LineAndDots)) dots(s);
      }
    }
    labels();
    return out_;
  }

 private:
  struct Text {
    LabelWish wish;
    std::string text;
    bool emphasised = false;
    int rank = 0;  // the lower, the earlier placed
  };

  bool dim(const ChartSeries& series) const { return someEmphasised_ && !series.emphasised; }
  Vec2d pixel(const Vec2d& p) const { return {x_.at(p.x), y_.at(p.y)}; }

  void wish(const ChartSeries& series, std::size_t i, const Vec2d& point, double radius, LabelWish::Side side) {
    const std::string text = at(series.labels, i);
    if (text.empty()) return;
    const double width = svgTextWidth(text, kLabelFont, series.emphasised);
    const int rank = series.labelsFirst ? 0 : series.emphasised ? 1 : 2;
    texts_.push_back(
        {{point, radius, width, kLabelFont * 1.2, side, series.labelsFirst}, text, series.emphasised, rank});
  }

  void bars(std::size_t s) {
    const ChartSeries& series = chart_.series[s];
    const AxisMap& names = lying_ ? y_ : x_;
    const AxisMap& values = lying_ ? x_ : y_;
    std::size_t groups = 0, place = 0;
    for (std::size_t other = 0; other < chart_.series.size(); ++other) {
      if (chart_.series[other].mark != ChartMark::Bars) continue;
      if (other < s) ++place;
      ++groups;
    }
    if (chart_.stacked) groups = 1, place = 0;
    const double slot = std::abs(names.at(1) - names.at(0)) * 0.76;
    const double thick = std::min(slot / static_cast<double>(groups), kWidestBar);
    for (std::size_t i = 0; i < series.points.size(); ++i) {
      const Vec2d& p = series.points[i];
      if (!isDrawn(p)) continue;
      const double value = lying_ ? p.x : p.y;
      const double begin = chart_.stacked ? values.at(ends_[s][i] - value) : values.base();
      const double end = values.at(ends_[s][i]);
      const double across =
          names.at(lying_ ? p.y : p.x) + (static_cast<double>(place) - static_cast<double>(groups) / 2) * thick;
      const double low = std::min(begin, end), length = std::abs(end - begin);
      const double gap = groups > 1 ? 1 : 0;  // between bars of a group
      const ChartBox box = lying_ ? ChartBox{low, across, low + length, across + thick - gap}
                                  : ChartBox{across, low, across + thick - gap, low + length};
      out_ +=
          fmt::format(R"(<rect {} x="{}" y="{}" width="{}" height="{}">{}</rect>)",
                      barPaint(series, i, dim(series) ? "bar dim" : "bar"), svgNumber(box.left), svgNumber(box.top),
                      svgNumber(box.right - box.left), svgNumber(box.bottom - box.top), titled(at(series.details, i)));
      out_ += '\n';
      marks_.push_back(box);
      if (lying_) {
        wish(series, i, {std::max(begin, end), (box.top + box.bottom) / 2}, 1, LabelWish::Side::Right);
      } else {
        wish(series, i, {(box.left + box.right) / 2, std::min(begin, end)}, 0, LabelWish::Side::Above);
      }
    }
  }

  void spansAndLine(const ChartSeries& series) {
    for (std::size_t i = 0; i < std::min(series.spans.size(), series.points.size()); ++i) {
      const Vec2d& span = series.spans[i];
      if (!isDrawn(series.points[i]) || !isDrawn(span)) continue;
      const double x = x_.at(series.points[i].x), low = y_.at(span.x), high = y_.at(span.y);
      out_ += fmt::format("<path class=\"span s{0}{1}\" d=\"M{2},{3}V{4}M{5},{3}H{6}M{5},{4}H{6}\"/>\n",
                          series.color % kChartColors, dim(series) ? " dim" : "", svgNumber(x), svgNumber(low),
                          svgNumber(high), svgNumber(x - 4), svgNumber(x + 4));
    }
    if (series.mark != ChartMark::Line && series.mark != ChartMark::LineAndDots) return;
    std::vector<Vec2d> pixels;
    for (const Vec2d& p : series.points) pixels.push_back(isDrawn(p) ? pixel(p) : p);
    out_ += drawLine(series.color, pixels, series.emphasised, dim(series));
    for (std::size_t i = 1; i < pixels.size(); ++i) {
      if (isDrawn(pixels[i - 1]) && isDrawn(pixels[i])) lines_.insert(lines_.end(), {pixels[i - 1], pixels[i]});
    }
    if (series.mark == ChartMark::LineAndDots) return;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      if (isDrawn(pixels[i])) wish(series, i, pixels[i], 0, LabelWish::Side::Any);
    }
  }

  void dots(const ChartSeries& series) {
    const double r = (series.emphasised ? kLargeRadius : kRadius) * 1.15;
    for (std::size_t i = 0; i < series.points.size(); ++i) {
      if (!isDrawn(series.points[i])) continue;
      const Vec2d p = pixel(series.points[i]);
      out_ += drawMark(series.color, p.x, p.y, series.emphasised, dim(series), at(series.details, i));
      marks_.push_back({p.x - r, p.y - r, p.x + r, p.y + r});
      wish(series, i, p, r, LabelWish::Side::Any);
    }
  }

  void labels() {
    std::stable_sort(texts_.begin(), texts_.end(), [](const Text& a, const Text& b) { return a.rank < b.rank; });
    std::vector<LabelWish> wishes;
    for (const Text& text : texts_) wishes.push_back(text.wish);
    const std::vector<std::optional<LabelPlace>> places = placeLabels(wishes, plot_, marks_, lines_);
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (!places[i]) continue;
      const ChartBox& box = places[i]->box;
      const Vec2d& p = texts_[i].wish.point;
      // Fonts differ in width: the side that is next to the mark is the one that stays.
      const bool leftOf = box.right<p.x, rightOf = box.left> p.x;
      const char* anchor = leftOf ? "end" : rightOf ? "start" : "middle";
      const double x = leftOf ? box.right : rightOf ? box.left : (box.left + box.right) / 2;
      if (places[i]->leader) {
        const Vec2d end{std::clamp(p.x, box.left, box.right), std::clamp(p.y, box.top, box.bottom)};
        out_ += fmt::format("<path class=\"leader\" d=\"M{}L{}\"/>\n", numbers(p), numbers(end));
      }
      out_ += fmt::format("<text class=\"label{}\" x=\"{}\" y=\"{}\" text-anchor=\"{}\">{}</text>\n",
                          texts_[i].emphasised ? " strong" : "", svgNumber(x), svgNumber(box.bottom - kLabelFont * 0.3),
                          anchor, escapeXml(texts_[i].text));
    }
  }

  const Chart& chart_;
  const AxisMap& x_;
  const AxisMap& y_;
  ChartBox plot_;
  bool lying_;
  bool someEmphasised_ = false;
  std::vector<std::vector<double>> ends_;
  std::vector<ChartBox> marks_;
  std::vector<Vec2d> lines_;
  std::vector<Text> texts_;
  std::string out_;
};

}  // namespace

std::string drawMark(std::size_t color, double x, double y, bool emphasised, bool dim, const std::string& detail) {
  return fmt::format("<path class=\"mark f{}{}\" transform=\"translate({},{})\" d=\"{}\">{}</path>\n",
                     color % kChartColors, dim ? " dim" : "", svgNumber(x), svgNumber(y),
                     shapePath(color, emphasised ? kLargeRadius : kRadius), titled(detail));
}

std::string drawLine(std::size_t color, const std::vector<Vec2d>& pixels, bool emphasised, bool dim) {
  std::string d;
  bool open = false;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (!isDrawn(pixels[i])) {
      open = false;
      continue;
    }
    d += (open ? "L" : "M") + numbers(pixels[i]);
    // A point alone is a dot of the line's width.
    if (!open && (i + 1 == pixels.size() || !isDrawn(pixels[i + 1]))) d += "h0";
    open = true;
  }
  if (d.empty()) return "";
  return fmt::format("<path class=\"line s{}{}{}\" d=\"{}\"/>\n", color % kChartColors, emphasised ? " wide" : "",
                     dim ? " dim" : "", d);
}

std::string barPaint(const ChartSeries& series, std::size_t bar, const std::string& more) {
  const std::string fill = at(series.fills, bar);
  const std::string kind = more.empty() ? "" : more + " ";
  if (fill.empty()) return fmt::format("class=\"{}f{}\"", kind, series.color % kChartColors);
  return fmt::format("class=\"{}\" style=\"fill:{}\"", more, escapeXml(fill));
}

std::vector<std::vector<double>> barEnds(const Chart& chart) {
  const bool lying = !chart.y.names.empty();
  std::map<double, double> sums;  // by name
  std::vector<std::vector<double>> ends;
  for (const ChartSeries& series : chart.series) {
    std::vector<double>& own = ends.emplace_back();
    for (const Vec2d& p : series.points) {
      const double value = lying ? p.x : p.y;
      own.push_back(value);
      if (!chart.stacked || series.mark != ChartMark::Bars || !isDrawn(p)) continue;
      own.back() = sums[lying ? p.y : p.x] += value;
    }
  }
  return ends;
}

std::string drawSeries(const Chart& chart, const AxisMap& x, const AxisMap& y, const ChartBox& plot) {
  return SeriesDrawing(chart, x, y, plot).draw();
}

}  // namespace scanmill
