// Draws charts as SVG files. Labels are text elements. The styles do not use CSS variables, which only browsers
// support.

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "charts/chart.h"
#include "charts/svg_text.h"

namespace scanmill {

namespace {

// Margin around a chart, and sizes of the chart's fonts (pixels).
constexpr double kMargin = 16, kTitleFont = 15, kNoteFont = 12, kFont = 11.5;
constexpr double kBand = 0.1;  // fraction of a logarithmic axis that shows values of zero and below

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
      ".smc text{font-family:Helvetica,Arial,'Liberation Sans',sans-serif;font-size:11.5px}.smc .title{font-size:15px;"
      "font-weight:600}.smc .note,.smc .axistitle{font-size:12px}.smc .strong{font-weight:600}.smc .line,.smc "
      ".span{fill:"
      "none;stroke-width:1.8}.smc .wide{stroke-width:2.4}.smc .dim{opacity:.6}.smc "
      ".mark{vector-effect:non-scaling-stroke}"
      ".smc .label{paint-order:stroke;stroke-width:2.5px;stroke-linejoin:round}";
  for (std::size_t i = 0; i < kChartColors; ++i) {
    if (*kDashes[i] != 0) css += fmt::format(".smc .line.s{}{{stroke-dasharray:{}}}", i, kDashes[i]);
  }
  return fmt::format("<style>{}{}@media (prefers-color-scheme:dark){{{}}}</style>\n", css, rules(kLight), rules(kDark));
}

std::string plain(double value) {
  std::string text = fmt::format("{:.6g}", value);
  if (const std::size_t e = text.find("e-0"); e != std::string::npos) text.erase(e + 2, 1);
  return text;
}

// Returns the logarithm of the largest number that equals 1, 2 or 5 times a power of ten and whose logarithm is at most
// `log`.
double niceLog(double log) {
  double nice = std::floor(log + 1e-9);
  for (const double stop : {std::log10(2), std::log10(5)}) {
    if (std::floor(log + 1e-9) + stop <= log + 1e-9) nice = std::floor(log + 1e-9) + stop;
  }
  return nice;
}

// Maps values to positions along an axis, from 0 at its start to 1 at its end.
class ChartScale {
 public:
  struct Tick {
    double place;
    std::string text;
  };

  ChartScale(const ChartAxis& axis, const std::vector<double>& values, bool fromZero, double most) {
    log_ = axis.scale == AxisScale::Log;
    const auto mapped = [&](double v) { return log_ ? std::log10(v) : v; };
    std::vector<double> held;
    for (const double v : values) {
      if (!log_ || v > 0) held.push_back(mapped(v));
    }
    band_ = held.size() < values.size();
    if (!axis.names.empty()) held = {-0.5, static_cast<double>(axis.names.size()) - 0.5};
    if (fromZero) held.push_back(0);
    if (held.empty()) held.push_back(0);
    const auto [least, greatest] = std::minmax_element(held.begin(), held.end());
    const double dataLow = *least, dataHigh = *greatest;
    low_ = dataLow, high_ = dataHigh;
    if (axis.names.empty()) {
      widen(fromZero);
      if (axis.low && (!log_ || *axis.low > 0) && mapped(*axis.low) <= dataLow) low_ = mapped(*axis.low);
      if (axis.high && (!log_ || *axis.high > 0) && mapped(*axis.high) >= dataHigh) high_ = mapped(*axis.high);
    }
    if (band_) ticks.push_back({at(0), axis.zero});
    for (std::size_t i = 0; i < axis.names.size(); ++i) ticks.push_back({at(static_cast<double>(i)), axis.names[i]});
    if (axis.names.empty()) addTicks(axis.unit, std::max(most, 2.0));
  }

  double at(double value) const {
    if (log_ && value <= 0) return kBand / 2;
    const double share = ((log_ ? std::log10(value) : value) - low_) / (high_ - low_);
    return band_ ? kBand + (1 - kBand) * share : share;
  }
  bool hasBand() const { return band_; }

  std::vector<Tick> ticks;

 private:
  void widen(bool fromZero) {
    constexpr double kPad = 0.04;
    if (!(high_ > low_)) {
      const double half = log_ || low_ == 0 ? 1 : std::abs(low_) * 0.1;
      low_ -= half, high_ += half;
    }
    const double pad = kPad * (high_ - low_);
    const bool positive = !log_ && low_ >= 0;
    if (!(fromZero && low_ == 0)) low_ -= pad;
    high_ += pad;
    if (positive) low_ = std::max(low_, 0.0);
    if (log_) low_ = niceLog(low_), high_ = -niceLog(-high_);
  }

  void addTicks(const std::string& unit, double most) {
    if (!log_) {
      const double step = niceStep((high_ - low_) / most);
      for (double i = std::ceil(low_ / step - 1e-9) + 0.0; i * step <= high_ + step * 1e-9; ++i) {
        ticks.push_back({at(i * step), axisNumber(i * step, unit)});
      }
      return;
    }
    const int stride = std::max(1, static_cast<int>(std::ceil((high_ - low_) / most)));
    for (int decade = static_cast<int>(std::floor(low_)); decade <= high_ + 1e-9; ++decade) {
      for (const int digit : {1, 2, 5}) {
        const double place = decade + std::log10(digit);
        if (decade % stride != 0 || (digit > 1 && 3 * (high_ - low_) > most)) continue;
        const double value = digit * std::pow(10, decade);
        if (place >= low_ - 1e-9 && place <= high_ + 1e-9) ticks.push_back({at(value), axisNumber(value, unit)});
      }
    }
  }

  bool log_ = false, band_ = false;
  double low_ = 0, high_ = 1;
};

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
        lying_(!chart.y.names.empty()),
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
  std::string kindOf(const char* kind, const ChartSeries& s) const {
    return fmt::format("{} s{}{}{}", kind, s.color % kChartColors, s.emphasised ? " wide" : "",
                       emphasised_ && !s.emphasised ? " dim" : "");
  }

  // Draws the legend, in which series of the same name and colour share an entry. `top`: y of its upper end. Returns
  // the y of its lower end (pixels).
  double legend(double top) {
    double x = kMargin, y = top + kFont;
    std::vector<const ChartSeries*> done;
    for (const ChartSeries& s : chart_.series) {
      const auto same = [&](const ChartSeries& o) { return o.name == s.name && o.color == s.color; };
      if (s.name.empty() || std::ranges::none_of(s.points, isDrawn)) continue;
      if (std::ranges::any_of(done, [&](const ChartSeries* o) { return same(*o); })) continue;
      done.push_back(&s);
      const double wide = 32 + svgTextWidth(s.name, kFont);
      if (x > kMargin && x + wide > width_ - kMargin) x = kMargin, y += kFont * 1.6;
      out_ += "<g class=\"legend\">";
      const double middle = y - kFont * 0.35;
      for (const ChartSeries& o : chart_.series) {
        if (!same(o)) continue;
        if (o.mark == ChartMark::Line || o.mark == ChartMark::LineAndDots) {
          path("line s" + std::to_string(o.color % kChartColors),
               fmt::format("M{},{}h26", svgNumber(x), svgNumber(middle)));
        }
        if (o.mark == ChartMark::Dots || o.mark == ChartMark::LineAndDots) mark(o, {x + 13, middle}, 4.5);
        if (o.mark == ChartMark::Bars) {
          rect(fmt::format("f{}", o.color % kChartColors), {x + 8, middle - 5.5, x + 19, middle + 5.5}, at(o.fills, 0));
        }
      }
      text("entry", x + 32, y, "start", s.name);
      out_ += "</g>\n";
      x += wide + 18;
    }
    return done.empty() ? top : y + 12;
  }

  void plot(double top) {
    std::vector<double> xs, ys;
    std::vector<double>& values = lying_ ? xs : ys;
    std::map<double, double> ends;  // the sum of the stacked bars at each name
    bool bars = false, labels = false;
    for (const ChartSeries& s : chart_.series) {
      bars = bars || s.mark == ChartMark::Bars;
      labels = labels || (s.mark == ChartMark::Bars && !s.labels.empty());
      for (std::size_t i = 0; i < s.points.size(); ++i) {
        if (!isDrawn(s.points[i])) continue;
        xs.push_back(s.points[i].x);
        ys.push_back(s.points[i].y);
        const auto [name, value] =
            lying_ ? std::pair(s.points[i].y, s.points[i].x) : std::pair(s.points[i].x, s.points[i].y);
        if (chart_.stacked) values.push_back(ends[name] += value);
        if (i < s.spans.size() && isDrawn(s.spans[i])) ys.insert(ys.end(), {s.spans[i].x, s.spans[i].y});
      }
    }
    // Extends the axis, to leave space for the labels beyond the ends of bars.
    constexpr double kLabelRoom = 1.12;
    if (labels && (lying_ ? chart_.x : chart_.y).scale == AxisScale::Linear) {
      values.push_back(kLabelRoom * *std::ranges::max_element(values));
    }
    area_ = {kMargin, top, width_ - kMargin - 8, height_ - kMargin - kFont * 3.4};
    if (!chart_.y.title.empty()) {
      text("axistitle muted", kMargin, area_.top + kNoteFont, "start", chart_.y.title);
      area_.top += kNoteFont * 1.9;
    }
    // Angle (degrees) by which names are rotated if they are too long to fit side by side.
    constexpr double kTurned = 26;
    const auto nameText = [&](const std::string& name) { return shortened(name, width_ < 700 ? 30 : 40); };
    double widest = 0;
    for (const std::string& name : chart_.x.names) widest = std::max(widest, svgTextWidth(nameText(name), kFont));
    const bool turned = widest * static_cast<double>(chart_.x.names.size()) * 1.1 > area_.right - area_.left - 60;
    if (turned) area_.bottom -= widest * std::sin(kTurned * kPi / 180);
    const ChartScale y(chart_.y, ys, bars && !lying_, (area_.bottom - area_.top) / (kFont * 2.8));
    double left = 0;
    for (const ChartScale::Tick& t : y.ticks) left = std::max(left, svgTextWidth(nameText(t.text), kFont));
    area_.left += left + 9;
    const ChartScale x(chart_.x, xs, bars && lying_, (area_.right - area_.left) / (kFont * 5));
    x_ = &x, y_ = &y;
    const double bandRight = area_.left + kBand * (area_.right - area_.left);
    if (x.hasBand()) rect("band", {area_.left, area_.top, bandRight, area_.bottom});
    const double bandTop = area_.bottom - kBand * (area_.bottom - area_.top);
    if (y.hasBand()) rect("band", {area_.left, bandTop, area_.right, area_.bottom});
    for (const ChartScale::Tick& t : y.ticks) {
      const double at = heightAt(t.place);
      line("grid", area_.left, at, area_.right, at);
      text("tick", area_.left - 8, at + kFont * 0.35, "end", nameText(t.text));
    }
    for (const ChartScale::Tick& t : x.ticks) {
      const double at = area_.left + t.place * (area_.right - area_.left);
      if (chart_.x.names.empty()) line("grid", at, area_.top, at, area_.bottom);
      text("tick", at, area_.bottom + 6 + kFont, turned ? "end" : "middle", nameText(t.text), turned ? -kTurned : 0);
    }
    line("axis", area_.left, area_.bottom, area_.right, area_.bottom);
    line("axis", area_.left, area_.top, area_.left, area_.bottom);
    text("axistitle muted", (area_.left + area_.right) / 2, height_ - kMargin * 0.6, "middle", chart_.x.title);
    series();
  }

  // Returns the y (pixels) of a place on the y axis. The first of its names is at the top.
  double heightAt(double place) const {
    return lying_ ? area_.top + place * (area_.bottom - area_.top) : area_.bottom - place * (area_.bottom - area_.top);
  }
  Vec2d pixel(const Vec2d& p) const {
    return {area_.left + x_->at(p.x) * (area_.right - area_.left), heightAt(y_->at(p.y))};
  }

  void series() {
    std::size_t groups = 0, place = 0;
    for (const ChartSeries& s : chart_.series) groups += s.mark == ChartMark::Bars ? 1 : 0;
    for (const ChartSeries& s : chart_.series) {
      if (s.mark == ChartMark::Bars) bars(s, chart_.stacked ? 0 : place++, chart_.stacked ? 1 : groups);
    }
    for (const bool emphasised : {false, true}) {
      for (const ChartSeries& s : chart_.series) {
        if (s.emphasised == emphasised) spansAndLine(s);
      }
    }
    for (const bool emphasised : {false, true}) {
      for (const ChartSeries& s : chart_.series) {
        if (s.emphasised != emphasised || s.mark == ChartMark::Line || s.mark == ChartMark::Bars) continue;
        const double radius = s.emphasised ? 6.5 : 4.5, room = radius * 1.15;
        for (std::size_t i = 0; i < s.points.size(); ++i) {
          if (!isDrawn(s.points[i])) continue;
          const Vec2d p = pixel(s.points[i]);
          mark(s, p, radius, at(s.details, i));
          taken_.push_back({p.x - room, p.y - room, p.x + room, p.y + room});
        }
      }
    }
    // Place the labels of labelsFirst series first, then the labels of emphasised series, then all other labels.
    for (const int rank : {0, 1, 2}) {
      for (const ChartSeries& s : chart_.series) {
        if (s.mark != ChartMark::Bars && rank == (s.labelsFirst ? 0 : s.emphasised ? 1 : 2)) labels(s);
      }
    }
  }

  // Draws the bars of a series, which are horizontal if the y axis has names. `place`: index of the series among the
  // `groups` bars that are side by side at each name.
  void bars(const ChartSeries& s, std::size_t place, std::size_t groups) {
    const Vec2d step = pixel({1, 1}), before = pixel({0, 0});
    const bool log = (lying_ ? chart_.x : chart_.y).scale == AxisScale::Log;
    const double slot = std::abs(lying_ ? step.y - before.y : step.x - before.x) * 0.76;
    const double thick = std::min(slot / static_cast<double>(groups), 26.0);
    const double offset = (static_cast<double>(place) - static_cast<double>(groups) / 2) * thick;
    for (std::size_t i = 0; i < s.points.size(); ++i) {
      if (!isDrawn(s.points[i])) continue;
      const auto [value, name] = lying_ ? s.points[i] : Vec2d{s.points[i].y, s.points[i].x};
      const double from = chart_.stacked ? stacked_[name] : 0;
      stacked_[name] += value;
      const Vec2d start = pixel(lying_ ? Vec2d{from, name} : Vec2d{name, from});
      const Vec2d end = pixel(lying_ ? Vec2d{from + value, name} : Vec2d{name, from + value});
      const double side = (lying_ ? end.y : end.x) + offset, other = side + thick - (groups > 1 ? 1 : 0);
      const ChartBox box = lying_ ? ChartBox{log ? area_.left : start.x, side, end.x, other}
                                  : ChartBox{side, end.y, other, log ? area_.bottom : start.y};
      rect(fmt::format("bar f{}", s.color % kChartColors), box, at(s.fills, i), at(s.details, i));
      const std::string words = at(s.labels, i);
      const double half = svgTextWidth(words, kFont) / 2;
      const ChartBox around = lying_ ? ChartBox{end.x + 4, side, end.x + 4 + 2 * half, other}
                                     : ChartBox{end.x - half, end.y - kFont * 1.2, end.x + half, end.y - 2};
      if (words.empty() || around.right > width_ ||
          std::ranges::any_of(taken_, [&](const ChartBox& o) { return around.overlaps(o); }))
        continue;
      taken_.push_back(around);
      text("label", around.left, lying_ ? (side + other) / 2 + kFont * 0.35 : around.bottom - 2, "start", words);
    }
  }

  void spansAndLine(const ChartSeries& s) {
    for (std::size_t i = 0; i < std::min(s.spans.size(), s.points.size()); ++i) {
      if (!isDrawn(s.points[i]) || !isDrawn(s.spans[i])) continue;
      const Vec2d low = pixel({s.points[i].x, s.spans[i].x}), high = pixel({s.points[i].x, s.spans[i].y});
      path(kindOf("span", s), fmt::format("M{0},{1}V{2}M{3},{1}H{4}M{3},{2}H{4}", svgNumber(low.x), svgNumber(low.y),
                                          svgNumber(high.y), svgNumber(low.x - 4), svgNumber(low.x + 4)));
    }
    if (s.mark != ChartMark::Line && s.mark != ChartMark::LineAndDots) return;
    std::string d;
    bool open = false;
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
    if (!d.empty()) path(kindOf("line", s), d);
  }

  // Draws labels in free space beside their points. If there is no free space near a point, its label is left out, or
  // drawn farther away if the series has labelsFirst or is emphasised.
  void labels(const ChartSeries& s) {
    constexpr std::array<Vec2d, 8> kSides{{{1, 0}, {-1, 0}, {0, -1}, {0, 1}, {1, -1}, {1, 1}, {-1, -1}, {-1, 1}}};
    for (std::size_t i = 0; i < std::min(s.labels.size(), s.points.size()); ++i) {
      if (s.labels[i].empty() || !isDrawn(s.points[i])) continue;
      const Vec2d p = pixel(s.points[i]);
      const double half = svgTextWidth(s.labels[i], kFont, s.emphasised) / 2, tall = kFont * 0.6;
      bool placed = false;
      const auto place = [&](double reach, const Vec2d& side, bool uponLines) {
        const double off = (s.emphasised ? 6.5 : 4.5) * 1.15 + 3 + reach;
        const Vec2d c{p.x + side.x * (off + half), p.y + side.y * (off + tall)};
        const ChartBox box{c.x - half, c.y - tall, c.x + half, c.y + tall};
        const auto covers = [&](const ChartBox& o) { return box.overlaps(o); };
        const bool inside =
            box.left >= area_.left && box.right <= area_.right && box.top >= area_.top && box.bottom <= area_.bottom;
        placed = inside && std::ranges::none_of(taken_, covers) && (uponLines || std::ranges::none_of(lines_, covers));
        if (!placed) return;
        taken_.push_back(box);
        if (reach > 0) {
          line("axis", p.x, p.y, std::clamp(p.x, box.left, box.right), std::clamp(p.y, box.top, box.bottom));
        }
        text(s.emphasised ? "label strong" : "label", c.x, box.bottom - kFont * 0.3, "middle", s.labels[i]);
      };
      for (const bool uponLines : {false, true}) {
        for (const double reach : {0.0, 12.0, 26.0, 44.0, 70.0, 100.0, 140.0}) {
          for (const Vec2d& side : kSides) {
            if (!placed && (reach <= 12 || s.labelsFirst || s.emphasised)) place(reach, side, uponLines);
          }
        }
      }
    }
  }

  const Chart& chart_;
  const bool lying_;  // true: the y axis has names, and bars are horizontal
  double width_, height_;
  bool emphasised_ = false;  // true: at least one series is emphasised
  ChartBox area_;            // rectangle of the plot, without title, legend and axis labels
  const ChartScale *x_ = nullptr, *y_ = nullptr;
  std::map<double, double> stacked_;  // for each name, the sum of the bars that have been drawn there
  std::vector<ChartBox> taken_;       // boxes of marks and labels, which new labels must not overlap
  std::vector<ChartBox> lines_;       // boxes of emphasised lines, which labels avoid if there is room elsewhere
  std::string out_;
};

}  // namespace

double niceStep(double least) {
  const double power = std::pow(10, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= least * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

std::string axisNumber(double value, const std::string& unit) {
  if (unit == "%") return plain(value * 100) + " %";
  const double size = std::abs(value);
  const std::string space = unit.empty() ? "" : " ";
  if (size == 0) return "0" + space + unit;
  if (!(size < 1 && unit.empty()) && size < 1e16) {
    for (const auto& [factor, prefix] : {std::pair(1e12, "T"),
                                         {1e9, "G"},
                                         {1e6, "M"},
                                         {1e3, "k"},
                                         {1.0, ""},
                                         {1e-3, "m"},
                                         {1e-6, "\xC2\xB5"},
                                         {1e-9, "n"},
                                         {1e-12, "p"}}) {
      if (size < factor * (1 - 1e-9)) continue;
      const std::string unitText = prefix + unit;
      return plain(value / factor) + (unitText.empty() ? "" : " " + unitText);
    }
  }
  return plain(value) + space + unit;
}

bool hasPoints(const Chart& chart) {
  return std::ranges::any_of(chart.series, [](const ChartSeries& s) { return std::ranges::any_of(s.points, isDrawn); });
}

std::string drawSvg(const Chart& chart) {
  return SvgDrawing(chart).draw();
}

}  // namespace scanmill
