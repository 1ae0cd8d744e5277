#include "tests/core/sense/several_returns.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

World rough(float contrast, float size) {
  World world = makeWorld(64, 512);
  world.materials[0].variations = {{size, contrast}};
  return world;
}

std::vector<double> logGains(const World& world, const std::string& yaml) {
  std::vector<double> values;
  for (const float gain : run(world, {yaml}).gain) values.push_back(std::log(double{gain}));
  return values;
}

// The beams meet a sphere of 10 m in patches of 2 cm, which neighbours hardly share.
TEST(ReflectanceVariation, IsLogNormalAndKeepsTheMean) {
  const World world = rough(0.4f, 0.02f);
  const Moments m = momentsOf(logGains(world, "reflectance_variation: {}"));
  EXPECT_NEAR(m.mean, -0.4 * 0.4 / 2, 0.01);
  EXPECT_NEAR(m.variance, 0.4 * 0.4, 0.005);
  double mean = 0;
  for (const float gain : run(world, {"reflectance_variation: {}"}).gain) mean += double{gain};
  EXPECT_NEAR(mean / static_cast<double>(world.hits.size()), 1, 0.01);
  EXPECT_NEAR(momentsOf(logGains(world, "reflectance_variation: {strength: 0.5}")).variance, 0.04, 0.002);
}

TEST(ReflectanceVariation, BelongsToTheWorldAndNotToTheBeam) {
  World world = rough(0.5f, 1);
  const std::vector<double> before = logGains(world, "reflectance_variation: {}");
  // A quarter of a turn to the left, and the beams a quarter of a turn to the right: another frame, the same places.
  world.shot.frame = 7;
  world.shot.worldFromSensor[0].rotation = fromYawPitchRoll(kPi / 2, 0, 0);
  const std::vector<double> after = logGains(world, "reflectance_variation: {}");
  for (std::size_t ring = 0; ring < 64; ++ring) {
    for (std::size_t column = 0; column < 512; ++column) {
      ASSERT_NEAR(after[ring * 512 + (column + 384) % 512], before[ring * 512 + column], 1e-5);
    }
  }
}

TEST(ReflectanceVariation, LeavesMaterialsWithoutItAlone) {
  const World plain = makeWorld(4, 64);
  for (const float gain : run(plain, {"reflectance_variation: {}"}).gain) EXPECT_EQ(gain, 1);
  World unknown = rough(0.5f, 1);
  std::fill(unknown.hits.material.begin(), unknown.hits.material.end(), kNoMaterial);
  for (const float gain : run(unknown, {"reflectance_variation: {}"}).gain) EXPECT_EQ(gain, 1);
}

// A beam of 20 mm at 10 m lights the area of 1.57 cm^2 evenly; patches of 1 cm keep 1 / (1 + 1.57) of their variance.
TEST(ReflectanceVariation, IsAveragedOverTheBeam) {
  World world = rough(0.4f, 0.01f);
  world.beams().divergence = {2e-3, 2e-3};
  const Moments m = momentsOf(logGains(world, "reflectance_variation: {}"));
  EXPECT_NEAR(m.variance, 0.16 / (1 + kPi / 2), 0.004);
}

TEST(ReflectanceVariation, IsTheSameForEchoesOfSeveralRays) {
  World world = rough(0.5f, 1);
  const std::vector<double> single = logGains(world, "reflectance_variation: {}");
  for (std::uint32_t beam = 0; beam < world.hits.size(); ++beam) world.hits.beamOfRay.push_back(beam);
  world.hits.weightOfRay.assign(world.hits.size(), 1.0f);
  EXPECT_EQ(logGains(world, "reflectance_variation: {}"), single);
}

}  // namespace
}  // namespace scanmill
