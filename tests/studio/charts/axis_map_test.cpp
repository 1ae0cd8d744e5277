#include "charts/axis_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "charts/label_places.h"
#include "charts/svg_text.h"

namespace scanmill {
namespace {

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

TEST(AxisMap, TicksAreRoundHoldTheDataAndHaveRoom) {
  for (const double top : {0.003, 0.7, 1.0, 9.9, 123.0, 4.4e7}) {
    AxisMap axis({}, {0.1 * top, top}, true, 400, 40);
    axis.place(0, 400);
    ASSERT_GE(axis.ticks().size(), 3u);
    EXPECT_EQ(axis.ticks().front().value, 0);
    EXPECT_GE(axis.ticks().back().value, top);
    for (std::size_t i = 1; i < axis.ticks().size(); ++i) {
      EXPECT_GE(axis.at(axis.ticks()[i].value) - axis.at(axis.ticks()[i - 1].value), 40);
    }
    const double step = axis.ticks()[1].value;
    const double digit = step / std::pow(10, std::floor(std::log10(step) + 1e-9));
    EXPECT_TRUE(std::abs(digit - 1) < 1e-6 || std::abs(digit - 2) < 1e-6 || std::abs(digit - 5) < 1e-6) << digit;
  }
}

TEST(AxisMap, ManyDecadesAreThinnedOut) {
  ChartAxis log{.scale = AxisScale::Log};
  AxisMap axis(log, {1e-30, 1e30}, false, 300, 30);
  axis.place(0, 300);
  EXPECT_LE(axis.ticks().size(), 11u);
  EXPECT_GE(axis.ticks().size(), 4u);
  EXPECT_TRUE(axis.minorTicks().empty());
}

TEST(SvgText, EscapesWhatXmlCannotHold) {
  EXPECT_EQ(escapeXml("a<b>&\"'"), "a&lt;b&gt;&amp;&quot;&#39;");
  EXPECT_EQ(escapeXml("\xC2\xB5m \xE2\x86\x92 \xF0\x9F\x9A\x97"), "\xC2\xB5m \xE2\x86\x92 \xF0\x9F\x9A\x97");
  const std::string none = "\xEF\xBF\xBD";
  EXPECT_EQ(escapeXml(std::string("\0", 1)), none);
  EXPECT_EQ(escapeXml("\x1B"), none);
  EXPECT_EQ(escapeXml("\xC0\xAF"), none + none) << "overlong";
  EXPECT_EQ(escapeXml("\xED\xA0\x80"), none + none + none) << "a surrogate";
  EXPECT_EQ(escapeXml("\xE2\x82"), none + none) << "cut off";
}

TEST(SvgText, WrapsAndFits) {
  const std::vector<std::string> lines = wrapSvgText("some words that are to be broken", 12, 80);
  EXPECT_GT(lines.size(), 1u);
  for (const std::string& line : lines) EXPECT_LE(svgTextWidth(line, 12), 80);
  EXPECT_TRUE(wrapSvgText("", 12, 80).empty());
  EXPECT_THAT(wrapSvgText("averylongwordindeed b", 12, 20), testing::ElementsAre("averylongwordindeed", "b"));
  EXPECT_EQ(fitSvgText("short", 12, 100), "short");
  const std::string cut = fitSvgText("a text that is too long", 12, 60);
  EXPECT_LE(svgTextWidth(cut, 12), 60);
  EXPECT_TRUE(cut.ends_with("\xE2\x80\xA6"));
  EXPECT_EQ(svgNumber(-0.001), "0");
  EXPECT_EQ(svgNumber(12.5), "12.5");
}

TEST(LabelPlaces, AvoidLinesWhereTheyCan) {
  const ChartBox area{0, 0, 200, 200};
  const LabelWish wish{{100, 100}, 4, 40, 14};
  const std::vector<Vec2d> line{{100, 100}, {200, 100}};  // where a label would lie first
  const auto places = placeLabels(std::vector{wish}, area, {}, line);
  ASSERT_TRUE(places[0].has_value());
  EXPECT_FALSE(places[0]->box.top < 100 && places[0]->box.bottom > 100 && places[0]->box.right > 100 &&
               places[0]->box.left > 100);
}

TEST(LabelPlaces, StayInside) {
  const ChartBox area{0, 0, 100, 20};
  EXPECT_FALSE(placeLabels(std::vector{LabelWish{{50, 10}, 4, 120, 14}}, area, {}, {})[0].has_value());
  EXPECT_TRUE(placeLabels(std::vector{LabelWish{{90, 10}, 4, 50, 14}}, area, {}, {})[0].has_value()) << "to the left";
}

}  // namespace
}  // namespace scanmill
