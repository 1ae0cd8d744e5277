#include "study/noise/fit_noise.h"

#include <fmt/core.h>

#include <limits>

#include "base/error.h"
#include "base/file.h"
#include "base/parallel.h"
#include "base/random.h"
#include "formats/format.h"
#include "tests/studio/study/noise/noise_scans.h"
#include "tests/support/message_of.h"
#include "tests/support/noisy_walls.h"
#include "tests/support/shared_data.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::vector<double> kDistances{3.5, 6, 8.5, 11, 13.5, 17, 22, 27};

NoiseFit fitOf(const std::vector<Scan>& scans, const BeamTable& beams) {
  const std::vector<RecordedScan> recorded = recordedOf(scans, beams);
  return fitNoise(beams, recorded, findFlatPatches(beams, recorded));
}

// Sigma (m) of the used band whose mean range is nearest to `range`.
double sigmaNear(const NoiseFit& fit, double range) {
  const std::vector<const PatchGroup*> used = fit.usedBands();
  return (*std::ranges::min_element(used, {}, [&](const PatchGroup* b) { return std::abs(b->range - range); }))->sigma;
}

struct Truth {
  const char* name;
  const char* effects;
  double base;
  double growth;
  double dropOut;
  double step;
};

void PrintTo(const Truth& truth, std::ostream* out) {
  *out << truth.name;
}

class FitsNoise : public testing::TestWithParam<Truth> {};

// Every band within four standard errors and 6 per cent of the truth, and all together without bias.
void expectTruth(const NoiseFit& fit, const Truth& truth) {
  double weighted = 0;
  double weights = 0;
  for (const PatchGroup* band : fit.usedBands()) {
    const double sigma = truth.base + truth.growth * band->range;
    EXPECT_NEAR(band->sigma, sigma, 4 * band->error) << band->name;
    EXPECT_NEAR(band->sigma, sigma, 0.06 * sigma) << band->name;
    EXPECT_NEAR(band->unevenness, 1, 0.5) << band->name;
    weighted += (band->sigma / sigma - 1) / (band->error * band->error) * sigma * sigma;
    weights += sigma * sigma / (band->error * band->error);
  }
  EXPECT_GE(fit.usedBands().size(), 5u);
  EXPECT_NEAR(weighted / weights, 0, 0.015);
}

TEST_P(FitsNoise, FindsTheTruth) {
  const Truth& truth = GetParam();
  const auto beams = wallBeams();
  const NoiseFit fit = fitOf(wallScans(beams, kDistances, truth.effects), *beams);
  expectTruth(fit, truth);
  EXPECT_TRUE(fit.linear);
  EXPECT_NEAR(fit.base, truth.base, 4 * fit.baseError);
  EXPECT_NEAR(fit.growth, truth.growth, 4 * fit.growthError);
  EXPECT_NEAR(fit.step, truth.step, 1e-6);
  EXPECT_NEAR(fit.dropOut.share(), truth.dropOut, 4 * fit.dropOut.error + 1e-9);
  EXPECT_LT(fit.dropOut.error, 0.005);
}

INSTANTIATE_TEST_SUITE_P(
    , FitsNoise,
    testing::Values(
        Truth{"Stepped",
              "[range_noise: {sigma_m: 0.006, sigma_per_m: 0.0004}, dropout: {probability: 0.01}, quantize: {step_m: "
              "0.008}]",
              0.006, 0.0004, 0.01, 0.008},
        Truth{"Constant", "[range_noise: {sigma_m: 0.02}]", 0.02, 0, 0, 0},
        Truth{"Growing", "[range_noise: {sigma_per_m: 0.002}, dropout: {probability: 0.06}, quantize: {step_m: 0.003}]",
              0, 0.002, 0.06, 0.003}),
    [](const auto& truth) { return truth.param.name; });

// Noise that falls, then rises: no line.
TEST(FitNoise, GivesATableWhereNoLineFits) {
  const auto beams = wallBeams();
  const NoiseFit fit = fitOf(
      wallScans(beams, kDistances, "[range_noise: {table: [[4, 0.03], [9, 0.008], [14, 0.008], [20, 0.03]]}]"), *beams);
  EXPECT_FALSE(fit.linear);
  EXPECT_NEAR(sigmaNear(fit, 11), 0.008, 0.001);
  EXPECT_NEAR(sigmaNear(fit, 100), 0.03, 0.002);
  EXPECT_THAT(effectsYaml(fit, "2026-01-01"), HasSubstr("range_noise: {table: [["));
}

// Posts of 0.3 m radius all round: the patches on them bend by several millimetres, which is no noise.
TEST(FitNoise, CurvedSurfacesDoNotCount) {
  constexpr double kSigma = 0.008;
  constexpr double kRadius = 0.3;
  const auto beams = wallBeams();
  const auto post = [&](std::size_t beam) {
    const Vec3d& u = beams->direction[beam];
    double nearest = INFINITY;
    for (int i = -2; i <= 2; ++i) {
      const double azimuth = radians(18.0 * i);
      const double distance = 2.7 + 0.1 * i;
      const Vec3d axis{distance * std::cos(azimuth), distance * std::sin(azimuth), 0};
      const double flat = u.x * u.x + u.y * u.y;
      const double along = (u.x * axis.x + u.y * axis.y) / flat;
      const double inside = along * along - (distance * distance - kRadius * kRadius) / flat;
      if (inside > 0) nearest = std::min(nearest, along - std::sqrt(inside));
    }
    return nearest < 10 ? static_cast<float>(nearest) : kMiss;
  };
  auto centred = std::make_shared<BeamTable>(*beams);
  centred->originOffset = 0;
  fillBeams(*centred);
  std::vector<Scan> scans;
  for (std::uint32_t i = 0; i < 6; ++i) {
    scans.push_back(noisyScan(centred, post, "[range_noise: {sigma_m: 0.008}]", i));
  }
  const NoiseFit fit = fitOf(scans, *centred);
  ASSERT_GE(fit.patches, 50u);
  for (const PatchGroup* band : fit.usedBands()) {
    EXPECT_NEAR(band->sigma, kSigma, 0.06 * kSigma) << band->name;
    EXPECT_GT(band->planeSigma, 1.1 * kSigma) << "the posts must be bent enough for the test to tell";
  }
}

// Half of each scan is foliage, in front of it and behind: windows there are many and not flat.
TEST(FitNoise, FoliageDoesNotCount) {
  const auto beams = wallBeams();
  std::vector<Scan> scans;
  for (std::uint32_t i = 0; i < 6; ++i) {
    scans.push_back(noisyScan(
        beams,
        [&](std::size_t beam) {
          const RandomBlock random = randomBlock({.seed = 5, .frame = i, .beam = static_cast<std::uint32_t>(beam)});
          const float wall = wallRange(*beams, beam, 9 + i, 0);
          const bool leaf = beam % beams->columns < beams->columns * 2 / 3;
          return leaf ? static_cast<float>(8 + i + 0.4 * uniform(random[0])) : wall;
        },
        "[range_noise: {sigma_m: 0.01}]", i));
  }
  const NoiseFit fit = fitOf(scans, *beams);
  for (const PatchGroup* band : fit.usedBands()) EXPECT_NEAR(band->sigma, 0.01, 0.0008) << band->name;
}

TEST(FitNoise, IsTheSameWithAnyNumberOfThreads) {
  const auto beams = wallBeams();
  const std::vector<Scan> scans =
      wallScans(beams, {8, 11}, "[range_noise: {sigma_m: 0.01}, dropout: {probability: 0.02}]");
  const std::string all = effectsYaml(fitOf(scans, *beams), "today");
  const ThreadLimit one(1);
  EXPECT_EQ(effectsYaml(fitOf(scans, *beams), "today"), all);
}

TEST(FitNoise, NeedsFlatSurfaces) {
  const auto beams = wallBeams();
  const Scan noise = noisyScan(
      beams,
      [&](std::size_t beam) {
        return static_cast<float>(5 + 20 * uniform(randomBlock({.beam = static_cast<std::uint32_t>(beam)})[0]));
      },
      "[]", 0);
  EXPECT_THAT(messageOf([&] { fitOf({noise}, *beams); }),
              AllOf(HasSubstr("scan0.pcd"), HasSubstr("flat patches"), HasSubstr("give more scans")));
}

TEST(RangesAlong, FindTheFrameByThemselves) {
  const auto beams = wallBeams();
  Scan scan = noisyScan(
      beams, [&](std::size_t beam) { return wallRange(*beams, beam, 12, 0); }, "[quantize: {step_m: 0.004}]", 0);
  const RecordedScan plain = rangesAlong(scan, *beams, "plain");
  const Pose moved{fromYawPitchRoll(2.5, 0.1, -0.05), {0.3, -0.2, 1.7}};
  for (Vec3f& p : scan.position) p = static_cast<Vec3f>(moved * static_cast<Vec3d>(p));
  const RecordedScan turned = rangesAlong(scan, *beams, "turned");
  EXPECT_NEAR(length(turned.scanFromSensor.translation - moved.translation), 0, 1e-4);
  expectSameRanges(turned, plain, 2e-5);
  EXPECT_NEAR(rangeStep({turned}), 0.004, 1e-7);
}

TEST(RangesAlong, TakesDenseScansByRingAndColumn) {
  const auto beams = wallBeams();
  const auto range = [&](std::size_t beam) { return wallRange(*beams, beam, 12, 0); };
  const RecordedScan organised = rangesAlong(noisyScan(beams, range, "[dropout: {probability: 0.3}]", 0), *beams, "a");
  Scan dense = noisyScan(beams, range, "[dropout: {probability: 0.3}]", 0, false);
  expectSameRanges(rangesAlong(dense, *beams, "b"), organised, 1e-5);
  dense[kRing].clear();
  EXPECT_THAT(messageOf([&] { rangesAlong(dense, *beams, "b.pcd"); }), AllOf(HasSubstr("b.pcd"), HasSubstr("ring")));
}

// Files of KITTI and nuScenes have rings and no columns.
TEST(RangesAlong, FindColumnsByAzimuth) {
  const auto fullTurn = std::make_shared<BeamTable>(*wallBeams());
  fullTurn->columns = 1500;  // 2 pi / step rounds to more than this
  fullTurn->field = 2 * kPi;
  fullTurn->firstAzimuth = -kPi;
  fillBeams(*fullTurn);
  for (const std::shared_ptr<const BeamTable>& beams : {wallBeams(), std::shared_ptr<const BeamTable>(fullTurn)}) {
    const auto range = [&](std::size_t beam) { return wallRange(*beams, beam, 12, 0.2); };
    Scan scan = noisyScan(beams, range, "[range_noise: {sigma_m: 0.01}, dropout: {probability: 0.3}]", 0, false);
    const RecordedScan known = rangesAlong(scan, *beams, "a");
    scan[kColumn].clear();
    for (std::uint16_t& ring : scan[kRing]) ring = static_cast<std::uint16_t>(beams->rings - 1 - ring);  // from below
    expectSameRanges(rangesAlong(scan, *beams, "b"), known, 1e-5);
  }
}

TEST(RangesAlong, RefuseWhatIsNoScanOfTheSensor) {
  const auto beams = wallBeams();
  const auto refusal = [&](const Scan& scan, const BeamTable& own) {
    return messageOf([&] { rangesAlong(scan, own, "x.pcd"); });
  };
  const Scan good = noisyScan(
      beams, [&](std::size_t beam) { return wallRange(*beams, beam, 12, 0); }, "[]", 0);
  EXPECT_THAT(refusal({}, *beams), AllOf(HasSubstr("x.pcd"), HasSubstr("no point")));

  Scan missed = good;
  for (Vec3f& p : missed.position) p.x = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(refusal(missed, *beams), HasSubstr("0 returns"));

  auto other = std::make_shared<BeamTable>(*beams);
  other->columns = 128;
  fillBeams(*other);
  EXPECT_THAT(refusal(good, *other), AllOf(HasSubstr("64 x 256"), HasSubstr("64 rings x 128 columns")));

  other->columns = 256;
  for (double& offset : other->azimuthOffset) offset = -offset;
  fillBeams(*other);
  EXPECT_THAT(refusal(good, *other), HasSubstr("do not lie on the beams of wall watcher"));
}

TEST(RangeStep, IsNotSeenWhereThereIsNone) {
  const auto beams = wallBeams();
  EXPECT_EQ(rangeStep(recordedOf(wallScans(beams, {9, 14}, "[range_noise: {sigma_m: 0.01}]"), *beams)), 0);
  EXPECT_EQ(rangeStep({}), 0);
  for (const double step : {0.001, 0.004, 0.05}) {
    const std::string effects = "[range_noise: {sigma_m: 0.01}, quantize: {step_m: " + std::to_string(step) + "}]";
    EXPECT_NEAR(rangeStep(recordedOf(wallScans(beams, {9, 14}, effects), *beams)), step, 1e-6);
  }
}

TEST(WithEffects, ReplacesTheListAndNothingElse) {
  const std::string fitted = "effects:\n  # new\n  - range_noise: {sigma_m: 0.008}\n";
  const std::string added = withEffects(kWallSensor, "s.yaml", fitted);
  EXPECT_EQ(added, std::string(kWallSensor) + fitted);
  EXPECT_EQ(withEffects(added, "s.yaml", fitted), added);

  const std::string before =
      "# head\nmodel: a\n\neffects:\n# old\n- range_noise: {sigma_m: 1}\n  # old too\n\n# of the columns\ncolumns: 4 # "
      "four\nelevation_deg: [1]\n# end\n";
  EXPECT_EQ(withEffects(before, "s.yaml", fitted),
            "# head\nmodel: a\n\n" + fitted + "\n# of the columns\ncolumns: 4 # four\nelevation_deg: [1]\n# end\n");
  EXPECT_EQ(withEffects("elevation_deg: [1]\neffects: [quantize: {step_m: 1},\n  dropout: {probability: 1}]", "s.yaml",
                        fitted),
            "elevation_deg: [1]\n" + fitted);
  EXPECT_THAT(messageOf([&] { withEffects("{model: a, elevation_deg: [1]}", "s.yaml", fitted); }),
              HasSubstr("a line of its own"));
  EXPECT_THAT(messageOf([&] { withEffects("scenes: []\n", "s.yaml", fitted); }), HasSubstr("pipeline"));
  EXPECT_THAT(messageOf([&] { withEffects("", "s.yaml", fitted); }), HasSubstr("not a sensor file"));
}

// What is written is read back as the beam table that it was, with effects that a pipeline can make.
TEST(WithEffects, LeavesTheBeamsAsTheyWere) {
  const auto beams = wallBeams();
  const NoiseFit fit =
      fitOf(wallScans(beams, kDistances,
                      "[range_noise: {sigma_m: 0.01}, dropout: {probability: 0.02}, quantize: {step_m: 0.008}]"),
            *beams);
  const Value sensor =
      parseYaml(withEffects(kWallSensor, "s.yaml", "effects:\n" + effectsYaml(fit, "today")), "s.yaml");
  const auto again = makeBeams(sensor);
  EXPECT_EQ(again->direction, beams->direction);
  std::vector<std::string> names;
  for (const Value& item : sensor.find("effects")->items) {
    names.push_back(item.entries.front().key);
    Fields options(item.entries.front().value, "effect");
    EXPECT_NE(requireEffect(names.back(), item.where).make(options), nullptr);
  }
  EXPECT_THAT(names, testing::ElementsAre("dropout", "range_noise", "quantize"));
}

// A sensor and a place of which others' figures are known: 7 mm at 5-10 m, 8 mm at 10-20 m, 17 mm at 20-30 m.
TEST(FitNoise, OfARealSensor) {
  SKIP_WITHOUT_SHARED_DATA("lidar/ouster_os1_128/frame_1797.pcd");
  const auto beams = makeBeams(readYaml(std::filesystem::path(SCANMILL_SOURCE_DIR) / "pipelines/sensors/os1_128.yaml"));
  Value none;
  Fields options(none, "format");
  const auto format = formatBySuffix("pcd")->make(options);
  std::vector<Scan> scans;
  for (const char* name : {"frame_1795.pcd", "frame_1796.pcd", "frame_1797.pcd"}) {
    const auto file = sharedData() / "lidar/ouster_os1_128" / name;
    scans.push_back(format->decode(readFile(file), file.string()));
  }
  const std::vector<RecordedScan> recorded = recordedOf(scans, *beams);
  for (const RecordedScan& scan : recorded) {
    // The recording's frame is the lidar's: half a turn and 36.18 mm from the sensor's.
    EXPECT_NEAR(std::abs(scan.scanFromSensor.rotation.z), 1, 1e-6);
    EXPECT_NEAR(scan.scanFromSensor.translation.z, -0.03618, 1e-5);
  }
  const NoiseFit fit = fitNoise(*beams, recorded, findFlatPatches(*beams, recorded));
  EXPECT_NEAR(fit.step, 0.008, 1e-6);
  EXPECT_NEAR(static_cast<double>(fit.returns) / static_cast<double>(fit.beams), 0.82, 0.005);
  EXPECT_GT(fit.patches, 1000u);
  std::size_t near = 0;
  for (const PatchGroup* band : fit.usedBands()) {
    if (band->range < 5 || band->range > 20) continue;
    ++near;
    EXPECT_GT(band->sigma, 0.003) << band->name;
    EXPECT_LT(band->sigma, 0.025) << band->name;
    EXPECT_LT(band->error, 0.1 * band->sigma) << band->name;
  }
  EXPECT_GE(near, 3u);
  EXPECT_NEAR(sigmaNear(fit, 9), 0.007, 0.002);
  EXPECT_GT(sigmaNear(fit, 25), sigmaNear(fit, 12));
  EXPECT_LT(fit.dropOut.share(), 0.02);
  const std::string effects = effectsYaml(fit, "today");
  EXPECT_THAT(effects, AllOf(HasSubstr("# Measured up to 28 m; from there to 120 m the last value is used."),
                             HasSubstr("# At 30-40 m the noise is 44 mm")));
}

TEST(FitNoise, SaysWhereItsModelEnds) {
  const auto beams = wallBeams();  // reaches 120 m
  const NoiseFit one = fitOf(wallScans(beams, {8.5, 8.5, 8.5}, "[range_noise: {sigma_m: 0.01}]"), *beams);
  const std::string effects = effectsYaml(one, "today");
  ASSERT_FALSE(beyondMeasured(one).empty());
  EXPECT_THAT(effects, HasSubstr("# " + beyondMeasured(one).front() + "\n"));
  EXPECT_THAT(beyondMeasured(one).front(),
              AllOf(HasSubstr(fmt::format("up to {:.0f} m", one.usedBands().back()->range)), HasSubstr("120 m")));
  NoiseFit near = one;
  near.sensorReach = one.usedBands().back()->range;
  EXPECT_TRUE(beyondMeasured(near).empty());
}

}  // namespace
}  // namespace scanmill
