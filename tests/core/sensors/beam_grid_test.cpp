#include "sensors/beam_grid.h"

#include <set>

#include "base/random.h"
#include "tests/support/street.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

Vec3d toward(double azimuth, double elevation) {
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation)};
}

TEST(BeamGrid, FindsAllBeamsOfACone) {
  for (const char* preset : {"vlp_16", "livox_mid_70", "os1_128"}) {
    const auto beams = presetBeams(preset);
    const BeamGrid grid(*beams);
    for (std::uint32_t i = 0; i < 200; ++i) {
      const RandomBlock b = randomBlock({1, 0, 0, 0, i, 0, Purpose::Test});
      const Vec3d axis = i == 0   ? Vec3d{0, 0, 1}
                         : i == 1 ? Vec3d{-1, 0, 0}
                                  : toward(2 * kPi * uniform(b[0]), kPi * (uniform(b[1]) - 0.5));
      const double angle = i % 5 == 0 ? 2.5 * uniform(b[2]) : 0.2 * uniform(b[2]);
      std::set<std::uint32_t> found;
      EXPECT_FALSE(grid.forBeamsNear(axis, angle, [&](std::uint32_t beam) { return !found.insert(beam).second; }));
      for (std::uint32_t beam = 0; beam < beams->size(); ++beam) {
        if (dot(beams->direction[beam], axis) >= std::cos(angle)) {
          ASSERT_TRUE(found.contains(beam)) << preset << " " << i << " " << angle;
        }
      }
    }
  }
}

TEST(BeamGrid, LooksAtFewOthers) {
  const auto beams = presetBeams("os1_128");
  const BeamGrid grid(*beams);
  std::size_t visited = 0;
  grid.forBeamsNear({1, 0, 0}, radians(2), [&](std::uint32_t) { return ++visited == 0; });
  EXPECT_LT(visited, beams->size() / 50);
  EXPECT_GT(visited, 0u);
  EXPECT_TRUE(grid.forBeamsNear({1, 0, 0}, radians(2), [&](std::uint32_t) { return --visited == 0; })) << "it stops";
}

TEST(BeamGrid, KnowsTheField) {
  std::uint32_t near = 0;                    // whatever is tested first changes no answer
  const auto beams = presetBeams("vlp_16");  // 15 degrees up and down, a gap of 2 between rings
  const BeamGrid grid(*beams);
  for (double azimuth = 0; azimuth < 6.28; azimuth += 0.1) {
    for (const double elevation : {-16.0, -15.0, -3.0, 0.0, 9.0, 15.0, 16.0}) {
      EXPECT_TRUE(grid.looksInto(toward(azimuth, radians(elevation)), near)) << azimuth << " " << elevation;
    }
    for (const double elevation : {-90.0, -20.0, 19.0, 89.0}) {
      EXPECT_FALSE(grid.looksInto(toward(azimuth, radians(elevation)), near)) << azimuth << " " << elevation;
    }
  }
  const auto flash = presetBeams("livox_mid_70");  // a circle of 70 degrees ahead
  const BeamGrid ahead(*flash);
  EXPECT_TRUE(ahead.looksInto({1, 0, 0}, near));
  EXPECT_FALSE(ahead.looksInto({0, 1, 0}, near));
  EXPECT_FALSE(ahead.looksInto({-1, 0, 0}, near));
}

}  // namespace
}  // namespace scanmill
