#include "sense/effects/spatial_noise.h"
#include "tests/core/sense/several_returns.h"

namespace scanmill {
namespace {

// Every beam meets a rough surface, the normal of which lies at `slant` degrees from it.
World rough(std::vector<Relief> relief, double slant = 0, std::uint32_t rings = 64) {
  World world = makeWorld(rings, 512);
  world.materials[0].relief = std::move(relief);
  std::fill(world.hits.incidence.begin(), world.hits.incidence.end(), static_cast<float>(std::cos(radians(slant))));
  return world;
}

// How far behind the mesh beams end (m).
std::vector<double> shifts(const World& world, const std::string& yaml = "relief: {}") {
  std::vector<double> values;
  const Returns returns = run(world, {yaml});
  for (std::size_t row = 0; row < returns.size(); ++row) {
    values.push_back(double{returns.range[row]} - double{world.hits.range[row]});
  }
  return values;
}

// Heights of 1 cm over 10 cm, met from above.
TEST(Relief, HasItsHeightWhereBeamsFallFromAbove) {
  const World world = rough({{0.1f, 0.01f}});
  const Moments m = momentsOf(shifts(world));
  EXPECT_NEAR(m.mean, 0, 0.0015);
  EXPECT_NEAR(std::sqrt(m.variance), 0.01, 0.001);
  EXPECT_NEAR(std::sqrt(momentsOf(shifts(world, "relief: {strength: 2}")).variance), 0.02, 0.002);
  EXPECT_NEAR(std::sqrt(momentsOf(shifts(rough({{0.1f, 0.01f}, {0.5f, 0.02f}}))).variance), std::sqrt(5e-4), 0.002);
}

// The end of a beam lies on the heights, by the field itself; the beam's line is straight between two steps, the field
// is not, whence the tolerance.
TEST(Relief, BeamsEndOnTheHeights) {
  const World world = rough({{0.2f, 0.02f}}, 70);
  const std::vector<double> found = shifts(world);
  std::size_t off = 0;
  for (std::size_t first = 0; first < found.size(); first += kBatch) {
    Positions positions;
    Batch<double> cubes;
    Batch<double> factor;
    Batch<double> height{};
    cubes.fill(1 / double{0.2f});
    factor.fill(double{0.02f});
    for (std::size_t i = 0; i < kBatch; ++i) {
      const Vec3d p = world.shot.beams->direction[first + i] * (10 + found[first + i]);
      positions.x[i] = p.x;
      positions.y[i] = p.y;
      positions.z[i] = p.z;
    }
    SpatialField(world.shot.seed, Purpose::Relief, 0).add(positions, cubes, factor, height);
    for (std::size_t i = 0; i < kBatch; ++i) {
      const double beam = -found[first + i] * std::cos(radians(70));
      off += std::abs(beam - height[i]) > 0.006 ? 1u : 0u;
    }
  }
  EXPECT_LT(off, found.size() / 50);
}

TEST(Relief, GrazingBeamsMeetTheTips) {
  const Moments above = momentsOf(shifts(rough({{0.05f, 0.02f}})));
  const Moments grazing = momentsOf(shifts(rough({{0.05f, 0.02f}}, 84)));
  const double heightAbove = -above.mean;
  const double heightGrazing = -grazing.mean * std::cos(radians(84));
  EXPECT_GT(heightGrazing, heightAbove + 0.01);
  EXPECT_LT(heightGrazing, 2.5 * 0.02);
}

TEST(Relief, IsTheSameInWhateverBatchARowIs) {
  World world = rough({{0.1f, 0.01f}}, 75, 4);
  const std::vector<double> whole = shifts(world);
  // Neighbours that are searched over other distances, and some that are not.
  for (std::size_t beam = 0; beam < 4 * 512; ++beam) {
    if (beam % 3 == 1) world.hits.material[beam] = kNoMaterial;
    if (beam % 3 == 2) world.hits.incidence[beam] = 0.01f;
  }
  const std::vector<double> some = shifts(world);
  for (std::size_t beam = 0; beam < 4 * 512; beam += 3) EXPECT_EQ(some[beam], whole[beam]);
}

// A beam of 20 mm at 10 m lights 1.57 cm^2 evenly; heights over 2 cm keep 1 / (1 + pi / 8) of their variance.
TEST(Relief, IsAveragedOverTheBeam) {
  World world = rough({{0.02f, 0.002f}});
  world.beams().divergence = {2e-3, 2e-3};
  EXPECT_NEAR(momentsOf(shifts(world)).variance / momentsOf(shifts(rough({{0.02f, 0.002f}}))).variance,
              1 / (1 + kPi / 8), 0.03);
}

TEST(Relief, NearestBeamsStayBeforeTheSensor) {
  World world = makeWorld(16, 64, 0.05f);
  world.materials[0].relief = {{1, 1}};
  const Returns returns = run(world, {"relief: {strength: 10}"});
  for (std::size_t row = 0; row < returns.size(); ++row) EXPECT_GT(returns.range[row], 0);
}

}  // namespace
}  // namespace scanmill
