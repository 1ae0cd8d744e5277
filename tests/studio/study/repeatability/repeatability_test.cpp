#include "study/repeatability/repeatability.h"

#include <nlohmann/json.hpp>
#include <random>

#include "base/file.h"
#include "base/parallel.h"
#include "tests/studio/study/repeatability/repeated_scans.h"
#include "tests/support/two_returns.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

// What two noisy scans of a plane have for a fitness: points on a grid, each moved to a sphere around it, all
// distances.
double shellFitness(double spacing, double radius, unsigned seed) {
  constexpr int kSide = 40;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto cloud = [&] {
    std::vector<Vec3d> points;
    for (int i = 0; i < kSide; ++i) {
      for (int j = 0; j < kSide; ++j) {
        const Vec3d direction = normalized(Vec3d{normal(random), normal(random), normal(random)});
        points.push_back(Vec3d{0, i * spacing, j * spacing} + direction * radius);
      }
    }
    return points;
  };
  const std::vector<Vec3d> a = cloud();
  const std::vector<Vec3d> b = cloud();
  double sum = 0;
  for (const Vec3d& p : a) {
    double least = INFINITY;
    for (const Vec3d& q : b) least = std::min(least, dot(p - q, p - q));
    sum += least;
  }
  return sum / static_cast<double>(a.size());
}

TEST_F(RepeatedScans, ShellNoiseHasTheFitnessOfFirstPrinciples) {
  const Repeatability& result = shells();
  ASSERT_EQ(result.views.size(), 1u);
  ASSERT_EQ(result.views[0].poses.size(), 3u);
  for (const RepeatedPose& pose : result.views[0].poses) {
    const double spacing = pose.distance * radians(1);
    // Far sparser than the noise: every point finds its own again, and two directions are independent: 2 r^2.
    EXPECT_NEAR(result.at(pose, 1, 1).unmoved.mean, 2e-6, 0.1e-6) << pose.distance;
    EXPECT_NEAR(result.at(pose, 3, 3).unmoved.mean, 2e-6 * pose.distance * pose.distance,
                0.06 * 2e-6 * pose.distance * pose.distance);
    EXPECT_NEAR(result.at(pose, 1, 0).unmoved.mean, 1e-6, 1e-8);
    // As dense as the noise: a neighbour may be nearer.
    const double expected = shellFitness(spacing, 0.04, 1);
    EXPECT_LT(result.at(pose, 2, 2).unmoved.mean, 1.05 * 32e-4);
    if (pose.points[2].mean > 200) {
      EXPECT_NEAR(result.at(pose, 2, 2).unmoved.mean, expected, 0.12 * expected) << pose.distance;
    }
  }
}

TEST_F(RepeatedScans, NoNoiseIsPerfectAgreement) {
  const Repeatability& result = shells();
  for (const RepeatedPose& pose : result.views[0].poses) {
    EXPECT_EQ(result.at(pose, 0, 0).unmoved.mean, 0);
    EXPECT_LT(result.at(pose, 0, 0).registered.mean, 1e-10);
    EXPECT_EQ(result.at(pose, 0, 0).unmoved.count, 20u);
    EXPECT_EQ(result.at(pose, 0, 1).pairs, 20u);
  }
}

// The poses are the same: what ICP finds is noise.
TEST_F(RepeatedScans, IcpFitsAwayALittleOfTheNoise) {
  const Repeatability& result = shells();
  for (const RepeatedPose& pose : result.views[0].poses) {
    for (const std::size_t level : {1u, 2u, 3u}) {
      const LevelFitness& cell = result.at(pose, level, level);
      EXPECT_EQ(cell.registered.count, 20u);
      EXPECT_LT(cell.registered.mean, cell.unmoved.mean);
      EXPECT_GT(cell.registered.mean, 0.8 * cell.unmoved.mean);
      EXPECT_LE(cell.registered.low, cell.registered.mean);
      EXPECT_GE(cell.registered.high, cell.registered.mean);
      EXPECT_GT(cell.registered.deviation, 0);
    }
  }
}

// Rows and columns of beams are whole: half a row on either side, at most.
TEST_F(RepeatedScans, PointsFallWithTheSquareOfTheDistance) {
  const Repeatability& result = shells();
  for (const RepeatedPose& pose : result.views[0].poses) {
    const double across = std::min(2 * degrees(std::atan(1 / pose.distance)), 21.0);
    EXPECT_EQ(pose.object, "slab");
    EXPECT_NEAR(std::sqrt(pose.points[0].mean), across, 1.01);
    EXPECT_EQ(pose.points[0].least, pose.points[0].most);
  }
  const std::vector<RepeatedPose>& poses = result.views[0].poses;
  EXPECT_NEAR(poses[1].points[0].mean / poses[2].points[0].mean, 4, 1.1);
}

// A shell of more than the margin leaves the crop. Its heights are uniform (Archimedes): towards the sensor a quarter
// of the points of a shell of 20 cm passes 10 cm, and half of them 0; another 0.6 and 2.5 % at each of the four edges.
TEST_F(RepeatedScans, TheCropEndsAtTheMargin) {
  const std::string noise = "  noise: [{name: wide, effects: [{shell: {scale_m: 0.2}}]}]\n";
  const double all = measure(pipeline(noise + "  margin_m: 1\n")).views[0].poses[1].points[0].mean;
  const PointCount cut = measure(pipeline(noise + "  margin_m: 0.1\n")).views[0].poses[1].points[0];
  const PointCount none = measure(pipeline(noise + "  margin_m: 0\n")).views[0].poses[1].points[0];
  EXPECT_NEAR(cut.mean / all, 0.75 * std::pow(1 - 0.00625, 4), 0.02);
  EXPECT_NEAR(none.mean / all, 0.5 * std::pow(1 - 0.025, 4), 0.02);
  EXPECT_LT(cut.least, cut.most);
}

TEST_F(RepeatedScans, LooksAtTheNamedObject) {
  const Repeatability result = measure(pipeline("  object: crate\n"));
  for (const RepeatedPose& pose : result.views[0].poses) {
    EXPECT_EQ(pose.object, "crate");
    EXPECT_EQ(pose.points[0].mean, 0);  // it stands behind the sensor
    EXPECT_EQ(result.at(pose, 0, 0).unmoved.count, 0u);
    EXPECT_EQ(result.at(pose, 0, 0).registered.count, 0u);
  }
  EXPECT_NEAR(result.views[0].poses[0].distance, 36.5, 1e-6);
  ASSERT_EQ(result.warnings.size(), 1u);
  EXPECT_THAT(result.warnings[0], testing::AllOf(HasSubstr("no point hits crate from 3 of 3 poses"),
                                                 HasSubstr("0 (36.5 m), 1 (33.5 m), 2 (27.5 m)")));
  const nlohmann::json json = nlohmann::json::parse(repeatabilityJson(result));
  EXPECT_TRUE(json["views"][0]["places"][0]["fitness_m2"][0]["unmoved"].is_null());
}

TEST_F(RepeatedScans, UsesThePipelinesEffectsWhereNoLevelIsNamed) {
  const std::filesystem::path file = pipeline("  scans: 3\n", "effects: [{shell: {scale_m: 0.001}}]\n");
  const Repeatability result = measure(file);
  ASSERT_EQ(result.levels.size(), 1u);
  for (const RepeatedPose& pose : result.views[0].poses) {
    EXPECT_NEAR(result.at(pose, 0, 0).unmoved.mean, 2e-6, 0.15e-6);
    EXPECT_EQ(result.at(pose, 0, 0).pairs, 6u);
  }
}

// Losing points is a difference, too: what agrees perfectly is the same scan again.
TEST_F(RepeatedScans, WarnsOfScansThatAreAllTheSame) {
  const auto warnings = [&](const std::string& effects) {
    return measure(pipeline("  scans: 2\n", effects), {"trajectories.0.poses=[{position: [-3, 0, 0]}]"}).warnings;
  };
  EXPECT_THAT(warnings(""), testing::ElementsAre(HasSubstr("moves points (it has no effects)")));
  EXPECT_THAT(warnings("effects: [{quantize: {step_m: 0.01}}]\n"),
              testing::ElementsAre(HasSubstr("moves points (quantize)")));
  EXPECT_THAT(warnings("effects: [{range_noise: {sigma_m: 0.01}}]\n"), testing::IsEmpty());
  EXPECT_THAT(shells().warnings, testing::IsEmpty());  // its level `none` says so itself
}

TEST_F(RepeatedScans, MethodsAreMeasuredSideBySide) {
  const std::string methods = "  methods: [ray_tracing, {ray_tracing: {instancing: always}}]\n";
  const Repeatability result = measure(pipeline(kShells + methods));
  ASSERT_EQ(result.views.size(), 2u);
  EXPECT_THAT(result.methods, testing::ElementsAre("ray_tracing", "ray_tracing instancing=always"));
  EXPECT_EQ(result.views[0].name, result.views[1].name);
  for (std::size_t p = 0; p < 3; ++p) {
    EXPECT_EQ(result.views[0].poses[p].points[0].mean, result.views[1].poses[p].points[0].mean);
  }
}

TEST_F(RepeatedScans, ThreadsDoNotChangeAByteAndSeedsDo) {
  const std::filesystem::path file = pipeline(std::string(kShells) + "  scans: 3\n");
  const auto json = [&](int threads, const std::vector<std::string>& overrides) {
    const ThreadLimit limit(threads);
    return repeatabilityJson(measure(file, overrides));
  };
  const std::string one = json(1, {});
  EXPECT_EQ(json(2, {}), one);
  const nlohmann::json other = nlohmann::json::parse(json(2, {"seed=8"}));
  const nlohmann::json first = nlohmann::json::parse(one);
  EXPECT_NE(first["views"], other["views"]);
  EXPECT_EQ(other["seed"], 8);
}

TEST_F(RepeatedScans, TablesHoldEveryFigure) {
  const Repeatability result = measure(pipeline(std::string(kShells) + "  scans: 2\n"));
  const nlohmann::json json = nlohmann::json::parse(repeatabilityJson(result));
  EXPECT_EQ(json["noise"].size(), 4u);
  EXPECT_EQ(json["reference"], "1 mm");
  const nlohmann::json& place = json["views"][0]["places"][2];
  EXPECT_EQ(place["fitness_m2"].size(), 16u);
  EXPECT_EQ(place["fitness_m2"][6]["source"], "1 mm");
  EXPECT_EQ(place["fitness_m2"][6]["target"], "4 cm");
  EXPECT_EQ(place["fitness_m2"][6]["registered"]["mean"].get<double>(),
            result.views[0].poses[2].fitness[6].registered.mean);
}

TEST_F(RepeatedScans, RefusesWhatItCannotCompare) {
  expectRefusedAt("  scan: 5\n", {"p.yaml:11", "did you mean 'scans'?"});
  expectRefusedAt("  scans: 1\n", {"p.yaml:11", "scans"});
  expectRefusedAt("  noise: []\n", {"p.yaml:11", "noise must be a list"});
  expectRefusedAt("  noise: [{name: a, effects: [{shel: {}}]}]\n", {"p.yaml:11", "did you mean 'shell'?"});
  expectRefusedAt("  noise: [{name: a, effects: sensor}]\n", {"p.yaml:11", "has no effects: measure"});
  expectRefusedAt("  noise: [{name: a}]\n", {"p.yaml:11", "effects"});
  expectRefusedAt("  noise: [{name: a, effects: []}, {name: a, effects: []}]\n", {"p.yaml:11", "two noise levels"});
  expectRefusedAt("  noise: [{name: a, effects: []}]\n  reference: b\n", {"p.yaml:12", "unknown noise level 'b'"});
  expectRefusedAt("  margin_m: -1\n", {"p.yaml:11", "margin_m"});
  expectRefusedAt("  icp: {iterations: 0}\n", {"p.yaml:11", "iterations"});
  expectRefusedAt("  icp: {reach: 1}\n", {"p.yaml:11", "unknown key 'reach'"});
  expectInputError([&] { measure(pipeline("  object: cart\n")); }, {"wall.yaml", "no thing 'cart'", "crate"});
}

TEST_F(RepeatedScans, AStopEndsItWithAnError) {
  const Plan plan = makePlan(readPipeline(pipeline(kShells), {}));
  const std::atomic<bool> stop = true;
  EXPECT_THAT(messageOf<Error>([&] { measureRepeatability(plan, {.quiet = true, .stop = &stop}); }),
              HasSubstr("stopped"));
}

TEST(BoxedObject, DistanceIsToTheNearestSideEdgeOrCorner) {
  // A box of 2 x 4 x 6 m, turned by 90 degrees about z, twice as high, at (10, 0, 0).
  const Affine place{toMatrix(fromYawPitchRoll(kPi / 2, 0, 0)) * Mat3::scale({1, 1, 2}), {10, 0, 0}};
  const BoxedObject thing{"box", place, inverse(place), {{-1, -2, -3}, {1, 2, 3}}};
  EXPECT_NEAR(thing.distance({10, 0, 0}), 0, 1e-12);
  EXPECT_NEAR(thing.distance({7, 0, 0}), 1, 1e-12);
  EXPECT_NEAR(thing.distance({10, 3, 0}), 2, 1e-12);
  EXPECT_NEAR(thing.distance({10, 0, 7}), 1, 1e-12);
  EXPECT_NEAR(thing.distance({15, 5, 6}), 5, 1e-12);
  EXPECT_NEAR(thing.distance({15, 5, 8}), std::sqrt(29.0), 1e-12);
}

// Beams have two returns, one or none. The crop is as large as the scan: every return is compared.
TEST_F(RepeatedScans, EveryReturnOfABeamIsCompared) {
  const Repeatability result =
      measure(withTwoReturns(readPipeline(pipeline("  scans: 3\n  object: slab\n  margin_m: 50\n  noise:\n"
                                                   "    - {name: none, effects: []}\n"
                                                   "    - {name: 1 cm, effects: [{range_noise: {sigma_m: 0.01}}]}\n"
                                                   "    - {name: lossy, effects: [{dropout: {probability: 0.25}}]}\n"),
                                          {}),
                             "{near_m: 3, gap_m: 2}"));
  EXPECT_EQ(result.methods, std::vector<std::string>{"two_returns near_m=3 gap_m=2"});
  ASSERT_EQ(result.views.size(), 1u);
  ASSERT_EQ(result.views[0].poses.size(), 3u);
  for (const RepeatedPose& pose : result.views[0].poses) {
    std::uint64_t returns = 0;
    for (std::uint32_t beam = 0; beam < 21 * 21; ++beam) returns += returnsOfBeam(beam, pose.frame);
    EXPECT_EQ(pose.points[0].least, returns);
    EXPECT_EQ(pose.points[1].mean, static_cast<double>(returns));
    EXPECT_NEAR(pose.points[2].mean, 0.75 * static_cast<double>(returns), 0.06 * static_cast<double>(returns));
    EXPECT_EQ(result.at(pose, 0, 0).unmoved.mean, 0);
    // The expected value is that of two noisy ranges, each with a deviation of 1 cm; neighbours are farther away.
    EXPECT_NEAR(result.at(pose, 1, 1).unmoved.mean, 2e-4, 0.3e-4);
  }
}

}  // namespace
}  // namespace scanmill
