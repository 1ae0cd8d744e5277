#include "study/compare/compare.h"

#include <nlohmann/json.hpp>

#include "base/parallel.h"
#include "tests/core/dataset/fixture.h"
#include "tests/studio/study/compare/compare_scans.h"
#include "tests/support/shared_data.h"

namespace scanmill {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

double figureOf(const ScanSet& set, std::string_view name) {
  for (std::size_t i = 0; i < kSetFigureCount; ++i) {
    if (kSetFigures[i].name == name) return set.figures[i];
  }
  ADD_FAILURE() << name;
  return 0;
}

// 1.4826 times the median distance from the median, of what rings from `first` up to `end` differ by from the mean of
// their neighbours.
double spreadAgainstNeighbours(unsigned seed, std::size_t first, std::size_t end) {
  const std::vector<double> own = ofRings(seed);
  std::vector<double> differences;
  for (std::size_t r = first; r < end; ++r) differences.push_back(own[r] - 0.5 * (own[r - 1] + own[r + 1]));
  const auto median = [](std::vector<double> list) {
    std::ranges::sort(list);
    return list[(list.size() - 1) / 2];
  };
  const double middle = median(differences);
  for (double& d : differences) d = std::fabs(d - middle);
  return 1.4826 * median(differences);
}

TEST(Compare, ASetAgainstItselfDiffersInNothing) {
  for (const bool labelled : {true, false}) {
    const SetComparison same = compareSets(setOf({}, 1, labelled), setOf({}, 1, labelled));
    EXPECT_EQ(same.byClass, labelled);
    ASSERT_GE(same.features.size(), kFeatureCount - 1);
    for (const Separation& s : same.features) {
      EXPECT_EQ(s.strength, 0) << kPatchFeatures[s.feature].name;
      EXPECT_EQ(s.area, 0.5);
      EXPECT_EQ(s.realValue, s.simulatedValue);
    }
    EXPECT_GE(same.surfacesAlike().second, 10u);
    EXPECT_EQ(same.surfacesAlike().first, same.surfacesAlike().second);
  }
}

TEST(Compare, TwoDrawsOfOneLawHardlyDiffer) {
  const SetComparison alike = compareSets(setOf({}, 1), setOf({}, 11));
  for (const Separation& s : alike.features) EXPECT_LT(s.strength, 0.05) << kPatchFeatures[s.feature].name;
}

struct Known {
  const char* name;
  Flaws flaws;
  std::vector<Feature> first;  // one of these tells most
  const char* key;             // is named as what moves it
};
void PrintTo(const Known& known, std::ostream* out) {
  *out << known.name;
}

class FindsKnown : public testing::TestWithParam<Known> {};

TEST_P(FindsKnown, AndNamesItFirst) {
  const Known& known = GetParam();
  for (const bool labelled : {true, false}) {
    SCOPED_TRACE(labelled);
    const SetComparison found = compareSets(setOf({}, 1, labelled), setOf(known.flaws, 11, labelled));
    const Separation& first = found.features.front();
    EXPECT_THAT(known.first, testing::Contains(static_cast<Feature>(first.feature)))
        << kPatchFeatures[first.feature].name;
    EXPECT_THAT(std::string(kPatchFeatures[first.feature].keys), HasSubstr(known.key));
    EXPECT_GT(first.area, 0.5);
    EXPECT_GT(first.strength, 5 * found.withinReal[first.feature]);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Compare, FindsKnown,
    testing::Values(Known{"RangeNoise", {.sigma = 0.02}, {Feature::RangeScatter, Feature::Thickness}, "range_noise"},
                    Known{"LostBeams", {.lost = 0.03}, {Feature::Missing, Feature::SingleMissing}, "dropout"},
                    Known{"RingOffsets", {.ringOffset = 0.02}, {Feature::RingOffset}, "ring_bias"},
                    Known{"RingGains", {.ringGain = 0.3}, {Feature::RingGain}, "ring_bias"},
                    Known{"Speckle", {.speckle = 0.2}, {Feature::IntensityScatter}, "speckle"},
                    Known{"MixedPixels", {.mixed = 0.8}, {Feature::Mixed}, "footprint"}),
    [](const auto& known) { return std::string(known.param.name); });

TEST(Compare, TheScaleOfIntensitiesIsNoDifference) {
  const SetComparison found = compareSets(setOf({}, 1), setOf({.scale = 255}, 1));
  for (const Separation& s : found.features) EXPECT_LT(s.strength, 1e-3) << kPatchFeatures[s.feature].name;
}

// Figures against the closed forms of the place.
TEST(Compare, FiguresOfASetAreThoseOfThePlace) {
  const ScanSet plain = setOf({}, 1);
  EXPECT_EQ(figureOf(plain, "returns"), 1);
  EXPECT_EQ(figureOf(plain, "missing_below"), 0);
  EXPECT_LT(figureOf(plain, "ground_residual"), 0.03);
  EXPECT_LT(figureOf(plain, "mixed"), 0.01);
  EXPECT_LT(figureOf(plain, "ring_offset"), 0.001);
  EXPECT_LT(figureOf(plain, "ring_gain"), 0.01);
  // |z - mean of 4| of normal numbers: the median is 0.6745 sqrt(1 + 1/4) sigma.
  EXPECT_NEAR(figureOf(plain, "intensity_scatter"), 0.6745 * std::sqrt(1.25) * 0.05, 0.003);

  const ScanSet flawed = setOf({.lost = 0.04, .ringOffset = 0.03, .ringGain = 0.2, .mixed = 0.5}, 1);
  EXPECT_NEAR(figureOf(flawed, "returns"), 0.96, 0.003);
  EXPECT_NEAR(figureOf(flawed, "missing_below"), 0.04, 0.004);
  EXPECT_NEAR(figureOf(flawed, "missing_single"), 0.96 * 0.96, 0.03);
  EXPECT_EQ(figureOf(flawed, "missing_in_runs"), 0);
  EXPECT_GT(figureOf(flawed, "mixed"), 0.15);
  // A ring against the mean of those beside it: offsets show where the wall is met, gains everywhere.
  EXPECT_NEAR(figureOf(flawed, "ring_offset"), 0.03 * spreadAgainstNeighbours(kOffsets, 1, 11), 0.01);
  EXPECT_NEAR(figureOf(flawed, "ring_gain"), 0.2 * spreadAgainstNeighbours(kGains, 1, kTestRings - 1), 0.05);
}

// Along a ring, the range of the round wall is 18 m / cos(elevation) and an error z0; z0 - (z1 + z2) / 2 of normal
// errors of deviation sigma is normal, of deviation sqrt(1.5) sigma.
TEST(Compare, SurfacesAreThoseOfThePlace) {
  const SetComparison found = compareSets(setOf({.sigma = 0.02}, 1), setOf({.sigma = 0.04, .lost = 0.06}, 11));
  const auto wall = std::ranges::find(found.groups, "wall", &GroupComparison::name);
  ASSERT_NE(wall, found.groups.end());
  ASSERT_EQ(wall->surfaces.size(), 1u);
  EXPECT_EQ(wall->surfaces[0].band, "15 to 30 m");
  const SurfaceFigures &real = wall->surfaces[0].real, &simulated = wall->surfaces[0].simulated;
  const double step = radians(30.0 / (kTestRings - 1));
  for (const auto& [quantile, figure] : {std::pair(0.6745, 0), {1.1503, 1}, {1.6449, 2}}) {
    EXPECT_NEAR(real[figure], quantile * std::sqrt(1.5) * 20, 1) << figure;
    EXPECT_NEAR(simulated[figure], quantile * std::sqrt(1.5) * 40, 2) << figure;
  }
  EXPECT_EQ(real[3] + real[4] + real[5], 0);  // nothing beyond half a metre, nothing lost
  EXPECT_NEAR(simulated[5], 6, 0.6);
  EXPECT_LT(real[6], 18 * step * std::tan(radians(7)));
  EXPECT_GT(found.surfacesAlike().second, found.surfacesAlike().first);
}

// Two beams make a pixel of 1/1024 turn.
TEST(Compare, PixelsHaveTheNearestReturnOfTheirBeams) {
  constexpr std::uint32_t kColumns = 2048;
  Scan scan;
  scan.rings = 1;
  scan.columns = kColumns;
  for (std::uint32_t c = 0; c < kColumns; ++c) {
    const double azimuth = 2 * kPi * c / kColumns, range = c % 2 == 0 ? 10 : 11;
    scan.position.push_back(
        {static_cast<float>(range * std::cos(azimuth)), static_cast<float>(range * std::sin(azimuth)), 0});
    scan[kRing].push_back(0);
    scan[kColumn].push_back(static_cast<std::uint16_t>(c));
  }
  const Patches patches = patchesOf(scan, rangeGrid(scan), 0);
  ASSERT_EQ(patches.size(), kColumns);
  for (std::size_t i = 0; i < patches.size(); ++i) {
    EXPECT_EQ(patches.beside[i].isPixel, patches.range[i] < 10.5f);
    EXPECT_NEAR(patches.beside[i].range[PixelNeighbours::kLeft], 10, 1e-4);
    EXPECT_NEAR(patches.beside[i].range[PixelNeighbours::kRight], 10, 1e-4);
    EXPECT_TRUE(std::isnan(patches.beside[i].range[PixelNeighbours::kAbove]));
  }
}

// A long run is no drop-out of single beams.
TEST(Compare, RunsOfMissingBeamsAreToldFromSingleOnes) {
  Scan scan = flawedScan({}, 1);
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (scan[kColumn][i] >= 700 || scan[kColumn][i] < 20) scan.position[i].x = NAN;  // a run of 40 across the seam
  }
  const ScanSet set = measureScans("cut", {withoutMisses(scan)}, {});
  EXPECT_NEAR(figureOf(set, "missing_below"), 40.0 / 720, 1e-9);
  EXPECT_EQ(figureOf(set, "missing_in_runs"), 1);
  EXPECT_EQ(figureOf(set, "missing_single"), 0);
}

TEST(Compare, ClassesMeetByTheirNamesAndAliases) {
  Ontology other = testClasses();
  other.classes[1].id = 40;
  other.classes[2].id = 50;
  other.classes[3] = {60, "lamp", {}, false, {}, {}};
  std::vector<Scan> scans = flawedScans({}, 11);
  for (Scan& scan : scans) {
    for (std::uint16_t& label : scan[kLabel]) label = static_cast<std::uint16_t>(30 + 10 * label);
  }
  Ontology real = testClasses();
  real.classes[2].aliases = {"facade"};
  other.classes[2].name = "facade";
  const SetComparison found = compareSets(measureScans("a", flawedScans({}, 1), real), measureScans("b", scans, other));
  ASSERT_TRUE(found.byClass);
  EXPECT_THAT(found.unknownClasses, ElementsAre("lamp"));
  for (const GroupComparison& group : found.groups) {
    if (group.name == "ground" || group.name == "wall") {
      EXPECT_NEAR(group.realShare, group.simulatedShare, 0.02) << group.name;
      EXPECT_FALSE(group.features.empty());
    } else {
      EXPECT_TRUE(group.features.empty()) << group.name;
    }
  }
}

// Posts are walls to one of the two: whichever comes first, walls are held against walls and posts.
TEST(Compare, TheCoarserClassesHoldWhicheverSetComesFirst) {
  Ontology coarse = testClasses();
  coarse.classes.pop_back();
  coarse.classes[2].aliases = {"post"};
  std::vector<Scan> scans = flawedScans({}, 11);
  for (Scan& scan : scans) {
    for (std::uint16_t& label : scan[kLabel]) label = std::min<std::uint16_t>(label, 2);
  }
  const auto fine = [] { return measureScans("fine", flawedScans({}, 1), testClasses()); };
  const auto other = [&] { return measureScans("coarse", scans, coarse); };
  for (const SetComparison& found : {compareSets(fine(), other()), compareSets(other(), fine())}) {
    ASSERT_TRUE(found.byClass);
    EXPECT_TRUE(found.unknownClasses.empty());
    ASSERT_EQ(found.groups.size(), 2u);
    for (const GroupComparison& group : found.groups) EXPECT_NEAR(group.realShare, group.simulatedShare, 0.02);
  }
}

TEST(Compare, UnlikeSensorsAreToldOf) {
  std::vector<Scan> halves = flawedScans({}, 11);
  for (Scan& scan : halves) {
    scan.rings = kTestRings / 2;
    for (std::uint16_t& ring : scan[kRing]) ring = static_cast<std::uint16_t>(ring / 2);
  }
  const SetComparison found = compareSets(setOf({}, 1), measureScans("halves", halves, testClasses()));
  EXPECT_THAT(found.warnings, ElementsAre(HasSubstr("set has 32 rings, but halves has 16")));
  EXPECT_TRUE(compareSets(setOf({}, 1), setOf({}, 11)).warnings.empty());
}

TEST(Compare, IsTheSameWhateverTheThreads) {
  std::string first;
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    const std::string json = comparisonJson(compareSets(setOf({}, 1), setOf({.sigma = 0.01}, 11)), "2026-01-01");
    if (first.empty()) first = json;
    EXPECT_EQ(json, first);
  }
  const nlohmann::json parsed = nlohmann::json::parse(first);
  EXPECT_EQ(parsed["grouped_by"], "class");
  EXPECT_EQ(parsed["features"].size(), kFeatureCount);
  EXPECT_TRUE(std::ranges::is_sorted(parsed["features"], {}, [](const auto& f) { return f["only_scene"]; }));
  EXPECT_EQ(parsed["figures"].size(), kSetFigureCount);
  EXPECT_EQ(parsed["road_pose"].size(), kRoadFigureCount);
}

// A sensor that turns more slowly than frames follow each other has no scan in some samples.
TEST(Compare, PassesOverSamplesWithoutTheFirstSensor) {
  const TemporaryFolder folder;
  PackedDataset writer(folder.path() / "slow", false, 1 << 20);
  Manifest manifest = testManifest();
  for (std::uint32_t i = 0; i < 3; ++i) {
    Sample sample = testSample(manifest, i, "drive-00000" + std::to_string(i), "train");
    if (i == 0) {
      std::erase_if(sample.scans, [&](const ScanRecord& s) { return s.sensor == manifest.sensors[0].name; });
      std::erase_if(sample.files, [](const auto& m) { return m.suffix.starts_with("top."); });
    }
    writer.add(sample);
  }
  writer.finish(manifest);
  Progress progress("test", 3, "scans", "points", true);
  const ScanSet set = readScanSet(folder.path() / "slow", {}, progress);
  EXPECT_EQ(set.scans, 2u);
  EXPECT_EQ(set.rows, manifest.sensors[0].beams.rings);
  EXPECT_EQ(readScanSet(folder.path() / "slow", {.sensor = "rear"}, progress).scans, 3u);
  EXPECT_THROW(readScanSet(folder.path() / "slow", {.sensor = "nothing"}, progress), InputError);
}

// What was measured on the recording by other means (lidar/real_statistics.md): 82 % of the beams return, 7.9 % of
// those below the horizon do not, of which half in runs of more than ten.
TEST(Compare, FiguresOfARealRecordingAreKnown) {
  SKIP_WITHOUT_SHARED_DATA("lidar/ouster_os1_128");
  Progress progress("test", 3, "scans", "points", true);
  const ScanSet set = readScanSet(sharedData() / "lidar/ouster_os1_128", {}, progress);
  EXPECT_EQ(set.scans, 3u);
  EXPECT_TRUE(set.knowsRings && set.knowsMisses);
  EXPECT_NEAR(figureOf(set, "returns"), 0.82, 0.005);
  EXPECT_NEAR(figureOf(set, "missing_below"), 0.079, 0.01);
  EXPECT_NEAR(figureOf(set, "missing_in_runs"), 0.48, 0.05);
  EXPECT_NEAR(set.roadPose[kHeight].median, 1.99, 0.01);
}

}  // namespace
}  // namespace scanmill
