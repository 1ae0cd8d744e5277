// Draws charts as SVG with text elements as labels and without CSS variables, which only browsers support.

#include <fmt/core.h>

#include <functional>
#include <map>

#include "base/short_text.h"
#include "charts/chart.h"
#include "charts/svg_text.h"

namespace scanmill {

namespace {

// Margin around a chart, and font sizes (pixels). All sizes in this file are chosen by eye.
constexpr double kMargin = 16, kTitleFont = 15, kNoteFont = 12, kFont = 11.5;
constexpr double kTitleLine = 1.2, kNoteLine = 1.35;  // height of a line as a multiple of the font's size
constexpr double kBaseline = 0.35;  // distance from a text's middle down to its baseline, divided by the font's size
constexpr int kLeastWidth = 200, kLeastHeight = 160;          // least size of a chart (pixels)
constexpr double kMarkRadius = 4.5, kEmphasisedRadius = 6.5;  // radii of the marks of points (pixels)
constexpr double kMarkReach = 1.15;  // half the width of a typical shape in kShapes, divided by the mark's radius
constexpr double kBarShare = 0.76;   // width of all bars at one name, divided by the distance between two names
constexpr double kThickestBar = 26;  // largest thickness of a bar (pixels), since few bars would otherwise be very wide
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

// The palette of M. Okabe and K. Ito, Color Universal Design, 2008. Black is replaced by the ink colour. Yellow comes
// last, since it is hardly visible on a white page. On a dark page, both blues, vermilion and green are lighter.
using SeriesColors = std::array<const char*, kChartColors>;
constexpr SeriesColors kOnLight{"#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7", "#56B4E9", "#1f2328", "#F0E442"};
constexpr SeriesColors kOnDark{"#3D9BDC", "#E8762B", "#12B886", "#E69F00", "#CC79A7", "#7CC8F2", "#e6edf3", "#F0E442"};
// Colours as "#rrggbb". `band`: background of the values of zero and below on a logarithmic axis.
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

// Returns the CSS rules for the colours of a palette.
std::string colorRules(const ChartPalette& p) {
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

// Returns the SVG element with the styles of both colour schemes.
std::string style() {
  std::string css =
      ".smc text{font-family:Helvetica,Arial,'Liberation Sans',sans-serif;font-size:11.5px}"
      ".smc .title{font-size:15px;font-weight:600}.smc .note,.smc .axistitle{font-size:12px}"
      ".smc .strong{font-weight:600}.smc .line{fill:none;stroke-width:1.8}"
      ".smc .wide{stroke-width:2.4}.smc .dim{opacity:.6}.smc .mark{vector-effect:non-scaling-stroke}"
      ".smc .label{paint-order:stroke;stroke-width:2.5px;stroke-linejoin:round}";
  for (std::size_t i = 0; i < kChartColors; ++i) {
    if (*kDashes[i] != 0) css += fmt::format(".smc .line.s{}{{stroke-dasharray:{}}}", i, kDashes[i]);
  }
  return fmt::format("<style>{}{}@media (prefers-color-scheme:dark){{{}}}</style>\n", css, colorRules(kLight),
                     colorRules(kDark));
}

struct ChartBox {
  double left = 0, top = 0, right = 0, bottom = 0;  // pixels
  bool overlaps(const ChartBox& other) const {
    return left < other.right && other.left < right && top < other.bottom && other.top < bottom;
  }
};

bool overlapsAny(const std::vector<ChartBox>& boxes, const ChartBox& box) {
  return std::ranges::any_of(boxes, [&](const ChartBox& other) { return box.overlaps(other); });
}

// Returns the text with index `point`; empty if the series has no texts.
std::string textOf(const std::vector<std::string>& texts, std::size_t point) {
  return point < texts.size() ? texts[point] : "";
}

double radiusOf(const ChartSeries& s) {
  return s.emphasised ? kEmphasisedRadius : kMarkRadius;
}

bool isBars(const ChartSeries& s) {
  return s.mark == ChartMark::Bars;
}

constexpr double kRounding = 1e-9;  // tolerance for rounding errors of values that are at a tick

// Rounds `limit`, a logarithm to base 10, down to the logarithm of 1, 2 or 5 times a power of ten.
double roundLogDown(double limit) {
  const double decade = std::floor(limit + kRounding);
  double largest = decade;
  for (const double step : {std::log10(2), std::log10(5)}) {
    if (decade + step <= limit + kRounding) largest = decade + step;
  }
  return largest;
}

// Maps values to positions along an axis, from 0 at its start to 1 at its end. On a logarithmic axis, values of zero
// and below are in a band at its start.
class ChartScale {
 public:
  static constexpr double kBand = 0.1;  // length of the band for values of zero and below

  struct Tick {
    double position;
    std::string text;
  };

  // `values`: coordinates along the axis of all marks, bars and error bars. `includesZero`: the axis includes 0 (a
  // logarithmic axis: 1), since it shows bars. `labelRoom`: number of labels for which there is room.
  ChartScale(const ChartAxis& axis, const std::vector<double>& values, bool includesZero, double labelRoom)
      : log_(axis.scale == AxisScale::Log),
        hasBand_(log_ && std::ranges::any_of(values, [](double v) { return !(v > 0); })) {
    if (!axis.names.empty()) {
      // The name with index i covers the values from i - 0.5 to i + 0.5; the value i is in the middle.
      low_ = -0.5, high_ = static_cast<double>(axis.names.size()) - 0.5;
      for (const std::string& name : axis.names)
        ticks_.push_back({positionOf(static_cast<double>(ticks_.size())), name});
      return;
    }
    std::vector<double> mappedValues;
    for (const double v : values) {
      if (!log_ || v > 0) mappedValues.push_back(mapped(v));
    }
    if (includesZero || mappedValues.empty()) mappedValues.push_back(0);
    const auto [least, greatest] = std::ranges::minmax(mappedValues);
    low_ = least, high_ = greatest;
    widen(includesZero);
    const auto isOnScale = [&](const std::optional<double>& end) { return end && (!log_ || *end > 0); };
    if (isOnScale(axis.low) && mapped(*axis.low) <= least) low_ = mapped(*axis.low);
    if (isOnScale(axis.high) && mapped(*axis.high) >= greatest) high_ = mapped(*axis.high);
    if (hasBand_) ticks_.push_back({positionOf(0), axis.zero});
    labelRoom = std::max(labelRoom, 2.0);
    log_ ? addLogarithmicTicks(axis.unit, labelRoom) : addLinearTicks(axis.unit, labelRoom);
  }

  // Returns the position of a value.
  double positionOf(double value) const {
    if (log_ && value <= 0) return kBand / 2;
    const double fraction = (mapped(value) - low_) / (high_ - low_);  // 0 at `low_`, 1 at `high_`
    return hasBand_ ? kBand + (1 - kBand) * fraction : fraction;
  }
  bool hasBand() const { return hasBand_; }
  const std::vector<Tick>& ticks() const { return ticks_; }

 private:
  // Returns the value, or its logarithm to base 10 if the axis is logarithmic.
  double mapped(double value) const { return log_ ? std::log10(value) : value; }

  // Adds a margin to both ends of the axis; the low end of a linear axis without negative values stays at least 0.
  // Rounds the ends of a logarithmic axis to 1, 2 or 5 times powers of ten.
  void widen(bool includesZero) {
    constexpr double kEndMargin = 0.04;  // fraction of the axis's length
    if (!(high_ > low_)) {
      // If all values are equal, both ends move outwards by one decade (logarithmic), 10 % of the value or, for 0,
      // by 1.
      const double halfLength = log_ || low_ == 0 ? 1 : std::abs(low_) * 0.1;
      low_ -= halfLength, high_ += halfLength;
    }
    const double margin = kEndMargin * (high_ - low_);
    const bool staysPositive = !log_ && low_ >= 0;
    if (!(includesZero && low_ == 0)) low_ -= margin;
    high_ += margin;
    if (staysPositive) low_ = std::max(low_, 0.0);
    // Since 1, 2 and 5 are symmetric about the decade (1/5 = 2/10), -roundLogDown(-x) rounds x up.
    if (log_) low_ = roundLogDown(low_), high_ = -roundLogDown(-high_);
  }

  void addLinearTicks(const std::string& unit, double labelRoom) {
    const double step = niceStep((high_ - low_) / labelRoom);
    for (double i = std::ceil(low_ / step - kRounding) + 0.0; i * step <= high_ + step * kRounding; ++i) {
      ticks_.push_back({positionOf(i * step), axisNumber(i * step, unit)});
    }
  }

  // Adds ticks at 1, 2 and 5 times powers of ten or, if there is not enough room, only at every n-th power of ten.
  void addLogarithmicTicks(const std::string& unit, double labelRoom) {
    const double decades = high_ - low_;
    const int decadeStep = std::max(1, static_cast<int>(std::ceil(decades / labelRoom)));
    for (int decade = static_cast<int>(std::floor(low_)); decade <= high_ + kRounding; ++decade) {
      for (const int digit : {1, 2, 5}) {
        if (decade % decadeStep != 0 || (digit > 1 && 3 * decades > labelRoom)) continue;
        const double valueLog = decade + std::log10(digit);
        const double value = digit * std::pow(10, decade);
        if (valueLog >= low_ - kRounding && valueLog <= high_ + kRounding)
          ticks_.push_back({positionOf(value), axisNumber(value, unit)});
      }
    }
  }

  bool log_, hasBand_;
  double low_, high_;  // ends of the axis without the band: values, or their logarithms to base 10
  std::vector<Tick> ticks_;
};

// Writes the SVG elements of a chart to `out_`. Coordinates are pixels from the upper left corner, y downwards.
class SvgDrawing {
 public:
  explicit SvgDrawing(const Chart& chart)
      : chart_(chart),
        horizontal_(!chart.y.names.empty()),
        hasEmphasis_(std::ranges::any_of(chart.series, &ChartSeries::emphasised)),
        barSeries_(static_cast<int>(std::ranges::count_if(chart.series, isBars))),
        width_(std::max(chart.width, kLeastWidth)),
        height_(std::max(chart.height, kLeastHeight)) {}

  std::string draw() {
    double bottom = kMargin * 0.75;  // y of the lower end of all that is drawn so far
    const double textWidth = width_ - 2 * kMargin;
    for (const std::string& line : wrapSvgText(chart_.title, kTitleFont, textWidth, FontWeight::Bold)) {
      addText("title", kMargin, bottom += kTitleFont * kTitleLine, "start", line);
    }
    for (const std::string& line : wrapSvgText(chart_.note, kNoteFont, textWidth)) {
      addText("note muted", kMargin, bottom += kNoteFont * kNoteLine, "start", line);
    }
    if (hasPoints(chart_)) {
      constexpr double kUsualHead = 90;  // height of a title, a note and a legend of one line each (pixels)
      bottom = drawLegend(bottom + 8);
      height_ += std::max(bottom - kUsualHead, 0.0);
      drawPlot(bottom);
    } else {
      addText("nodata muted", width_ / 2, (bottom + height_) / 2, "middle", "no data");
    }
    return fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"smc\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
        "role=\"img\" aria-label=\"{2}\">\n{3}<rect class=\"page\" width=\"{0}\" height=\"{1}\" "
        "rx=\"6\"/>\n{4}</svg>\n",
        width_, height_, escapeXml(chart_.title), style(), out_);
  }

 private:
  // Adds a text whose baseline is at y; `anchor`: which end of the text is at x ("start", "middle" or "end").
  void addText(const char* cssClass, double x, double y, const char* anchor, const std::string& text,
               double rotationDegrees = 0) {
    const std::string transform = rotationDegrees == 0 ? ""
                                                       : fmt::format(" transform=\"rotate({} {} {})\"", rotationDegrees,
                                                                     svgNumber(x), svgNumber(y));
    out_ += fmt::format("<text class=\"{}\" x=\"{}\" y=\"{}\" text-anchor=\"{}\"{}>{}</text>\n", cssClass, svgNumber(x),
                        svgNumber(y), anchor, transform, escapeXml(text));
  }
  // Adds a path. `commands`: the path's attribute `d` in SVG.
  void addPath(const std::string& cssClass, const std::string& commands) {
    out_ += fmt::format("<path class=\"{}\" d=\"{}\"/>\n", cssClass, commands);
  }
  void addLine(const char* cssClass, double x0, double y0, double x1, double y1) {
    addPath(cssClass, fmt::format("M{},{}L{},{}", svgNumber(x0), svgNumber(y0), svgNumber(x1), svgNumber(y1)));
  }
  // Adds a rectangle; `fill`: "#rrggbb", replaces the colour of `cssClass`. `detail`: text of the tooltip.
  void addRect(const std::string& cssClass, const ChartBox& b, const std::string& fill = "",
               const std::string& detail = "") {
    out_ += fmt::format("<rect class=\"{}\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"{}>{}</rect>\n", cssClass,
                        svgNumber(b.left), svgNumber(b.top), svgNumber(b.right - b.left), svgNumber(b.bottom - b.top),
                        fill.empty() ? "" : fmt::format(" style=\"fill:{}\"", escapeXml(fill)),
                        detail.empty() ? "" : "<title>" + escapeXml(detail) + "</title>");
  }
  void addMark(const ChartSeries& s, const Vec2d& center, double radius, const std::string& detail = "") {
    const std::size_t color = s.color % kChartColors;
    out_ += fmt::format("<path class=\"mark f{}\" transform=\"translate({},{}) scale({})\" d=\"{}\">{}</path>\n", color,
                        svgNumber(center.x), svgNumber(center.y), radius, kShapes[color],
                        detail.empty() ? "" : "<title>" + escapeXml(detail) + "</title>");
  }
  std::string cssClasses(const char* kind, const ChartSeries& s) const {
    return fmt::format("{} s{}{}{}", kind, s.color % kChartColors, s.emphasised ? " wide" : "",
                       hasEmphasis_ && !s.emphasised ? " dim" : "");
  }

  // Draws the legend below y `top`; returns y of its lower edge. Series with equal name and colour share one entry.
  double drawLegend(double top) {
    constexpr double kBetweenEntries = 18;  // pixels
    double x = kMargin, y = top + kFont;
    std::vector<const ChartSeries*> entries;
    for (const ChartSeries& s : chart_.series) {
      const auto sharesEntry = [&](const ChartSeries* other) {
        return other->name == s.name && other->color == s.color;
      };
      if (s.name.empty() || std::ranges::none_of(s.points, isDrawn) || std::ranges::any_of(entries, sharesEntry)) {
        continue;
      }
      entries.push_back(&s);
      const double width = kSwatch + svgTextWidth(s.name, kFont);
      if (x > kMargin && x + width > width_ - kMargin) x = kMargin, y += kFont * 1.6;
      out_ += "<g class=\"legend\">";
      for (const ChartSeries& other : chart_.series) {
        if (sharesEntry(&other)) drawSwatch(other, x, y - kFont * kBaseline);
      }
      addText("entry", x + kSwatch, y, "start", s.name);
      out_ += "</g>\n";
      x += width + kBetweenEntries;
    }
    return entries.empty() ? top : y + 12;
  }

  // Draws the mark, line or bar of a series in the legend. `x`: left end of the drawing. `y`: middle of its height.
  void drawSwatch(const ChartSeries& s, double x, double y) {
    constexpr double kLength = 26, kBarIndent = 8, kBarSide = 11;  // pixels; a bar is shown as a square
    const std::size_t color = s.color % kChartColors;
    if (hasLine(s)) {
      addPath(fmt::format("line s{}", color), fmt::format("M{},{}h{}", svgNumber(x), svgNumber(y), kLength));
    }
    if (hasDots(s)) addMark(s, {x + kLength / 2, y}, kMarkRadius);
    if (!isBars(s)) return;
    const ChartBox square{x + kBarIndent, y - kBarSide / 2, x + kBarIndent + kBarSide, y + kBarSide / 2};
    addRect(fmt::format("f{}", color), square, textOf(s.fills, 0));
  }

  // Adds the coordinates of all that is drawn in the plot to `xs` and `ys` (units of the axes): points, ends of error
  // bars and of stacked bars, and room for labels of bars.
  void addCoordinates(std::vector<double>& xs, std::vector<double>& ys) const {
    std::vector<double>& barEnds = horizontal_ ? xs : ys;
    std::map<double, double> sums;  // for each name, the sum of its stacked bars
    for (const ChartSeries& s : chart_.series) {
      for (const auto& point : s.points) {
        if (!isDrawn(point)) continue;
        xs.push_back(point.x);
        ys.push_back(point.y);
        const auto [name, value] = swapped(point);
        if (chart_.stacked) barEnds.push_back(sums[name] += value);
      }
    }
    constexpr double kLabelRoom = 1.12;  // length of the axis divided by the longest bar, if bars have labels
    const bool hasBarLabels =
        std::ranges::any_of(chart_.series, [](const ChartSeries& s) { return isBars(s) && !s.labels.empty(); });
    if (!hasBarLabels || valueAxis().scale != AxisScale::Linear) return;
    barEnds.push_back(kLabelRoom * *std::ranges::max_element(barEnds));
  }

  // Draws the axes and the series below the y `top`. Sets `area_`, `y_` and `x_`, which all functions below use. The y
  // axis is set first, because its labels determine the width that is left for the x axis.
  void drawPlot(double top) {
    std::vector<double> xs, ys;
    addCoordinates(xs, ys);
    constexpr double kRightMargin = 8,
                     kTickGap = 9;             // pixels; the gap is between the labels of the y axis and the axis
    constexpr double kFooter = 3.4;            // height of labels and title of the x axis, in sizes of the font
    constexpr double kTitleHeight = 1.9;       // height of the title of the y axis, in sizes of its font
    constexpr double kRow = 2.8, kColumn = 5;  // height of a label of y and width of a label of x, in sizes of the font
    constexpr double kNameGap = 1.1,
                     kYAxisWidth = 60;  // kNameGap: room for a name divided by its width; kYAxisWidth: in pixels
    area_ = {kMargin, top, width_ - kMargin - kRightMargin, height_ - kMargin - kFont * kFooter};
    if (!chart_.y.title.empty()) {
      addText("axistitle muted", kMargin, area_.top + kNoteFont, "start", chart_.y.title);
      area_.top += kNoteFont * kTitleHeight;
    }
    double widestName = 0;
    for (const std::string& name : chart_.x.names) widestName = std::max(widestName, tickWidth(name));
    const double namesWidth = widestName * static_cast<double>(chart_.x.names.size()) * kNameGap;
    const bool rotatesNames = namesWidth > area_.right - area_.left - kYAxisWidth;
    if (rotatesNames) area_.bottom -= widestName * std::sin(radians(kNameAngle));
    y_.emplace(chart_.y, ys, barSeries_ > 0 && !horizontal_, (area_.bottom - area_.top) / (kFont * kRow));
    double widestTick = 0;
    for (const ChartScale::Tick& tick : y_->ticks()) widestTick = std::max(widestTick, tickWidth(tick.text));
    area_.left += widestTick + kTickGap;
    x_.emplace(chart_.x, xs, barSeries_ > 0 && horizontal_, (area_.right - area_.left) / (kFont * kColumn));
    drawAxes(rotatesNames ? -kNameAngle : 0);
    drawSeries();
  }

  // Draws the axes with their labels. `rotationDegrees`: rotation of the labels of the x axis.
  void drawAxes(double rotationDegrees) {
    constexpr double kBand = ChartScale::kBand;
    if (x_->hasBand()) addRect("band", {area_.left, area_.top, xAt(kBand), area_.bottom});
    const double bandTop = area_.bottom - kBand * (area_.bottom - area_.top);
    if (y_->hasBand()) addRect("band", {area_.left, bandTop, area_.right, area_.bottom});
    for (const ChartScale::Tick& tick : y_->ticks()) {
      const double y = yAt(tick.position);
      addLine("grid", area_.left, y, area_.right, y);
      addText("tick", area_.left - 8, y + kFont * kBaseline, "end", tickText(tick.text));
    }
    for (const ChartScale::Tick& tick : x_->ticks()) {
      const double x = xAt(tick.position);
      if (chart_.x.names.empty()) addLine("grid", x, area_.top, x, area_.bottom);
      addText("tick", x, area_.bottom + 6 + kFont, rotationDegrees == 0 ? "middle" : "end", tickText(tick.text),
              rotationDegrees);
    }
    addLine("axis", area_.left, area_.bottom, area_.right, area_.bottom);
    addLine("axis", area_.left, area_.top, area_.left, area_.bottom);
    addText("axistitle muted", (area_.left + area_.right) / 2, height_ - kMargin * 0.6, "middle", chart_.x.title);
  }

  std::string tickText(const std::string& name) const { return shortened(name, width_ < 700 ? 30 : 40); }
  double tickWidth(const std::string& name) const { return svgTextWidth(tickText(name), kFont); }

  // Return the pixel of a position (0 to 1) along an axis. If the y axis has names, the first name is at the top.
  double xAt(double position) const { return area_.left + position * (area_.right - area_.left); }
  double yAt(double position) const {
    const double distance = position * (area_.bottom - area_.top);
    return horizontal_ ? area_.top + distance : area_.bottom - distance;
  }
  Vec2d pixel(const Vec2d& point) const { return {xAt(x_->positionOf(point.x)), yAt(y_->positionOf(point.y))}; }

  // Exchanges x and y if bars are horizontal: this converts a point of a bar to {name, value} and back.
  Vec2d swapped(const Vec2d& p) const { return horizontal_ ? Vec2d{p.y, p.x} : p; }
  const ChartAxis& valueAxis() const { return horizontal_ ? chart_.x : chart_.y; }

  // Draws bars, then lines, marks and labels on top. Emphasised lines and marks are above others. Labels of series with
  // labelsFirst are placed first, then labels of emphasised series.
  void drawSeries() {
    int slot = 0;  // index of the series among those with bars
    for (const ChartSeries& s : chart_.series) {
      if (isBars(s)) chart_.stacked ? drawBars(s, 0, 1) : drawBars(s, slot++, barSeries_);
    }
    for (const ChartSeries* s : sortedBy(&ChartSeries::emphasised)) {
      if (hasLine(*s)) drawLine(*s);
    }
    for (const ChartSeries* s : sortedBy(&ChartSeries::emphasised)) {
      if (hasDots(*s)) drawMarks(*s);
    }
    const auto labelRank = [](const ChartSeries& s) { return s.labelsFirst ? 0 : s.emphasised ? 1 : 2; };
    for (const ChartSeries* s : sortedBy(labelRank)) {
      if (!isBars(*s)) drawLabels(*s);
    }
  }

  // Returns the series in ascending order of `rank`; series of the same rank keep their order.
  std::vector<const ChartSeries*> sortedBy(const auto& rank) const {
    std::vector<const ChartSeries*> sorted;
    for (const ChartSeries& s : chart_.series) sorted.push_back(&s);
    std::ranges::stable_sort(sorted, {}, [&](const ChartSeries* s) { return std::invoke(rank, *s); });
    return sorted;
  }

  void drawMarks(const ChartSeries& s) {
    const double radius = radiusOf(s), reach = radius * kMarkReach;
    for (std::size_t i = 0; i < s.points.size(); ++i) {
      if (!isDrawn(s.points[i])) continue;
      const Vec2d center = pixel(s.points[i]);
      addMark(s, center, radius, textOf(s.details, i));
      occupied_.push_back({center.x - reach, center.y - reach, center.x + reach, center.y + reach});
    }
  }

  // Draws the bars of a series, which are horizontal if the y axis has names. Each name has `slots` bars side by side;
  // `slot` is the index of this series' bar.
  void drawBars(const ChartSeries& s, int slot, int slots) {
    const double nameDistance = std::abs(swapped(pixel({1, 1})).x - swapped(pixel({0, 0})).x);
    const double thickness = std::min(nameDistance * kBarShare / slots, kThickestBar);
    const double offset = (slot - slots / 2.0) * thickness;  // distance from the name's position to the first side
    const double gap = slots > 1 ? 1 : 0;
    for (std::size_t i = 0; i < s.points.size(); ++i) {
      if (!isDrawn(s.points[i])) continue;
      const auto [name, value] = swapped(s.points[i]);
      const double startValue = chart_.stacked ? stacked_[name] : 0;
      stacked_[name] += value;
      Vec2d start = pixel(swapped({name, startValue}));
      const Vec2d end = pixel(swapped({name, startValue + value}));
      // A logarithmic axis has no 0: its bars begin at the edge of the plot.
      if (valueAxis().scale == AxisScale::Log) start = {area_.left, area_.bottom};
      const double side = swapped(end).x + offset, otherSide = side + thickness - gap;
      const ChartBox bar =
          horizontal_ ? ChartBox{start.x, side, end.x, otherSide} : ChartBox{side, end.y, otherSide, start.y};
      addRect(fmt::format("bar f{}", s.color % kChartColors), bar, textOf(s.fills, i), textOf(s.details, i));
      drawBarLabel(textOf(s.labels, i), bar, end);
    }
  }

  // Draws the label of a bar at its end, unless the label would overlap another label or leave the picture. `end`:
  // pixel at the bar's end, at the position of the bar's name.
  void drawBarLabel(const std::string& label, const ChartBox& bar, const Vec2d& end) {
    const double halfWidth = svgTextWidth(label, kFont) / 2;
    const ChartBox box = horizontal_ ? ChartBox{end.x + 4, bar.top, end.x + 4 + 2 * halfWidth, bar.bottom}
                                     : ChartBox{end.x - halfWidth, end.y - kFont * 1.2, end.x + halfWidth, end.y - 2};
    if (label.empty() || box.right > width_ || overlapsAny(occupied_, box)) return;
    occupied_.push_back(box);
    addText("label", box.left, horizontal_ ? (bar.top + bar.bottom) / 2 + kFont * kBaseline : box.bottom - 2, "start",
            label);
  }

  // Draws the line of a series, interrupted at points that are not finite. Records the segments of emphasised lines as
  // boxes, which labels avoid. Emphasised lines are staircases, so the boxes have no width or no height.
  void drawLine(const ChartSeries& s) {
    std::string commands;
    Vec2d previous;  // pixel of the previous point
    bool isPreviousDrawn = false;
    for (const Vec2d& point : s.points) {
      const bool continues = isPreviousDrawn;
      isPreviousDrawn = isDrawn(point);
      if (!isPreviousDrawn) continue;
      const Vec2d p = pixel(point);
      if (continues && s.emphasised) {
        lines_.push_back({std::min(p.x, previous.x), std::min(p.y, previous.y), std::max(p.x, previous.x),
                          std::max(p.y, previous.y)});
      }
      commands += fmt::format("{}{},{}", continues ? "L" : "M", svgNumber(p.x), svgNumber(p.y));
      previous = p;
    }
    if (!commands.empty()) addPath(cssClasses("line", s), commands);
  }

  // Draws labels in free space beside their points. If there is no free space near a point, its label is left out, or
  // drawn farther away if the series has labelsFirst or is emphasised.
  void drawLabels(const ChartSeries& s) {
    for (std::size_t i = 0; i < std::min(s.labels.size(), s.points.size()); ++i) {
      if (s.labels[i].empty() || !isDrawn(s.points[i])) continue;
      if (!placeLabel(s, i, CoverLines::No)) placeLabel(s, i, CoverLines::Yes);
    }
  }

  enum class CoverLines { No, Yes };
  // Draws the label of a point in the nearest free space: inside the plot, not over marks and other labels and, with
  // CoverLines::No, not over emphasised lines. Returns false if there is no free space.
  bool placeLabel(const ChartSeries& s, std::size_t point, CoverLines cover) {
    constexpr std::array<Vec2d, 8> kDirections{{{1, 0}, {-1, 0}, {0, -1}, {0, 1}, {1, -1}, {1, 1}, {-1, -1}, {-1, 1}}};
    // Distances (pixels) between the mark and the label that are tried; most series use only those up to kNear.
    constexpr double kNear = 12;
    constexpr std::array kDistances{0.0, kNear, 26.0, 44.0, 70.0, 100.0, 140.0};
    const Vec2d mark = pixel(s.points[point]);
    const FontWeight weight = s.emphasised ? FontWeight::Bold : FontWeight::Normal;
    const double halfWidth = svgTextWidth(s.labels[point], kFont, weight) / 2, halfHeight = kFont * 0.6;
    for (const double distance : kDistances) {
      if (distance > kNear && !s.labelsFirst && !s.emphasised) return false;
      const double reach = radiusOf(s) * kMarkReach + 3 + distance;
      for (const Vec2d& direction : kDirections) {
        const Vec2d c{mark.x + direction.x * (reach + halfWidth), mark.y + direction.y * (reach + halfHeight)};
        const ChartBox box{c.x - halfWidth, c.y - halfHeight, c.x + halfWidth, c.y + halfHeight};
        const bool inside =
            box.left >= area_.left && box.right <= area_.right && box.top >= area_.top && box.bottom <= area_.bottom;
        if (!inside || overlapsAny(occupied_, box)) continue;
        if (cover == CoverLines::No && overlapsAny(lines_, box)) continue;
        occupied_.push_back(box);
        if (distance > 0) {
          addLine("axis", mark.x, mark.y, std::clamp(mark.x, box.left, box.right),
                  std::clamp(mark.y, box.top, box.bottom));
        }
        addText(s.emphasised ? "label strong" : "label", c.x, box.bottom - kFont * 0.3, "middle", s.labels[point]);
        return true;
      }
    }
    return false;
  }

  const Chart& chart_;
  const bool horizontal_;   // true: the y axis has names, and bars are horizontal
  const bool hasEmphasis_;  // true: at least one series is emphasised
  const int barSeries_;     // number of series that are drawn as bars
  double width_, height_;
  ChartBox area_;  // rectangle of the plot, without title, legend and axis labels
  std::optional<ChartScale> x_, y_;
  std::map<double, double> stacked_;  // for each name, the sum of the bars that have been drawn at the name
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
