#include "sensors/footprint.h"

#include <set>

#include "base/error.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

std::shared_ptr<BeamTable> wideBeams(bool uniform = false) {
  auto beams = spinning(5, 40, -20, 20);
  beams->divergence = {0.003, 0.0015};
  beams->uniformBeam = uniform;
  beams->pulse = 5e-9;
  return beams;
}

// The beam's second moments are those of its shape, a quarter of the half width's square each way, whatever the number
// of rays: the law on which the width of a slanted plane's echo rests.
TEST(Footprint, HasTheBeamsOwnWidth) {
  for (const bool uniform : {false, true}) {
    const auto beams = wideBeams(uniform);
    for (const std::uint32_t n : {7u, 19u, 37u, 61u, 91u, 127u}) {
      const Footprint footprint = makeFootprint(*beams, n);
      ASSERT_EQ(footprint.rays->size(), beams->size() * n);
      ASSERT_EQ(footprint.weight.size(), n);
      double sum = 0;
      for (const float w : footprint.weight) sum += w;
      EXPECT_NEAR(sum, 1, 1e-6);
      for (std::size_t beam = 0; beam < beams->size(); ++beam) {
        const Vec3d axis = beams->direction[beam];
        const Vec3d across = normalized(Vec3d{-axis.y, axis.x, 0});
        const Vec3d up = cross(axis, across);
        double moments[5] = {};
        for (std::uint32_t k = 0; k < n; ++k) {
          const Vec3d d = footprint.rays->direction[beam * n + k];
          ASSERT_NEAR(length(d), 1, 1e-12);
          const double x = dot(d, across);
          const double y = dot(d, up);
          const double w = footprint.weight[k];
          moments[0] += w * x;
          moments[1] += w * y;
          moments[2] += w * x * x;
          moments[3] += w * y * y;
          moments[4] += w * x * y;
        }
        EXPECT_NEAR(moments[0], 0, 1e-9);
        EXPECT_NEAR(moments[1], 0, 1e-9);
        EXPECT_NEAR(moments[2], 0.0015 * 0.0015 / 4, 1e-11);
        EXPECT_NEAR(moments[3], 0.00075 * 0.00075 / 4, 1e-11);
        EXPECT_NEAR(moments[4], 0, 1e-11);
        EXPECT_LT(length(footprint.rays->direction[beam * n] - axis), 1e-15) << "the first ray is the axis";
      }
    }
  }
}

TEST(Footprint, IsTurnedForEachBeamAndTheSameEachTime) {
  const auto beams = wideBeams();
  const Footprint one = makeFootprint(*beams, 7);
  const Footprint other = makeFootprint(*beams, 7);
  std::set<double> angles;
  for (std::size_t beam = 0; beam < beams->size(); ++beam) {
    const Vec3d& d = one.rays->direction[beam * 7 + 1];
    ASSERT_EQ(d.x, other.rays->direction[beam * 7 + 1].x);
    angles.insert(
        dot(d - beams->direction[beam], normalized(Vec3d{-beams->direction[beam].y, beams->direction[beam].x, 0})));
  }
  EXPECT_GT(angles.size(), beams->size() - 3);
}

TEST(Footprint, StartsAsWideAsTheExit) {
  const auto beams = wideBeams();
  EXPECT_TRUE(makeFootprint(*beams, 19).rays->origin.empty());
  beams->exitWidth = {0.01, 0.01};
  const Footprint footprint = makeFootprint(*beams, 19);
  double square = 0;
  for (std::uint32_t k = 0; k < 19; ++k)
    square += footprint.weight[k] * std::pow(length(Vec3d(footprint.rays->origin[k])), 2);
  EXPECT_NEAR(square, 2 * 0.005 * 0.005 / 4, 1e-9);
}

TEST(Footprint, RaysOfABeamHaveItsPose) {
  const auto beams = wideBeams();
  Shot shot = shotAt(beams);
  for (const std::size_t poses : {std::size_t{1}, std::size_t{7}, std::size_t{40}}) {
    shot.worldFromSensor.resize(poses);
    Shot wide = shot;
    wide.beams = makeFootprint(*beams, 19).rays;
    for (std::uint32_t column = 0; column < 40; ++column) {
      for (std::uint32_t k = 0; k < 19; ++k) ASSERT_EQ(wide.stepOf(column * 19 + k), shot.stepOf(column));
    }
  }
}

TEST(Footprint, RefusesOtherNumbers) {
  for (const std::uint32_t n : {0u, 2u, 8u, 169u}) EXPECT_THROW(makeFootprint(*wideBeams(), n), Error);
}

}  // namespace
}  // namespace scanmill
