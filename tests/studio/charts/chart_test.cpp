#include "charts/chart.h"

#include <cstdint>
#include <limits>

#include "base/short_text.h"
#include "charts/svg_text.h"
#include "tests/studio/charts/svg_check.h"

namespace scanmill {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPixels = 0.02;  // coordinates have two decimals

Chart dotted(std::vector<Vec2d> points) {
  Chart chart{.title = "t"};
  chart.series.push_back({.name = "s", .points = std::move(points)});
  return chart;
}

// A number in [0, 1) that depends on `i` alone.
double spread(std::uint64_t i) {
  return static_cast<double>((i * 0x9E3779B97F4A7C15ull + 12345) >> 11) * 0x1.0p-53;
}

TEST(Chart, DrawsEveryPointOnceWhereItsValueLies) {
  const std::vector<Vec2d> points{{0, 0}, {10, 5}, {2.5, -3}, {7, 4.25}, {7, 4.25}};
  const std::string svg = drawSvg(dotted(points));
  const std::vector<Vec2d> dots = dotsOf(svg);
  ASSERT_EQ(dots.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(dots[i].x, dots[0].x + (dots[1].x - dots[0].x) * points[i].x / 10, kPixels);
    EXPECT_NEAR(dots[i].y, dots[0].y + (dots[1].y - dots[0].y) * points[i].y / 5, kPixels);
  }
  EXPECT_NEAR(dots[1].x, tickPlace(svg, "10", "middle"), kPixels);
  EXPECT_NEAR(dots[0].y, tickPlace(svg, "0", "end"), kPixels);
  EXPECT_LT(dots[1].y, dots[0].y) << "up is more";
}

TEST(Chart, LogarithmicAxesGoByFactors) {
  Chart chart = dotted({{1e3, 1e-4}, {1e6, 10}, {3e4, 0.02}, {2e5, 3.3}});
  chart.x.scale = chart.y.scale = AxisScale::Log;
  chart.y.unit = "m";
  const std::string svg = drawSvg(chart);
  const std::vector<Vec2d> dots = dotsOf(svg);
  ASSERT_EQ(dots.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec2d& p = chart.series[0].points[i];
    EXPECT_NEAR(dots[i].x, dots[0].x + (dots[1].x - dots[0].x) * std::log10(p.x / 1e3) / 3, kPixels);
    EXPECT_NEAR(dots[i].y, dots[0].y + (dots[1].y - dots[0].y) * std::log10(p.y / 1e-4) / 5, kPixels);
  }
  EXPECT_NEAR(dots[1].x, tickPlace(svg, "1 M", "middle"), kPixels);
  EXPECT_NEAR(dots[1].y, tickPlace(svg, "10 m", "end"), kPixels);
  EXPECT_NEAR(dots[0].y, tickPlace(svg, "100 \xC2\xB5m", "end"), kPixels);
}

TEST(Chart, ZerosAndBelowHaveALineOfTheirOwnBesideALogarithmicAxis) {
  Chart chart = dotted({{1, 0}, {2, 1e-3}, {3, -5}, {4, 1}});
  chart.y.scale = AxisScale::Log;
  chart.y.zero = "exact";
  const std::string svg = drawSvg(chart);
  const std::vector<Vec2d> dots = dotsOf(svg);
  ASSERT_EQ(dots.size(), 4u);
  EXPECT_DOUBLE_EQ(dots[0].y, dots[2].y);
  EXPECT_NEAR(dots[0].y, tickPlace(svg, "exact", "end"), kPixels);
  EXPECT_GT(dots[0].y, dots[1].y + 15) << "below all that is positive";
  const std::vector<SvgElement> band = elementsOf(svg, "band");
  ASSERT_EQ(band.size(), 1u);
  EXPECT_GT(dots[0].y, numberOf(band[0], "y"));
  EXPECT_LT(dots[1].y, numberOf(band[0], "y"));

  chart.series[0].points = {{1, 0.1}, {2, 1}};
  EXPECT_THAT(textsOf(drawSvg(chart), "tick"), testing::Not(testing::Contains("exact")));
  chart.series[0].points = {{1, 0}, {2, 0}};
  EXPECT_EQ(dotsOf(drawSvg(chart)).size(), 2u);
}

TEST(Chart, WhatIsNotFiniteIsLeftOutAndBreaksLines) {
  Chart chart = dotted({{1, 1}, {kNaN, 2}, {2, kInfinity}, {3, -kInfinity}, {4, kNaN}, {5, 2}, {6, 3}});
  EXPECT_EQ(dotsOf(drawSvg(chart)).size(), 3u);
  chart.series[0].mark = ChartMark::Line;
  const std::vector<SvgElement> lines = elementsOf(drawSvg(chart), "line");
  ASSERT_EQ(lines.size(), 1u);
  const std::string& d = lines[0].attributes.at("d");
  EXPECT_EQ(std::ranges::count(d, 'M'), 2) << d;
  EXPECT_EQ(std::ranges::count(d, 'L'), 1) << d;
}

TEST(Chart, WithoutDataSaysSo) {
  EXPECT_THAT(textsOf(drawSvg({.title = "none"}), "nodata"), testing::ElementsAre("no data"));
  EXPECT_THAT(textsOf(drawSvg(dotted({{kNaN, 1}})), "nodata"), testing::ElementsAre("no data"));
  EXPECT_TRUE(textsOf(drawSvg(dotted({{1, 1}})), "nodata").empty());
}

TEST(Chart, TextIsEscapedAndComesBack) {
  const std::string hostile = "</text><script>alert('1')</script> & \"x\"";
  Chart chart = dotted({{1, 1}});
  chart.title = chart.note = chart.x.title = chart.y.title = hostile;
  chart.width = 2000;
  chart.series[0].name = hostile;
  chart.series[0].labels = {hostile};
  chart.series[0].details = {hostile + std::string("\x01\xFF", 2)};
  const std::string svg = drawSvg(chart);
  EXPECT_EQ(svg.find("<script"), std::string::npos);
  for (const char* kind : {"title", "label"}) EXPECT_THAT(textsOf(svg, kind), testing::ElementsAre(hostile)) << kind;
  int details = 0;
  for (const SvgElement& e : parseSvg(svg)) {
    if (e.tag != "title") continue;
    ++details;
    EXPECT_EQ(e.text, hostile + "\xEF\xBF\xBD\xEF\xBF\xBD");
  }
  EXPECT_EQ(details, 1);
}

TEST(Chart, LabelsCoverNeitherEachOtherNorMarks) {
  std::size_t drawn = 0;
  for (std::uint64_t round = 0; round < 12; ++round) {
    Chart chart;
    chart.width = 700;
    for (std::size_t s = 0; s < 3; ++s) {
      ChartSeries series{.name = "series", .color = s, .emphasised = s == 1};
      for (std::uint64_t i = 0; i < 12; ++i) {
        const std::uint64_t at = round * 1000 + s * 100 + i * 2;
        // Some in a crowd.
        const double scale = i % 3 == 0 ? 0.05 : 1;
        series.points.push_back({spread(at) * scale, spread(at + 1) * scale});
        series.labels.push_back("setting=" + std::to_string(at));
      }
      chart.series.push_back(series);
    }
    const std::string svg = drawSvg(chart);
    const std::vector<LabelBox> boxes = labelBoxes(svg);
    drawn += boxes.size();
    for (std::size_t a = 0; a < boxes.size(); ++a) {
      for (std::size_t b = a + 1; b < boxes.size(); ++b) {
        LabelBox inner = boxes[a];
        inner.left += kPixels, inner.right -= kPixels, inner.top += kPixels, inner.bottom -= kPixels;
        EXPECT_FALSE(inner.overlaps(boxes[b])) << "round " << round;
      }
      for (const Vec2d& dot : dotsOf(svg)) {
        EXPECT_FALSE(boxes[a].overlaps({dot.x - 3, dot.y - 3, dot.x + 3, dot.y + 3})) << "round " << round;
      }
      EXPECT_GE(boxes[a].left, 0);
      EXPECT_LE(boxes[a].right, 700);
    }
  }
  EXPECT_GT(drawn, 12u * 20) << "most find room";
}

TEST(Chart, LabelsWithoutRoomAreDropped) {
  Chart chart = dotted(std::vector<Vec2d>(200, Vec2d{1, 1}));
  chart.series[0].labels.assign(200, "all at one place");
  const std::string svg = drawSvg(chart);
  EXPECT_EQ(dotsOf(svg).size(), 200u);
  EXPECT_LT(labelBoxes(svg).size(), 40u);
  EXPECT_GE(labelBoxes(svg).size(), 1u);
}

TEST(Chart, BarsAreAsLongAsTheirValues) {
  Chart chart;
  chart.x.names = {"a", "b", "c"};
  chart.series.push_back({.name = "one", .mark = ChartMark::Bars, .points = {{0, 2}, {1, 8}, {2, 4}}});
  chart.series.push_back({.name = "two", .color = 1, .mark = ChartMark::Bars, .points = {{0, 1}, {2, kNaN}}});
  const std::vector<SvgElement> bars = elementsOf(drawSvg(chart), "bar");
  ASSERT_EQ(bars.size(), 4u);
  const double unit = numberOf(bars[3], "height");
  const std::vector<double> lengths{2, 8, 4};
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(numberOf(bars[i], "height"), lengths[i] * unit, 8 * kPixels);
  EXPECT_GE(numberOf(bars[3], "x"), numberOf(bars[0], "x") + numberOf(bars[0], "width")) << "side by side";
  EXPECT_LT(numberOf(bars[3], "x"), numberOf(bars[1], "x"));
}

TEST(Chart, SeriesOfOneNameAndColourShareALegendEntry) {
  Chart chart = dotted({{1, 1}, {2, 2}});
  chart.series.push_back({.name = "s", .mark = ChartMark::Line, .points = {{1, 1}, {2, 2}}});
  chart.series.push_back({.name = "", .color = 2, .points = {{1, 1}}});
  chart.series.push_back({.name = "other", .color = 1, .points = {{1, 1}}});
  chart.series.push_back({.name = "without points", .color = 3});
  std::vector<std::string> entries;
  for (const SvgElement& e : parseSvg(drawSvg(chart))) {
    if (e.tag == "text" && e.attributes.at("class") == "entry") entries.push_back(e.text);
  }
  EXPECT_THAT(entries, testing::ElementsAre("s", "other"));
}

TEST(Chart, ExtremeValuesStayWithinThePicture) {
  for (const AxisScale scale : {AxisScale::Linear, AxisScale::Log}) {
    for (const std::vector<Vec2d>& points :
         {std::vector<Vec2d>{{0, 0}}, std::vector<Vec2d>{{1e-300, 1e300}, {1e300, 1e-300}},
          std::vector<Vec2d>{{5, 5}, {5, 5}}, std::vector<Vec2d>{{-1e9, 1e-9}}, std::vector<Vec2d>{{1e15, 1e15 + 1}}}) {
      Chart chart = dotted(points);
      chart.x.scale = chart.y.scale = scale;
      const std::string svg = drawSvg(chart);
      ASSERT_EQ(dotsOf(svg).size(), points.size());
      for (const Vec2d& dot : dotsOf(svg)) {
        EXPECT_TRUE(dot.x >= 0 && dot.x <= chart.width && dot.y >= 0 && dot.y <= chart.height) << dot.x << " " << dot.y;
      }
    }
  }
}

TEST(Chart, GivenEndsAreKeptUnlessDataLieBeyond) {
  Chart chart = dotted({{0.2, 0.3}, {0.9, 0.6}});
  chart.y.low = 0;
  chart.y.high = 1;
  chart.y.unit = "%";
  const std::vector<std::string> ticks = textsOf(drawSvg(chart), "tick");
  EXPECT_THAT(ticks, testing::Contains("100 %"));
  EXPECT_THAT(ticks, testing::Contains("0 %"));
  chart.series[0].points.push_back({0.5, 3});
  const std::string wider = drawSvg(chart);
  for (const Vec2d& dot : dotsOf(wider)) EXPECT_GT(dot.y, 0);
  EXPECT_EQ(dotsOf(wider).size(), 3u);
}

TEST(Chart, NamesBesideTheChartHaveLyingBarsFromTheTop) {
  Chart chart;
  chart.y.names = {"a", "b"};
  chart.series.push_back({.name = "one",
                          .mark = ChartMark::Bars,
                          .points = {{2, 0}, {8, 1}},
                          .labels = {"two", "eight"},
                          .fills = {"#123456", "#abcdef"}});
  const std::string svg = drawSvg(chart);
  const std::vector<SvgElement> bars = elementsOf(svg, "bar");
  ASSERT_EQ(bars.size(), 2u);
  EXPECT_NEAR(4 * numberOf(bars[0], "width"), numberOf(bars[1], "width"), 8 * kPixels);
  EXPECT_EQ(numberOf(bars[0], "x"), numberOf(bars[1], "x"));
  EXPECT_LT(numberOf(bars[0], "y"), numberOf(bars[1], "y"));
  EXPECT_EQ(bars[1].attributes.at("style"), "fill:#abcdef");
  EXPECT_THAT(textsOf(svg, "label"), testing::ElementsAre("two", "eight"));
  EXPECT_GT(labelBoxes(svg)[1].left, numberOf(bars[1], "x") + numberOf(bars[1], "width"));
}

TEST(Chart, StackedBarsBeginWhereTheOneBeforeEnds) {
  for (const bool lying : {false, true}) {
    Chart chart{.stacked = true};
    (lying ? chart.y : chart.x).names = {"a", "b"};
    const auto point = [&](double value, double name) { return lying ? Vec2d{value, name} : Vec2d{name, value}; };
    chart.series.push_back({.name = "one", .mark = ChartMark::Bars, .points = {point(3, 0), point(1, 1)}});
    chart.series.push_back({.name = "two", .color = 1, .mark = ChartMark::Bars, .points = {point(2, 0), point(6, 1)}});
    const std::vector<SvgElement> bars = elementsOf(drawSvg(chart), "bar");
    ASSERT_EQ(bars.size(), 4u);
    const char *along = lying ? "width" : "height", *at = lying ? "x" : "y";
    EXPECT_NEAR(numberOf(bars[3], along), 6 * numberOf(bars[1], along), 8 * kPixels);
    const std::size_t low = lying ? 1 : 3, high = lying ? 3 : 1;  // x grows from the first bar, y towards it
    EXPECT_NEAR(numberOf(bars[low], at) + numberOf(bars[low], along), numberOf(bars[high], at), 2 * kPixels);
  }
}

TEST(AxisNumber, IsWrittenAsEngineersDo) {
  EXPECT_EQ(axisNumber(0, ""), "0");
  EXPECT_EQ(axisNumber(0.001, ""), "0.001");
  EXPECT_EQ(axisNumber(250, ""), "250");
  EXPECT_EQ(axisNumber(10'000, ""), "10 k");
  EXPECT_EQ(axisNumber(1e6, ""), "1 M");
  EXPECT_EQ(axisNumber(-2.5e9, ""), "-2.5 G");
  EXPECT_EQ(axisNumber(1e-7, ""), "1e-7");
  EXPECT_EQ(axisNumber(1e-5, "m"), "10 \xC2\xB5m");
  EXPECT_EQ(axisNumber(0.1, "m"), "100 mm");
  EXPECT_EQ(axisNumber(20, "m"), "20 m");
  EXPECT_EQ(axisNumber(0.3 * 3, "s"), "900 ms");
  EXPECT_EQ(axisNumber(0.001, "%"), "0.1 %");
  EXPECT_EQ(axisNumber(1, "%"), "100 %");
}

TEST(SvgText, EscapesWhatXmlCannotHold) {
  EXPECT_EQ(escapeXml("a<b>&\"'"), "a&lt;b&gt;&amp;&quot;&#39;");
  EXPECT_EQ(escapeXml("\xC2\xB5m \xE2\x86\x92 \xF0\x9F\x9A\x97"), "\xC2\xB5m \xE2\x86\x92 \xF0\x9F\x9A\x97");
  const std::string none = "\xEF\xBF\xBD";
  EXPECT_EQ(escapeXml(std::string("\0", 1)), none);
  EXPECT_EQ(escapeXml("\x1B"), none);
  EXPECT_EQ(escapeXml("gpj\u202E.exe\u009B\u2028"), "gpj" + none + ".exe" + none + none);
  EXPECT_EQ(escapeXml("a\n\tb"), "a\n\tb");
  EXPECT_EQ(escapeXml("\xC0\xAF"), none + none) << "overlong";
  EXPECT_EQ(escapeXml("\xED\xA0\x80"), none + none + none) << "a surrogate";
  EXPECT_EQ(escapeXml("\xE2\x82"), none + none) << "cut off";
}

TEST(SvgText, Wraps) {
  const std::vector<std::string> lines = wrapSvgText("some words that are to be broken", 12, 80);
  EXPECT_GT(lines.size(), 1u);
  for (const std::string& line : lines) EXPECT_LE(svgTextWidth(line, 12), 80);
  EXPECT_TRUE(wrapSvgText("", 12, 80).empty());
  EXPECT_THAT(wrapSvgText("averylongwordindeed b", 12, 20), testing::ElementsAre("averylongwordindeed", "b"));
  EXPECT_EQ(svgNumber(-0.001), "0");
  EXPECT_EQ(svgNumber(12.5), "12.5");
}

TEST(SvgText, LongNamesKeepTheirEnds) {
  EXPECT_EQ(shortened("short", 20), "short");
  EXPECT_EQ(shortened("the first setting of all, number 12", 20), "the first\xE2\x80\xA6 number 12");
  EXPECT_EQ(shortened("\xC3\xA9\xC3\xA9" + std::string(20, 'x'), 20),
            "\xC3\xA9\xC3\xA9" + std::string(7, 'x') + "\xE2\x80\xA6" + std::string(10, 'x'));
}

}  // namespace
}  // namespace scanmill
