// Draws charts as SVG files. Labels are text elements. The styles do not use CSS variables, which only browsers
// support.

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>

#include "charts/chart.h"
#include "charts/chart_scale.h"
#include "charts/svg_text.h"

namespace scanmill {

namespace {

// Margin around a chart, and sizes of the chart's fonts (pixels).
constexpr double kMargin = 16, kTitleFont = 15, kNoteFont = 12, kFont = 11.5;
constexpr double kMarkRadius = 4.5, kEmphasisedRadius = 6.5;  // of the marks of points (pixels)
constexpr double kMarkReach = 1.15;  // largest extent of most of kShapes, relative to the radius
constexpr double kBarShare = 0.76;   // fraction of the distance between two names that the bars at a name fill
constexpr double kThickestBar = 26;  // pixels; bars at few names would be as wide as the chart otherwise
constexpr double kNameAngle = 26;    // rotation (degrees) of names that are too long to fit side by side
constexpr double kSwatch = 32;       // width of the mark before a name in the legend, with its margin (pixels)

bool hasLine(const ChartSeries& s) {
  return s.mark == ChartMark::Line || s.mark == ChartMark::LineAndDots;
}
bool hasDots(const ChartSeries& s) {
  return s.mark == ChartMark::Dots || s.mark == ChartMark::LineAndDots;
}

bool isDrawn(const Vec2d& p) {
  return std::isfinite(p.x) && std::isfinite(p.y);
}

// The palette of M. Okabe and K. Ito, Color Universal Design, 2008. Black is
// replaced by the ink colour. Yellow comes last, since it is hardly visible on a white page. On a dark page, both
// blues, vermilion and green are lighter.
using SeriesColors = std::array<const char*, kChartColors>;
constexpr SeriesColors kOnLight{"#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7", "#56B4E9", "#1f2328", "#F0E442"};
constexpr SeriesColors kOnDark{"#3D9BDC", "#E8762B", "#12B886", "#E69F00", "#CC79A7", "#7CC8F2", "#e6edf3", "#F0E442"};
struct ChartPalette {
  const char *page, *ink, *muted, *grid, *axis, *band;
  SeriesColors colors;
};
constexpr ChartPalette kLight{"#ffffff", "#1f2328", "#59636e", "#e8ebef", "#8b949e", "#f3f5f8", kOnLight};
constexpr ChartPalette kDark{"#12161c", "#e6edf3", "#9aa4af", "#262d36", "#6e7681", "#1a2029", kOnDark};
constexpr std::array kDashes{"", "7 3", "2.5 3", "10 3 2 3", "5 2 2 2 2 2", "12 4", "", "4 4"};
// SVG paths of marks around the origin. All cover about the same area as the first mark, a circle of radius 1.
constexpr std::array kShapes{"M-1,0A1,1 0 1 1 1,0A1,1 0 1 1 -1,0Z",
                             "M-.9-.9H.9V.9H-.9Z",
                             "M0-1.25L1.25,0L0,1.25L-1.25,0Z",
                             "M0-1.2L1.2,.9H-1.2Z",
                             "M0,1.2L1.2-.9H-1.2Z",
                             "M-.4-1.15H.4V-.4H1.15V.4H.4V1.15H-.4V.4H-1.15V-.4H-.4Z",
                             "M-.9-1.2H.9L1.15,0L.9,1.2H-.9L-1.15,0Z",
                             "M-1,0A1,1 0 1 1 1,0A1,1 0 1 1 -1,0Z"};

std::string rules(const ChartPalette& p) {
  std::string css = fmt::format(
      ".smc .page{{fill:{0}}}.smc text{{fill:{1}}}.smc .muted{{fill:{2}}}.smc .grid{{stroke:{3}}}.smc "
      ".axis{{stroke:{4}}}"
      ".smc .band{{fill:{5}}}.smc .mark,.smc .bar,.smc .label{{stroke:{0}}}",
      p.page, p.ink, p.muted, p.grid, p.axis, p.band);
  for (std::size_t i = 0; i < kChartColors; ++i) {
    css += fmt::format(".smc .f{0}{{fill:{1}}}.smc .s{0}{{stroke:{1}}}", i, p.colors[i]);
  }
  return css;
}

std::string style() {
  std::string css =
      ".smc text{font-family:Helvetica,Arial,'Liberation Sans',sans-serif;font-size:11.5px}"
      ".smc .title{font-size:15px;font-weight:600}.smc .note,.smc .axistitle{font-size:12px}"
      ".smc .strong{font-weight:600}.smc .line,.smc .span{fill:none;stroke-width:1.8}"
      ".smc .wide{stroke-width:2.4}.smc .dim{opacity:.6}.smc .mark{vector-effect:non-scaling-stroke}"
      ".smc .label{paint-order:stroke;stroke-width:2.5px;stroke-linejoin:round}";
  for (std::size_t i = 0; i < kChartColors; ++i) {
    if (*kDashes[i] != 0) css += fmt::format(".smc .line.s{}{{stroke-dasharray:{}}}", i, kDashes[i]);
  }
  return fmt::format("<style>{}{}@media (prefers-color-scheme:dark){{{}}}</style>\n", css, rules(kLight), rules(kDark));
}

struct ChartBox {
  double left = 0, top = 0, right = 0, bottom = 0;
  bool overlaps(const ChartBox& o) const {
    return left < o.right && o.left < right && top < o.bottom && o.top < bottom;
  }
};

class SvgDrawing {
 public:
  explicit SvgDrawing(const Chart& chart)
      : chart_(chart),
        horizontal_(!chart.y.names.empty()),
        width_(std::max(chart.width, 200)),
        height_(std::max(chart.height, 160)) {
    for (const ChartSeries& s : chart.series) emphasised_ = emphasised_ || s.emphasised;
  }

  std::string draw() {
    double top = kMargin * 0.75;
    for (const std::string& line : wrapSvgText(chart_.title, kTitleFont, width_ - 2 * kMargin, true)) {
      text("title", kMargin, top += kTitleFont * 1.2, "start", line);
    }
    for (const std::string& line : wrapSvgText(chart_.note, kNoteFont, width_ - 2 * kMargin)) {
      text("note muted", kMargin, top += kNoteFont * 1.35, "start", line);
    }
    if (hasPoints(chart_)) {
      constexpr double kUsualHead = 90;  // height of a title, a note and a legend of one line each (pixels)
      const double bottom = legend(top + 8);
      height_ += std::max(bottom - kUsualHead, 0.0);
      plot(bottom);
    } else {
      text("nodata muted", width_ / 2, (top + height_) / 2, "middle", "no data");
    }
    return fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"smc\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
        "role=\"img\" aria-label=\"{2}\">\n{3}<rect class=\"page\" width=\"{0}\" height=\"{1}\" "
        "rx=\"6\"/>\n{4}</svg>\n",
        width_, height_, escapeXml(chart_.title), style(), out_);
  }

 private:
  void text(const char* kind, double x, double y, const char* anchor, const std::string& words, double turned = 0) {
    const std::string turn =
        turned == 0 ? "" : fmt::format(" transform=\"rotate({} {} {})\"", turned, svgNumber(x), svgNumber(y));
    out_ += fmt::format("<text class=\"{}\" x=\"{}\" y=\"{}\" text-anchor=\"{}\"{}>{}</text>\n", kind, svgNumber(x),
                        svgNumber(y), anchor, turn, escapeXml(words));
  }
  void path(const std::string& kind, const std::string& d) {
    out_ += fmt::format("<path class=\"{}\" d=\"{}\"/>\n", kind, d);
  }
  void line(const char* kind, double x0, double y0, double x1, double y1) {
    path(kind, fmt::format("M{},{}L{},{}", svgNumber(x0), svgNumber(y0), svgNumber(x1), svgNumber(y1)));
  }
  void rect(const std::string& kind, const ChartBox& b, const std::string& fill = "", const std::string& detail = "") {
    out_ += fmt::format("<rect class=\"{}\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"{}>{}</rect>\n", kind,
                        svgNumber(b.left), svgNumber(b.top), svgNumber(b.right - b.left), svgNumber(b.bottom - b.top),
                        fill.empty() ? "" : fmt::format(" style=\"fill:{}\"", escapeXml(fill)),
                        detail.empty() ? "" : "<title>" + escapeXml(detail) + "</title>");
  }
  void mark(const ChartSeries& s, const Vec2d& p, double radius, const std::string& detail = "") {
    out_ += fmt::format("<path class=\"mark f{}\" transform=\"translate({},{}) scale({})\" d=\"{}\">{}</path>\n",
                        s.color % kChartColors, svgNumber(p.x), svgNumber(p.y), radius, kShapes[s.color % kChartColors],
                        detail.empty() ? "" : "<title>" + escapeXml(detail) + "</title>");
  }
  static std::string at(const std::vector<std::string>& texts, std::size_t i) {
    return i < texts.size() ? texts[i] : "";
  }
  std::string cssClasses(const char* kind, const ChartSeries& s) const {
    return fmt::format("{} s{}{}{}", kind, s.color % kChartColors, s.emphasised ? " wide" : "",
                       emphasised_ && !s.emphasised ? " dim" : "");
  }

  // Draws the legend, in which series of the same name and colour share an entry. `top`: y of its upper end. Returns
  // the y of its lower end (pixels).
  double legend(double top) {
    double x = kMargin, y = top + kFont;
    std::vector<const ChartSeries*> named;
    for (const ChartSeries& s : chart_.series) {
      const auto same = [&](const ChartSeries* o) { return o->name == s.name && o->color == s.color; };
      if (s.name.empty() || std::ranges::none_of(s.points, isDrawn) || std::ranges::any_of(named, same)) continue;
      named.push_back(&s);
      const double width = kSwatch + svgTextWidth(s.name, kFont);
      if (x > kMargin && x + width > width_ - kMargin) x = kMargin, y += kFont * 1.6;
      out_ += "<g class=\"legend\">";
      for (const ChartSeries& o : chart_.series) {
        if (same(&o)) swatch(o, x, y - kFont * 0.35);
      }
      text("entry", x + kSwatch, y, "start", s.name);
      out_ += "</g>\n";
      x += width + 18;
    }
    return named.empty() ? top : y + 12;
  }

  // Draws the mark, line or bar of a series in the legend. `x`: its left end. `y`: its middle.
  void swatch(const ChartSeries& s, double x, double y) {
    if (hasLine(s)) {
      path(fmt::format("line s{}", s.color % kChartColors), fmt::format("M{},{}h26", svgNumber(x), svgNumber(y)));
    }
    if (hasDots(s)) mark(s, {x + 13, y}, kMarkRadius);
    if (s.mark == ChartMark::Bars) {
      rect(fmt::format("f{}", s.color % kChartColors), {x + 8, y - 5.5, x + 19, y + 5.5}, at(s.fills, 0));
    }
  }

  // Adds the values that lie on the axes to `xs` and `ys`.
  void addValues(std::vector<double>& xs, std::vector<double>& ys) const {
    std::vector<double>& barEnds = horizontal_ ? xs : ys;
    std::map<double, double> sums;  // for each name, the sum of its stacked bars
    bool labels = false;            // true: at least one bar has a label
    for (const ChartSeries& s : chart_.series) {
      labels = labels || (s.mark == ChartMark::Bars && !s.labels.empty());
      for (std::size_t i = 0; i < s.points.size(); ++i) {
        if (!isDrawn(s.points[i])) continue;
        xs.push_back(s.points[i].x);
        ys.push_back(s.points[i].y);
        const auto [name, value] = swapped(s.points[i]);
        if (chart_.stacked) barEnds.push_back(sums[name] += value);
        if (i < s.spans.size() && isDrawn(s.spans[i])) ys.insert(ys.end(), {s.spans[i].x, s.spans[i].y});
      }
    }
    constexpr double kLabelRoom = 1.12;  // the axis reaches so far beyond bars with labels
    if (!labels || valueAxis().scale != AxisScale::Linear) return;
    barEnds.push_back(kLabelRoom * *std::ranges::max_element(barEnds));
  }

  // Draws the axes and the series below the y `top` (pixels).
  void plot(double top) {
    std::vector<double> xs, ys;
    addValues(xs, ys);
    const bool bars = std::ranges::count(chart_.series, ChartMark::Bars, &ChartSeries::mark) > 0;
    area_ = {kMargin, top, width_ - kMargin - 8, height_ - kMargin - kFont * 3.4};
    if (!chart_.y.title.empty()) {
      text("axistitle muted", kMargin, area_.top + kNoteFont, "start", chart_.y.title);
      area_.top += kNoteFont * 1.9;
    }
    double widestName = 0;
    for (const std::string& name : chart_.x.names) widestName = std::max(widestName, tickWidth(name));
    const bool turned = widestName * static_cast<double>(chart_.x.names.size()) * 1.1 > area_.right - area_.left - 60;
    if (turned) area_.bottom -= widestName * std::sin(radians(kNameAngle));
    const ChartScale y(chart_.y, ys, bars && !horizontal_, (area_.bottom - area_.top) / (kFont * 2.8));
    double widestTick = 0;
    for (const ChartScale::Tick& t : y.ticks()) widestTick = std::max(widestTick, tickWidth(t.text));
    area_.left += widestTick + 9;
    const ChartScale x(chart_.x, xs, bars && horizontal_, (area_.right - area_.left) / (kFont * 5));
    x_ = &x, y_ = &y;
    axes(turned);
    series();
  }

  // Draws the axes with their labels. `turned`: names on the x axis are rotated.
  void axes(bool turned) {
    constexpr double kBand = ChartScale::kBand;
    if (x_->hasBand()) rect("band", {area_.left, area_.top, xAt(kBand), area_.bottom});
    const double bandTop = area_.bottom - kBand * (area_.bottom - area_.top);
    if (y_->hasBand()) rect("band", {area_.left, bandTop, area_.right, area_.bottom});
    for (const ChartScale::Tick& t : y_->ticks()) {
      const double y = yAt(t.position);
      line("grid", area_.left, y, area_.right, y);
      text("tick", area_.left - 8, y + kFont * 0.35, "end", tickText(t.text));
    }
    for (const ChartScale::Tick& t : x_->ticks()) {
      const double x = xAt(t.position);
      if (chart_.x.names.empty()) line("grid", x, area_.top, x, area_.bottom);
      text("tick", x, area_.bottom + 6 + kFont, turned ? "end" : "middle", tickText(t.text), turned ? -kNameAngle : 0);
    }
    line("axis", area_.left, area_.bottom, area_.right, area_.bottom);
    line("axis", area_.left, area_.top, area_.left, area_.bottom);
    text("axistitle muted", (area_.left + area_.right) / 2, height_ - kMargin * 0.6, "middle", chart_.x.title);
  }

  std::string tickText(const std::string& name) const { return shortened(name, width_ < 700 ? 30 : 40); }
  double tickWidth(const std::string& name) const { return svgTextWidth(tickText(name), kFont); }

  // Return pixels of positions along the axes, from 0 to 1. If the y axis has names, the first is at the top.
  double xAt(double position) const { return area_.left + position * (area_.right - area_.left); }
  double yAt(double position) const {
    const double down = position * (area_.bottom - area_.top);
    return horizontal_ ? area_.top + down : area_.bottom - down;
  }
  Vec2d pixel(const Vec2d& p) const { return {xAt(x_->at(p.x)), yAt(y_->at(p.y))}; }

  // Exchanges x and y if bars are horizontal: returns {name, value} for a point of a bar, and the point for these.
  Vec2d swapped(const Vec2d& p) const { return horizontal_ ? Vec2d{p.y, p.x} : p; }
  const ChartAxis& valueAxis() const { return horizontal_ ? chart_.x : chart_.y; }

  void series() {
    const auto withBars = std::ranges::count(chart_.series, ChartMark::Bars, &ChartSeries::mark);
    int before = 0;  // number of series whose bars are drawn
    for (const ChartSeries& s : chart_.series) {
      if (s.mark == ChartMark::Bars) chart_.stacked ? bars(s, 0, 1) : bars(s, before++, static_cast<int>(withBars));
    }
    for (const ChartSeries* s : sortedBy(&ChartSeries::emphasised)) spansAndLine(*s);
    for (const ChartSeries* s : sortedBy(&ChartSeries::emphasised)) marks(*s);
    const auto rank = [](const ChartSeries& s) { return s.labelsFirst ? 0 : s.emphasised ? 1 : 2; };
    for (const ChartSeries* s : sortedBy(rank)) {
      if (s->mark != ChartMark::Bars) labels(*s);
    }
  }

  // Returns the series, those of least rank first; series of the same rank keep their order.
  std::vector<const ChartSeries*> sortedBy(const auto& rank) const {
    std::vector<const ChartSeries*> sorted;
    for (const ChartSeries& s : chart_.series) sorted.push_back(&s);
    std::ranges::stable_sort(sorted, {}, [&](const ChartSeries* s) { return std::invoke(rank, *s); });
    return sorted;
  }

  void marks(const ChartSeries& s) {
    const double radius = radiusOf(s), reach = radius * kMarkReach;
    for (std::size_t i = 0; i < s.points.size() && hasDots(s); ++i) {
      if (!isDrawn(s.points[i])) continue;
      const Vec2d p = pixel(s.points[i]);
      mark(s, p, radius, at(s.details, i));
      occupied_.push_back({p.x - reach, p.y - reach, p.x + reach, p.y + reach});
    }
  }

  // Draws the bars of a series, which are horizontal if the y axis has names. `slot`: index of the series among the
  // `slots` bars that are side by side at each name.
  void bars(const ChartSeries& s, int slot, int slots) {
    const Vec2d first = pixel({0, 0}), second = pixel({1, 1});
    const double betweenNames = std::abs(swapped(second).x - swapped(first).x);
    const double thick = std::min(betweenNames * kBarShare / slots, kThickestBar);
    const double offset = (slot - slots / 2.0) * thick;
    const bool log = valueAxis().scale == AxisScale::Log;
    for (std::size_t i = 0; i < s.points.size(); ++i) {
      if (!isDrawn(s.points[i])) continue;
      const auto [name, value] = swapped(s.points[i]);
      const double from = chart_.stacked ? stacked_[name] : 0;
      stacked_[name] += value;
      const Vec2d start = pixel(swapped({name, from})), end = pixel(swapped({name, from + value}));
      const double near = swapped(end).x + offset, far = near + thick - (slots > 1 ? 1 : 0);
      const ChartBox box = horizontal_ ? ChartBox{log ? area_.left : start.x, near, end.x, far}
                                       : ChartBox{near, end.y, far, log ? area_.bottom : start.y};
      rect(fmt::format("bar f{}", s.color % kChartColors), box, at(s.fills, i), at(s.details, i));
      const std::string label = at(s.labels, i);
      const double half = svgTextWidth(label, kFont) / 2;
      const ChartBox around = horizontal_ ? ChartBox{end.x + 4, near, end.x + 4 + 2 * half, far}
                                          : ChartBox{end.x - half, end.y - kFont * 1.2, end.x + half, end.y - 2};
      if (label.empty() || around.right > width_ || overlapsAny(occupied_, around)) continue;
      occupied_.push_back(around);
      text("label", around.left, horizontal_ ? (near + far) / 2 + kFont * 0.35 : around.bottom - 2, "start", label);
    }
  }

  void spansAndLine(const ChartSeries& s) {
    for (std::size_t i = 0; i < std::min(s.spans.size(), s.points.size()); ++i) {
      if (!isDrawn(s.points[i]) || !isDrawn(s.spans[i])) continue;
      const Vec2d low = pixel({s.points[i].x, s.spans[i].x}), high = pixel({s.points[i].x, s.spans[i].y});
      path(cssClasses("span", s),
           fmt::format("M{0},{1}V{2}M{3},{1}H{4}M{3},{2}H{4}", svgNumber(low.x), svgNumber(low.y), svgNumber(high.y),
                       svgNumber(low.x - 4), svgNumber(low.x + 4)));
    }
    if (!hasLine(s)) return;
    std::string d;      // SVG path
    bool open = false;  // true: the point before is drawn
    Vec2d before;
    for (const Vec2d& point : s.points) {
      if (isDrawn(point)) {
        const Vec2d p = pixel(point);
        // Labels avoid emphasised lines. These are staircases, so the box of each segment has no width or no height.
        if (open && s.emphasised) {
          lines_.push_back(
              {std::min(p.x, before.x), std::min(p.y, before.y), std::max(p.x, before.x), std::max(p.y, before.y)});
        }
        before = p;
        d += fmt::format("{}{},{}", open ? "L" : "M", svgNumber(p.x), svgNumber(p.y));
      }
      open = isDrawn(point);
    }
    if (!d.empty()) path(cssClasses("line", s), d);
  }

  // Draws labels in free space beside their points. If there is no free space near a point, its label is left out, or
  // drawn farther away if the series has labelsFirst or is emphasised.
  void labels(const ChartSeries& s) {
    for (std::size_t i = 0; i < std::min(s.labels.size(), s.points.size()); ++i) {
      if (s.labels[i].empty() || !isDrawn(s.points[i])) continue;
      if (!placeLabel(s, i, CoverLines::No)) placeLabel(s, i, CoverLines::Yes);
    }
  }

  enum class CoverLines { No, Yes };
  // Draws the label of a point in the nearest free space: inside of the plot, and not over marks, other labels or,
  // unless they may be covered, emphasised lines. Returns false if there is none.
  bool placeLabel(const ChartSeries& s, std::size_t i, CoverLines cover) {
    constexpr std::array<Vec2d, 8> kSides{{{1, 0}, {-1, 0}, {0, -1}, {0, 1}, {1, -1}, {1, 1}, {-1, -1}, {-1, 1}}};
    constexpr double kNear = 12;  // largest distance from the mark for most series (pixels)
    const Vec2d p = pixel(s.points[i]);
    const double half = svgTextWidth(s.labels[i], kFont, s.emphasised) / 2, halfHeight = kFont * 0.6;
    for (const double distance : {0.0, kNear, 26.0, 44.0, 70.0, 100.0, 140.0}) {
      if (distance > kNear && !s.labelsFirst && !s.emphasised) return false;
      for (const Vec2d& side : kSides) {
        const double off = radiusOf(s) * kMarkReach + 3 + distance;
        const Vec2d c{p.x + side.x * (off + half), p.y + side.y * (off + halfHeight)};
        const ChartBox box{c.x - half, c.y - halfHeight, c.x + half, c.y + halfHeight};
        const bool inside =
            box.left >= area_.left && box.right <= area_.right && box.top >= area_.top && box.bottom <= area_.bottom;
        if (!inside || overlapsAny(occupied_, box)) continue;
        if (cover == CoverLines::No && overlapsAny(lines_, box)) continue;
        occupied_.push_back(box);
        if (distance > 0) {
          line("axis", p.x, p.y, std::clamp(p.x, box.left, box.right), std::clamp(p.y, box.top, box.bottom));
        }
        text(s.emphasised ? "label strong" : "label", c.x, box.bottom - kFont * 0.3, "middle", s.labels[i]);
        return true;
      }
    }
    return false;
  }

  static double radiusOf(const ChartSeries& s) { return s.emphasised ? kEmphasisedRadius : kMarkRadius; }
  static bool overlapsAny(const std::vector<ChartBox>& boxes, const ChartBox& box) {
    return std::ranges::any_of(boxes, [&](const ChartBox& o) { return box.overlaps(o); });
  }

  const Chart& chart_;
  const bool horizontal_;  // true: the y axis has names, and bars are horizontal
  double width_, height_;
  bool emphasised_ = false;  // true: at least one series is emphasised
  ChartBox area_;            // rectangle of the plot, without title, legend and axis labels
  const ChartScale *x_ = nullptr, *y_ = nullptr;
  std::map<double, double> stacked_;  // for each name, the sum of the bars that have been drawn there
  std::vector<ChartBox> occupied_;    // boxes of marks and labels, which new labels must not overlap
  std::vector<ChartBox> lines_;       // boxes of emphasised lines, which labels avoid if there is room elsewhere
  std::string out_;
};

}  // namespace

bool hasPoints(const Chart& chart) {
  return std::ranges::any_of(chart.series, [](const ChartSeries& s) { return std::ranges::any_of(s.points, isDrawn); });
}

std::string drawSvg(const Chart& chart) {
  return SvgDrawing(chart).draw();
}

}  // namespace scanmill
