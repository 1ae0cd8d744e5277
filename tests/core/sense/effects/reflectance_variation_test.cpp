#include "tests/core/sense/several_returns.h"

namespace scanmill {
namespace {

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

// A beam of 20 mm at 10 m lights the area of 1.57 cm^2 evenly; patches of 1 cm keep 1 / (1 + 1.57) of their variance.
TEST(ReflectanceVariation, IsAveragedOverTheBeam) {
  World world = rough(0.4f, 0.01f);
  world.beams().divergence = {2e-3, 2e-3};
  const Moments m = momentsOf(logGains(world, "reflectance_variation: {}"));
  EXPECT_NEAR(m.variance, 0.16 / (1 + kPi / 2), 0.004);
}

}  // namespace
}  // namespace scanmill
