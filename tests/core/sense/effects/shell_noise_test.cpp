#include "tests/core/sense/world.h"

namespace scanmill {
namespace {

TEST(ShellNoise, DisplacesByExactlyTheScale) {
  const World world = makeRaggedWorld(64, 512);
  const Returns returns = run(world, {"shell: {scale_m: 0.02, growth_per_m: 0.01}"});
  EXPECT_EQ(returns.range, world.hits.range);
  for (std::size_t b = 0; b < world.hits.size(); ++b) {
    const double scale = world.hits.hit(b) ? 0.02 + 0.01 * world.hits.range[b] : 0.0;
    EXPECT_NEAR(length(static_cast<Vec3d>(returns.displacement[b])), scale, 1e-7 * scale);
  }
}

// On a unit sphere each coordinate is uniform in [-1, 1]: mean 0, variance 1/3, kurtosis 9/5, and they are
// uncorrelated.
TEST(ShellNoise, DirectionsAreUniformOnTheSphere) {
  const World world = makeWorld(256, 1024, 1);
  const Returns returns = run(world, {"shell: {scale_m: 0.5}"});
  std::array<std::vector<double>, 3> axis;
  for (const Vec3f& d : returns.displacement) {
    axis[0].push_back(2.0 * d.x);
    axis[1].push_back(2.0 * d.y);
    axis[2].push_back(2.0 * d.z);
  }
  const double n = std::sqrt(static_cast<double>(world.hits.size()));
  for (std::size_t a = 0; a < 3; ++a) {
    const Moments m = momentsOf(axis[a]);
    EXPECT_NEAR(m.mean, 0, 5 / n);
    EXPECT_NEAR(m.variance, 1.0 / 3, 5 * 0.3 / n);
    EXPECT_NEAR(m.kurtosis, 1.8, 5 * 3 / n);
    EXPECT_NEAR(correlation(axis[a], axis[(a + 1) % 3]), 0, 5 / n);
  }
}

TEST(ShellNoise, NoPointPassesBehindTheSensor) {
  for (float range : {1e-3f, 0.1f, 1.0f, 1e4f}) {
    const World world = makeWorld(16, 256, range);
    const Returns returns = run(world, {"shell: {scale_m: 100, growth_per_m: 0.5}"});
    for (std::size_t b = 0; b < world.hits.size(); ++b) {
      const Vec3d& d = world.shot.beams->direction[b];
      EXPECT_GT(dot(d * static_cast<double>(range) + static_cast<Vec3d>(returns.displacement[b]), d), 0);
    }
  }
}

}  // namespace
}  // namespace scanmill
