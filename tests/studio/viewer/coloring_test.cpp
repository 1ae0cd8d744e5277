#include "viewer/coloring.h"

#include <cstdlib>
#include <limits>
#include <set>

#include "base/error.h"
#include "base/parallel.h"
#include "tests/support/message_of.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

double luma(const Rgb& c) {
  return 0.299 * c[0] + 0.587 * c[1] + 0.114 * c[2];
}

Scan scanOf(std::size_t points) {
  Scan scan;
  for (std::size_t i = 0; i < points; ++i) scan.position.push_back({static_cast<float>(i + 1), 0, -1});
  return scan;
}

std::vector<std::string> names(const Legend& legend) {
  std::vector<std::string> out;
  for (const LegendEntry& e : legend.entries) out.push_back(e.name);
  return out;
}

TEST(ColorNames, NoTwoAreTheSame) {
  const std::set<std::string> names(colorNames().begin(), colorNames().end());
  EXPECT_EQ(names.size(), colorNames().size()) << "a column is called as one of the viewer's own";
}

TEST(Viridis, EndsAndEvenBrightness) {
  EXPECT_EQ(viridis(0), (Rgb{68, 1, 84}));
  EXPECT_EQ(viridis(1), (Rgb{253, 231, 37}));
  EXPECT_EQ(viridis(-3), viridis(0));
  EXPECT_EQ(viridis(7), viridis(1));
  for (int i = 1; i <= 100; ++i) EXPECT_GT(luma(viridis(i / 100.0)), luma(viridis((i - 1) / 100.0)));
}

TEST(ClassColor, IsTheOntologysUnlessTooDark) {
  Ontology ontology = testOntology();
  ontology.classes[1].color = {200, 100, 50};
  ontology.classes[2].color = {0, 0, 140};
  EXPECT_EQ(classColor(&ontology, 1), (Rgb{200, 100, 50}));
  EXPECT_GE(luma(classColor(&ontology, 2)), 59);
  EXPECT_GE(luma(classColor(&ontology, 0)), 59) << "black would not be seen";
  EXPECT_GT(classColor(&ontology, 2)[2], classColor(&ontology, 2)[0]) << "still blue";
  EXPECT_NE(classColor(nullptr, 1), classColor(nullptr, 2));
  EXPECT_EQ(classColor(&ontology, 77), classColor(nullptr, 77));
}

TEST(ColorScan, LegendNamesTheClassesInTheScanAlone) {
  const Ontology ontology = testOntology();
  Scan scan = scanOf(4);
  scan[kLabel] = {3, 1, 3, 500};
  const Coloring c = colorScan(scan, ColorBy("class"), {&ontology});
  EXPECT_THAT(names(c.legend), testing::ElementsAre("ground", "other", "class 500"));
  EXPECT_EQ(c.colors[0], c.colors[2]);
  EXPECT_EQ(c.colors[0], c.legend.entries[1].color);
  EXPECT_EQ(c.colors[1], c.legend.entries[0].color);
  EXPECT_THAT(names(colorScan(scan, ColorBy("class"), {}).legend),
              testing::ElementsAre("class 1", "class 3", "class 500"));
  const ColorContext closeUp{.ontology = &ontology, .closeUp = CloseUp{{2, 0, -1}, 0.5}};
  EXPECT_THAT(names(colorScan(scan, ColorBy("class"), closeUp).legend), testing::ElementsAre("ground"));
}

TEST(ColorScan, PercentilesClipIntensity) {
  Scan scan = scanOf(1001);
  for (std::size_t i = 0; i <= 1000; ++i) scan[kIntensity].push_back(static_cast<float>(i));
  scan[kIntensity][1000] = 1e9f;
  const Coloring c = colorScan(scan, ColorBy("intensity"), {});
  EXPECT_EQ(c.legend.low, 10);
  EXPECT_EQ(c.legend.high, 990);
  EXPECT_EQ(c.colors[0], viridis(0));
  EXPECT_EQ(c.colors[995], viridis(1));
  EXPECT_EQ(c.colors[1000], viridis(1));
  EXPECT_EQ(c.colors[255], viridis(0.5)) << "a quarter of the span: half the root";
}

TEST(ColorScan, RingAndTimeSpanAll) {
  Scan scan = scanOf(3);
  scan[kRing] = {0, 31, 62};
  scan[kTime] = {0, 0.025f, 0.1f};
  const Coloring ring = colorScan(scan, ColorBy("ring"), {});
  EXPECT_EQ(ring.legend.low, 0);
  EXPECT_EQ(ring.legend.high, 62);
  EXPECT_EQ(ring.colors[1], viridis(0.5));
  EXPECT_NEAR(colorScan(scan, ColorBy("time"), {}).legend.high, 100, 1e-4) << "ms";
}

TEST(ColorScan, RangeAndHeightNeedNoColumn) {
  const Scan scan = scanOf(2);
  EXPECT_NEAR(colorScan(scan, ColorBy("range"), {}).legend.high, std::hypot(2, 1), 1e-6);
  const Coloring height = colorScan(scan, ColorBy("height"), {});
  EXPECT_EQ(height.legend.low, -1);
  EXPECT_EQ(height.colors[0], viridis(0.5)) << "one value alone is in the middle";
}

TEST(ColorScan, SaysWhichColumnIsMissing) {
  Scan scan = scanOf(2);
  scan[kRing] = {0, 1};
  for (const auto& [by, column] :
       {std::pair{ColorBy("class"), "'label'"}, std::pair{ColorBy("intensity"), "'intensity'"},
        std::pair{ColorBy("instance"), "'instance'"}, std::pair{ColorBy("time"), "'time'"},
        std::pair{ColorBy("incidence"), "'incidence'"}}) {
    expectInputError([&] { colorScan(scan, by, {}); }, {column, "x, y, z, ring"});
  }
}

std::vector<std::uint64_t> counts(const Legend& legend) {
  std::vector<std::uint64_t> out;
  for (const LegendEntry& e : legend.entries) out.push_back(e.points);
  return out;
}

TEST(ColorScan, EntriesKnowTheirClassAndHowManyPointsTheyHave) {
  const Ontology ontology = testOntology();
  Scan scan = scanOf(6);
  scan[kLabel] = {3, 1, 3, 500, 0, 3};
  scan[kInstance] = {0, 7, 8, 7, 0, 9};
  scan.position[4].z = std::numeric_limits<float>::quiet_NaN();
  scan.position[5].x = std::numeric_limits<float>::infinity();
  const Legend classes = colorScan(scan, ColorBy("class"), {&ontology}).legend;
  std::vector<std::int64_t> ids;
  for (const LegendEntry& e : classes.entries) ids.push_back(e.id);
  EXPECT_THAT(ids, testing::ElementsAre(1, 3, 500));
  EXPECT_THAT(counts(classes), testing::ElementsAre(1, 2, 1));
  const Coloring byInstance = colorScan(scan, ColorBy("instance"), {&ontology});
  EXPECT_EQ(byInstance.colors[0], kNoValue);
  EXPECT_EQ(byInstance.colors[1], byInstance.colors[3]);
  EXPECT_NE(byInstance.colors[1], byInstance.colors[2]);
  const Legend& instances = byInstance.legend;
  EXPECT_THAT(names(instances), testing::ElementsAre("2 instances, a colour each", "no instance"));
  EXPECT_THAT(counts(instances), testing::ElementsAre(3, 1));
  EXPECT_EQ(instances.entries[0].id, -1) << "of no class";
}

TEST(ColorScan, CausesAreKindsWithNames) {
  Scan scan = scanOf(5);
  scan[kCause] = {1, 3, 1, 200, 4};
  const Coloring c = colorScan(scan, ColorBy("cause"), {});
  EXPECT_FALSE(c.legend.scale);
  EXPECT_FALSE(isNumeric(ColorBy("cause")));
  EXPECT_THAT(names(c.legend), testing::ElementsAre("surface", "through_glass", "mirrored", "cause 200"));
  EXPECT_THAT(counts(c.legend), testing::ElementsAre(2, 1, 1, 1));
  EXPECT_EQ(c.colors[0], c.colors[2]);
  EXPECT_NE(c.colors[0], c.colors[1]);
  EXPECT_THAT(messageOf([&] { colorScan(scanOf(2), ColorBy("cause"), {}); }), testing::HasSubstr("cause"));
}

TEST(ColorScan, AllPointsAreFirstReturns) {
  Scan scan = scanOf(3);
  scan.position[1].x = std::numeric_limits<float>::quiet_NaN();
  const Coloring c = colorScan(scan, ColorBy("return"), {});
  EXPECT_FALSE(c.legend.scale);
  EXPECT_THAT(names(c.legend), testing::ElementsAre("not numbered (no column `return`)"));
  EXPECT_THAT(counts(c.legend), testing::ElementsAre(2));
  EXPECT_THAT(c.colors, testing::ElementsAre(c.colors[0], c.colors[0], c.colors[0]));
  EXPECT_GT(luma(c.colors[0]), 59);
}

TEST(ColorScan, IncidenceSpansAllAngles) {
  Scan scan = scanOf(4);
  scan[kIncidence] = {0, static_cast<float>(kPi / 4), static_cast<float>(kPi / 2),
                      std::numeric_limits<float>::quiet_NaN()};
  const Coloring c = colorScan(scan, ColorBy("incidence"), {});
  EXPECT_EQ(c.legend.title, "incidence (deg)");
  EXPECT_EQ(c.legend.low, 0);
  EXPECT_EQ(c.legend.high, 90);
  EXPECT_THAT(c.colors,
              testing::ElementsAre(viridis(0), viridis(degrees(scan[kIncidence][1]) / 90), viridis(1), kNoValue));
  scan[kIncidence].assign(4, 0.5f);
  EXPECT_EQ(colorScan(scan, ColorBy("incidence"), {}).legend.high, 90) << "an angle has one colour in all scans";
}

TEST(ColorScan, ErrorsAreThoseGiven) {
  const Scan scan = scanOf(1001);
  std::vector<float> error(1001);
  for (std::size_t i = 0; i < error.size(); ++i) error[i] = 1 + static_cast<float>(i) / 1000;
  error[1000] = 1e9f;
  error[0] = std::numeric_limits<float>::quiet_NaN();
  const Coloring c = colorScan(scan, ColorBy("error"), {.error = error, .errorTitle = "to the reference (m)"});
  EXPECT_EQ(c.legend.title, "to the reference (m)");
  EXPECT_EQ(c.legend.low, 0) << "not the least, which is 1.001";
  EXPECT_NEAR(c.legend.high, 1.99, 2e-3);
  EXPECT_EQ(c.colors[0], kNoValue);
  EXPECT_EQ(c.colors[1], viridis(std::sqrt(1.001 / c.legend.high)));
  EXPECT_EQ(c.colors[1000], viridis(1));
  EXPECT_EQ(colorScan(scan, ColorBy("error"), {.error = error}).legend.title, "error (m)");
  error.pop_back();
  EXPECT_THROW(colorScan(scan, ColorBy("error"), {.error = error}), Error);
}

TEST(ColorScan, WithoutAGivenErrorItIsThatOfTheRange) {
  Scan scan;
  scan.position = {{3, 4, 0}, {0, 0, 2}, {1, 0, 0}};
  scan[kRangeTrue] = {5.5f, 1.5f, 1};
  const Coloring c = colorScan(scan, ColorBy("error"), {});
  EXPECT_EQ(c.legend.title, "error (m)");
  EXPECT_EQ(c.legend.high, 0.5);
  EXPECT_THAT(c.colors, testing::ElementsAre(viridis(1), viridis(1), viridis(0)));
  scan[kRangeTrue].clear();
  expectInputError([&] { colorScan(scan, ColorBy("error"), {}); },
                   {"`range_true`", "output.columns", "noise-free reference", "x, y, z"});
  EXPECT_NO_THROW(colorScan(Scan{}, ColorBy("error"), {})) << "nothing to compare";
}

TEST(ColorScan, DefaultIsTheBestThatTheScanHas) {
  Scan scan = scanOf(2);
  EXPECT_EQ(colorScan(scan, {}, {}).legend.title, "range (m)");
  scan[kIntensity] = {1, 2};
  EXPECT_EQ(colorScan(scan, {}, {}).legend.title, "intensity");
  scan[kLabel] = {1, 2};
  EXPECT_EQ(colorScan(scan, {}, {}).legend.title, "class");
}

TEST(Coloring, MillionsOfPointsGiveTheSameScaleAndColoursWithAnyNumberOfThreads) {
  Scan scan;
  constexpr std::size_t kPoints = 2'500'000;
  for (std::size_t i = 0; i < kPoints; ++i) {
    scan.position.push_back({static_cast<float>(i * 7919 % kPoints) * 4e-5f, 0, 0});  // 0 to 100 m, evenly
    scan[kInstance].push_back(static_cast<std::uint32_t>(i / 1000 % 3));
  }
  const Coloring all = colorScan(scan, ColorBy("range"), {});
  EXPECT_NEAR(all.legend.low, 1, 0.05);
  EXPECT_NEAR(all.legend.high, 99, 0.05);
  const ThreadLimit one(1);
  EXPECT_EQ(colorScan(scan, ColorBy("range"), {}).colors, all.colors);
  const Coloring byInstance = colorScan(scan, ColorBy("instance"), {});
  for (std::size_t i = 0; i < kPoints; i += 997) {
    ASSERT_EQ(byInstance.colors[i], instanceColor(scan[kInstance][i]));
  }
  EXPECT_EQ(byInstance.legend.entries.at(0).points + byInstance.legend.entries.at(1).points, kPoints);
}

Legend scaleOf(double low, double high, double power = 1) {
  return {.title = "range (m)", .scale = true, .low = low, .high = high, .power = power};
}

// 1, 2, 5 or 10 after powers of ten are taken away, of a number or of the step that it is a multiple of.
bool isRound(double value) {
  if (value == 0) return true;
  const double decimals = std::abs(value) / std::pow(10.0, std::floor(std::log10(std::abs(value))) - 2);
  return std::abs(decimals - std::round(decimals)) < 1e-6;
}

std::vector<std::string> figuresOf(const Legend& legend) {
  std::vector<std::string> figures;
  for (const ScaleTick& tick : scaleTicks(legend)) figures.push_back(tick.text);
  return figures;
}

// Whatever the ends: few, round, ascending, apart, and where the bar has that value.
TEST(ScaleTicks, AreRoundAndStandWhereTheirValuesAre) {
  for (const double power : {1.0, 2.0}) {
    for (double size = 1e-6; size < 1e7; size *= 3.7) {
      for (const double from : {0.0, 0.013, 0.4, -0.7, -1.0}) {
        const Legend legend = scaleOf(from * size, (from + 1) * size, power);
        const std::vector<ScaleTick> ticks = scaleTicks(legend);
        ASSERT_GE(ticks.size(), 2u) << size << " " << from;
        ASSERT_LE(ticks.size(), 6u);
        double last = -1;
        for (const ScaleTick& tick : ticks) {
          const double value = std::strtod(tick.text.c_str(), nullptr);
          EXPECT_TRUE(isRound(value)) << tick.text;
          EXPECT_LE(tick.text.size(), 9u) << tick.text;
          EXPECT_NEAR(legend.low + std::pow(tick.position, power) * size, value, 1e-6 * size);
          EXPECT_GT(tick.position, last + 0.1);
          last = tick.position;
        }
      }
    }
  }
  EXPECT_THAT(figuresOf(scaleOf(0, 100)), testing::ElementsAre("0", "20", "40", "60", "80", "100"));
  EXPECT_THAT(figuresOf(scaleOf(-1.9, 6.3)), testing::ElementsAre("0", "2", "4", "6"));
}

TEST(ScaleTicks, OfRingsAreWholeNumbers) {
  for (double high = 1; high < 200; ++high) {
    Legend legend = scaleOf(0, high);
    legend.integers = true;
    for (const std::string& figure : figuresOf(legend)) EXPECT_EQ(figure.find('.'), std::string::npos) << high;
  }
}

TEST(ScaleTicks, WhatIsNoScaleHasOneOrNone) {
  EXPECT_THAT(figuresOf(scaleOf(3, 3)), testing::ElementsAre("3"));
  EXPECT_EQ(figuresOf(scaleOf(5, 3)).size(), 1u);
  EXPECT_EQ(figuresOf(scaleOf(NAN, 3)).size(), 1u);
  EXPECT_EQ(figuresOf(scaleOf(0, INFINITY)).size(), 1u);
  EXPECT_EQ(figuresOf(scaleOf(0, 3, 0)).size(), 1u);
  EXPECT_LE(figuresOf(scaleOf(1e15, 1e15 + 0.25)).size(), 6u);
  EXPECT_LE(figuresOf(scaleOf(0, std::numeric_limits<double>::min())).size(), 6u);
}

TEST(ScaleTitle, SaysHowItRuns) {
  EXPECT_EQ(scaleTitle(scaleOf(0, 1)), "range (m)");
  EXPECT_EQ(scaleTitle(scaleOf(0, 1, 2)), "range (m), by its square root");
}

}  // namespace
}  // namespace scanmill
