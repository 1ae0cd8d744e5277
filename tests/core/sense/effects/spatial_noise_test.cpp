#include "sense/effects/spatial_noise.h"

#include "tests/core/sense/world.h"

namespace scanmill {
namespace {

// The field at as many positions as wanted, in cubes of 1 m.
std::vector<double> fieldAt(const std::vector<Vec3d>& points, std::uint64_t seed = 1, std::uint32_t number = 0) {
  std::vector<double> values;
  SpatialField field(seed, Purpose::Test, number);
  Positions positions{};
  Batch<double> ones;
  ones.fill(1);
  for (std::size_t first = 0; first < points.size(); first += kBatch) {
    const std::size_t count = std::min(kBatch, points.size() - first);
    for (std::size_t i = 0; i < count; ++i) {
      positions.x[i] = points[first + i].x;
      positions.y[i] = points[first + i].y;
      positions.z[i] = points[first + i].z;
    }
    Batch<double> value{};
    field.add(positions, ones, ones, value);
    values.insert(values.end(), value.begin(), value.begin() + static_cast<std::ptrdiff_t>(count));
  }
  return values;
}

// So many cubes, and the same place in each.
std::vector<Vec3d> inEachCube(const Vec3d& at) {
  std::vector<Vec3d> points;
  for (int i = 0; i < 40000; ++i) points.push_back(at + Vec3d{2.0 * (i % 200), 2.0 * (i / 200), 0});
  return points;
}

TEST(SpatialNoise, HasVarianceOneAtEveryPlaceOfACube) {
  for (const Vec3d& at : {Vec3d{0, 0, 0}, Vec3d{0.5, 0.5, 0.5}, Vec3d{-7.9, 3.2, 0.7}, Vec3d{0.5, 0, 0}}) {
    const Moments m = momentsOf(fieldAt(inEachCube(at)));
    EXPECT_NEAR(m.mean, 0, 4 / std::sqrt(40000.0));
    EXPECT_NEAR(m.variance, 1, 4 * std::sqrt(2 / 40000.0));
    EXPECT_NEAR(m.skewness, 0, 0.05);
    EXPECT_NEAR(m.kurtosis, 3, 0.4);
  }
}

TEST(SpatialNoise, IsSmoothAndForgetsBeyondTwoCubes) {
  const std::vector<double> here = fieldAt(inEachCube({0.3, 0.6, 0.2}));
  EXPECT_GT(correlation(here, fieldAt(inEachCube({0.35, 0.6, 0.2}))), 0.98);
  const double half = correlation(here, fieldAt(inEachCube({0.8, 0.6, 0.2})));
  EXPECT_GT(half, 0.1);
  EXPECT_LT(half, 0.9);
  EXPECT_NEAR(correlation(here, fieldAt(inEachCube({0.3, 0.6, 2.2}))), 0, 0.02);
  EXPECT_NEAR(correlation(here, fieldAt(inEachCube({0.3, 0.6, 0.2}), 2)), 0, 0.02);
  EXPECT_NEAR(correlation(here, fieldAt(inEachCube({0.3, 0.6, 0.2}), 1, 1)), 0, 0.02);
}

// More cubes than the field's table has entries, many of them in one batch.
TEST(SpatialNoise, DoesNotDependOnEarlierPoints) {
  std::vector<Vec3d> points;
  for (std::uint32_t i = 0; i < 3000; ++i) {
    const RandomBlock random = randomBlock({.seed = 3, .beam = i});
    points.push_back(Vec3d{uniform(random[0]), uniform(random[1]), uniform(random[2])} * 40);
  }
  const std::vector<double> values = fieldAt(points);
  std::vector<double> reversed = fieldAt({points.rbegin(), points.rend()});
  std::reverse(reversed.begin(), reversed.end());
  EXPECT_EQ(values, reversed);
  for (std::size_t i = 0; i < points.size(); i += 100) EXPECT_EQ(fieldAt({points[i]}).front(), values[i]);
}

// From cube to cube, through zero, and far from the origin.
TEST(SpatialNoise, IsContinuous) {
  for (const double start : {-2.0, 499999.0, -5e6}) {
    std::vector<Vec3d> line;
    for (int i = 0; i <= 4000; ++i) line.push_back({start + 1e-3 * i, 0.4, -0.3});
    const std::vector<double> values = fieldAt(line);
    for (std::size_t i = 1; i < values.size(); ++i) ASSERT_LT(std::abs(values[i] - values[i - 1]), 0.02) << start;
  }
}

TEST(SpatialNoise, LiesWhereTheHitsAre) {
  World world = makeWorld(1, 4, 8);
  world.shot.worldFromSensor[0].translation = {100, 200, 3};
  Returns returns;
  returns.start(world.hits);
  returns.remove(2);
  Positions positions;
  PositionsOfHits(world.hits, world.shot, returns).compute(0, positions);
  EXPECT_NEAR(positions.x[0], 108, 1e-12);
  EXPECT_NEAR(positions.y[1], 208, 1e-12);
  EXPECT_NEAR(positions.z[1], 3, 1e-12);
  EXPECT_EQ(positions.x[2], 0);
}

// The effects that such fields make, on a rough and mottled surface that beams meet at a slant.
constexpr const char* kOfTheWorld[] = {"relief: {}", "reflectance_variation: {}"};

World roughWorld() {
  World world = makeWorld(64, 512);
  world.materials[0].relief = {{0.3f, 0.02f}};
  world.materials[0].variations = {{1, 0.5f}};
  world.hits.incidence.assign(world.hits.size(), 0.5f);
  return world;
}

// A quarter of a turn to the left, and the beams a quarter of a turn to the right: another frame, the same positions.
TEST(FieldsOfTheWorld, BelongToPlacesAndNotToBeams) {
  World world = roughWorld();
  World turned = world;
  turned.shot.frame = 7;
  turned.shot.worldFromSensor[0].rotation = fromYawPitchRoll(kPi / 2, 0, 0);
  const Returns plain = run(world, {"intensity: {}"});
  for (const char* yaml : kOfTheWorld) {
    const Returns before = run(world, {yaml, "intensity: {}"});
    const Returns after = run(turned, {yaml, "intensity: {}"});
    EXPECT_TRUE(before.range != plain.range || before.power != plain.power) << yaml;
    for (std::size_t beam = 0; beam < world.hits.size(); ++beam) {
      const std::size_t same = beam / 512 * 512 + (beam + 384) % 512;
      ASSERT_NEAR(after.range[same], before.range[beam], 1e-4) << yaml;
      ASSERT_NEAR(after.power[same], before.power[beam], 1e-4) << yaml;
    }
  }
}

TEST(FieldsOfTheWorld, LeaveOtherMaterialsAlone) {
  World unknown = roughWorld();
  unknown.hits.material.assign(unknown.hits.size(), kNoMaterial);
  miss(unknown, 5);
  for (const World& world : {makeWorld(4, 64), unknown}) {
    for (const char* yaml : kOfTheWorld) {
      const Returns returns = run(world, {yaml});
      EXPECT_EQ(returns.range, world.hits.range) << yaml;
      EXPECT_THAT(returns.gain, testing::Each(1.0f)) << yaml;
    }
  }
}

TEST(FieldsOfTheWorld, AreTheSameForEchoesOfSeveralRays) {
  const World single = roughWorld();
  World several = single;
  for (std::uint32_t beam = 0; beam < several.hits.size(); ++beam) several.hits.beamOfRay.push_back(beam);
  several.hits.weightOfRay.assign(several.hits.size(), 1.0f);
  for (const char* yaml : kOfTheWorld) {
    EXPECT_EQ(run(several, {yaml}).range, run(single, {yaml}).range);
    EXPECT_EQ(run(several, {yaml}).gain, run(single, {yaml}).gain);
  }
}

}  // namespace
}  // namespace scanmill
