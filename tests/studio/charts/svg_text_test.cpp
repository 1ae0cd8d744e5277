#include "charts/svg_text.h"

#include "charts/chart.h"

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
