#include "methods/particle/options.h"

#include <fmt/core.h>

#include <utility>

#include "base/random.h"
#include "config/value.h"
#include "methods/particle/particles.h"
#include "tests/core/methods/particle/fields.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

using Refine = ParticleOptions::Refine;

ParticleOptions optionsOf(const std::string& yaml, const std::string& file = "pipelines/p.yaml") {
  const Value value = parseYaml("{" + yaml + "}", file);
  Fields fields(value, "method particle");
  return readParticleOptions(fields);
}

TEST(ParticleOptions, Defaults) {
  const ParticleOptions options = optionsOf("");
  EXPECT_EQ(options.backend, ParticleOptions::Backend::Cpu);
  EXPECT_EQ(options.voxel, 0.1);
  EXPECT_EQ(options.voxels, 256u);
  EXPECT_EQ(options.levels, 0u);
  EXPECT_EQ(options.refine, Refine::ByTriangle);
  EXPECT_EQ(options.steps, 512u);
}

TEST(ParticleOptions, EveryKeyIsRead) {
  const ParticleOptions options =
      optionsOf("voxel_m: 0.25, voxels: 64, levels: 1, refine: none, steps: 16, backend: gl");
  EXPECT_EQ(options.backend, ParticleOptions::Backend::Gl);
  EXPECT_EQ(options.voxel, 0.25);
  EXPECT_EQ(options.levels, 1u);
  EXPECT_EQ(options.refine, Refine::None);
  EXPECT_EQ(options.steps, 16u);
  EXPECT_EQ(options.voxels, 64u);
  EXPECT_EQ(optionsOf("refine: triangle, backend: cpu, levels: auto").refine, Refine::ByTriangle);
}

TEST(ParticleOptions, RefusesWhatIsOutOfRange) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> wrong = {
      {"voxel_m: 0.0005", {"voxel_m"}},
      {"voxel_m: 11", {"voxel_m"}},
      {"voxels: 48", {"voxels", "64"}},
      {"voxels: 1040", {"voxels", "1024"}},
      {"voxels: 100", {"multiple of 16", "96 or 112"}},
      {"levels: 0", {"levels"}},
      {"levels: 17", {"levels"}},
      {"levels: all", {"levels"}},
      {"field: scene", {"unknown key 'field'"}},
      {"refine: normal", {"refine may not be 'normal' (known: none, triangle)"}},
      {"refine: triangles", {"refine", "did you mean 'triangle'"}},
      {"steps: 15", {"steps"}},
      {"steps: 65536", {"steps"}},
      {"backend: cuda", {"backend", "gl"}},
      {"cache: auto", {"unknown key \'cache\'"}},
      {"voxel: 0.1", {"unknown key 'voxel'", "did you mean"}},
  };
  for (const auto& [yaml, words] : wrong) {
    SCOPED_TRACE(yaml);
    expectInputError([&yaml = yaml] { optionsOf(yaml); }, words);
    expectInputError([&yaml = yaml] { optionsOf(yaml); }, {"pipelines/p.yaml:1:"});
  }
}

// Of the key that chose the voxels, so that what is too large for a machine is told where it stands.
TEST(ParticleOptions, KnowWhereTheyAre) {
  EXPECT_EQ(optionsOf("refine: none, voxel_m: 0.2").where.text(), "pipelines/p.yaml:1:25");
  EXPECT_EQ(optionsOf("refine: none").where.text(), "pipelines/p.yaml:1:1");
}

// Distances to a ball, in voxels, around the field's centre: 3 x 3 x 3 full bricks.
DistanceField ballField(const Vec3d& middle, double radius) {
  DistanceField field;
  field.shape.voxel = 1;
  field.shape.levels = {{{-1, -1, -1}, {3, 3, 3}}};
  field.shape.reach = 12;
  field.levels = {{{12, 12, 12}, 1, {3, 3, 3}, 0}};
  std::vector<std::uint16_t> distances;
  for (std::uint32_t brick = 0; brick < 27; ++brick) {
    field.table.push_back(kFullBrick + brick);
    const Vec3d first{brick % 3 * 8 - 12.0, brick / 3 % 3 * 8 - 12.0, brick / 9 * 8 - 12.0};
    for (int i = 0; i < kCornersPerBrick; ++i) {
      const Vec3d corner = first + Vec3d{i % 9 * 1.0, i / 9 % 9 * 1.0, i / 81 * 1.0};
      const double distance = std::fabs(length(corner - middle) - radius);
      distances.push_back(static_cast<std::uint16_t>(std::lround(distance / kDistanceStep)));
    }
    distances.push_back(0);
  }
  setBricks(field, distances, std::vector<std::uint32_t>(distances.size(), 0), {});
  return field;
}

// Of beams through the middles of balls of `diameter` voxels, wherever these lie in their voxel: the share that passes.
double sharePassed(double diameter) {
  constexpr std::uint32_t kBalls = 300;
  constexpr std::uint32_t kBeams = 100;
  std::uint32_t passed = 0;
  Particles particles;
  particles.resize(1, false);
  particles.begin = {0};
  particles.end = {15};
  for (std::uint32_t ball = 0; ball < kBalls; ++ball) {
    const RandomBlock place = randomBlock({.seed = 1, .beam = ball});
    const Vec3d middle{uniform(place[0]), uniform(place[1]), uniform(place[2])};
    const DistanceField field = ballField(middle, diameter / 2);
    for (std::uint32_t beam = 0; beam < kBeams; ++beam) {
      const RandomBlock random = randomBlock({.seed = 2, .frame = ball, .beam = beam});
      const double z = 2 * uniform(random[0]) - 1;
      const double azimuth = 2 * kPi * uniform(random[1]);
      const double level = std::sqrt(1 - z * z);
      const Vec3d direction{level * std::cos(azimuth), level * std::sin(azimuth), z};
      const Vec3f o(middle + direction * (-9 - uniform(random[2])));
      const Vec3f d(direction);
      particles.origin[0] = {o.x};
      particles.origin[1] = {o.y};
      particles.origin[2] = {o.z};
      particles.direction[0] = {d.x};
      particles.direction[1] = {d.y};
      particles.direction[2] = {d.z};
      passed += flownAlone(field, {}, 1000, particles, 0).outcome == Outcome::Miss ? 1 : 0;
    }
  }
  return static_cast<double>(passed) / (kBalls * kBeams);
}

// A step may take a particle through both sides of a thinner object.
TEST(WithoutRefinement, BallsTwoVoxelsWideAreMetByBeamsThroughTheirMiddles) {
  EXPECT_GT(sharePassed(0.2), 0);
  for (const double voxels : {2.0, 2.5, 3.0, 4.0}) EXPECT_EQ(sharePassed(voxels), 0) << voxels;
}

}  // namespace
}  // namespace scanmill
