#include "methods/particle/options.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "base/random.h"
#include "config/value.h"
#include "methods/march/march.h"
#include "methods/particle/shape.h"
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
  EXPECT_EQ(options.backend, ParticleOptions::Backend::Auto);
  EXPECT_EQ(options.extent, ParticleOptions::Extent::Sensor);
  EXPECT_EQ(options.voxel, 0.1);
  EXPECT_EQ(options.voxels, 256u);
  EXPECT_EQ(options.levels, 0u);
  EXPECT_EQ(options.refine, Refine::ByTriangle);
  EXPECT_EQ(options.cone, 0);
  EXPECT_EQ(options.steps, 512u);
}

TEST(ParticleOptions, EveryKeyIsRead) {
  const ParticleOptions options =
      optionsOf("field: scene, voxel_m: 0.25, levels: 1, refine: none, cone_mrad: 3, steps: 16, backend: gl");
  EXPECT_EQ(options.backend, ParticleOptions::Backend::Gl);
  EXPECT_EQ(options.extent, ParticleOptions::Extent::Scene);
  EXPECT_EQ(options.voxel, 0.25);
  EXPECT_EQ(options.levels, 1u);
  EXPECT_EQ(options.refine, Refine::None);
  EXPECT_DOUBLE_EQ(options.cone, 0.003);
  EXPECT_EQ(options.steps, 16u);
  EXPECT_EQ(optionsOf("voxels: 64").voxels, 64u);
  EXPECT_EQ(optionsOf("refine: normal, backend: cpu, field: sensor, levels: auto").refine, Refine::ByNormal);
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
      {"field: scene, levels: 2", {"levels", "one level"}},
      {"field: world", {"field", "scene"}},
      {"refine: triangles", {"refine", "did you mean 'triangle'"}},
      {"cone_mrad: 21", {"cone_mrad"}},
      {"cone_mrad: -1", {"cone_mrad"}},
      {"steps: 15", {"steps"}},
      {"steps: 65536", {"steps"}},
      {"backend: cuda", {"backend", "gl"}},
      {"smallest_m: 0", {"smallest_m"}},
      {"refine: none, smallest_within_m: 30", {"smallest_within_m", "give smallest_m too"}},
      {"smallest_m: 1, smallest_within_m: 0", {"smallest_within_m"}},
      {"cache: auto", {"unknown key \'cache\'"}},
      {"voxel: 0.1", {"unknown key 'voxel'", "did you mean"}},
  };
  for (const auto& [yaml, words] : wrong) {
    SCOPED_TRACE(yaml);
    expectInputError([&yaml = yaml] { optionsOf(yaml); }, words);
    expectInputError([&yaml = yaml] { optionsOf(yaml); }, {"pipelines/p.yaml:1:"});
  }
}

// Each with what would be taken for it, and where it has an effect.
TEST(ParticleOptions, RefusesWhatHasNoEffect) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> wrong = {
      {"smallest_m: 0.3",
       {"p.yaml:1:14", "smallest_m: refine: triangle sees objects of any size", "leave smallest_m out",
        "refine: normal or none"}},
      {"refine: triangle, smallest_m: 0.3", {"leave smallest_m out"}},
      {"smallest_within_m: 30", {"leave smallest_within_m out, or take refine: normal or none"}},
      {"cone_mrad: 3", {"cone_mrad: refine: triangle", "leave cone_mrad out", "refine: normal or none"}},
      {"field: scene, voxels: 256", {"voxels: ", "leave voxels out, or take field: sensor"}},
      {"field: scene, levels: 2", {"leave levels out, or take field: sensor"}},
      {"field: scene, refine: none, smallest_m: 0.3, smallest_within_m: 30",
       {"p.yaml:1:", "leave smallest_within_m out, or take field: sensor"}},
  };
  for (const auto& [yaml, words] : wrong) {
    SCOPED_TRACE(yaml);
    expectInputError([&yaml = yaml] { optionsOf(yaml); }, words);
  }
  for (const char* right : {"cone_mrad: 0", "refine: none, cone_mrad: 3", "field: scene, levels: auto",
                            "field: scene, refine: normal, smallest_m: 0.3"}) {
    EXPECT_NO_THROW(optionsOf(right)) << right;
  }
}

// Of the key that chose the voxels, so that what is too large for a machine is told where it stands.
TEST(ParticleOptions, KnowWhereTheyAre) {
  EXPECT_EQ(optionsOf("refine: none, voxel_m: 0.2").where.text(), "pipelines/p.yaml:1:25");
  EXPECT_EQ(optionsOf("refine: none, smallest_m: 0.2").where.text(), "pipelines/p.yaml:1:28");
  EXPECT_EQ(optionsOf("refine: none").where.text(), "pipelines/p.yaml:1:1");
}

TEST(MemoryText, HasOneUnit) {
  EXPECT_EQ(memoryText(1), "1 MiB");
  EXPECT_EQ(memoryText(34.4 * 1024 * 1024), "34 MiB");
  EXPECT_EQ(memoryText(1024.0 * 1024 * 1024), "1.0 GiB");
  EXPECT_EQ(memoryText(23.46 * 1024 * 1024 * 1024), "23.5 GiB");
}

TEST(LevelReach, DoublesFromLevelToLevel) {
  const ParticleOptions options;
  EXPECT_DOUBLE_EQ(levelReach(options, 0), 123 * 0.1);
  for (std::uint32_t level = 1; level < 8; ++level) {
    EXPECT_EQ(levelReach(options, level), 2 * levelReach(options, level - 1));
  }
}

TEST(LevelReach, IsThatOfTheFieldsShape) {
  for (const char* yaml : {"", "voxel_m: 0.03, voxels: 64", "voxels: 1024, levels: 2", "refine: none, voxel_m: 2"}) {
    const ParticleOptions options = optionsOf(yaml);
    const FieldShape shape = shapeOf(options, {12.3, -4.5, 1.9}, Box{{-200, -200, -5}, {200, 200, 30}}, 120);
    EXPECT_NEAR(shape.reach * shape.voxel, levelReach(options, 0), 1e-9) << yaml;
    // So far from the sensor, in all directions, smallestSeen() is true of the finest level.
    const Vec3d off = Vec3d{12.3, -4.5, 1.9} - shape.centre;
    EXPECT_LE(std::max({std::fabs(off.x), std::fabs(off.y), std::fabs(off.z)}), 4 * shape.voxel * (1 + 1e-9));
  }
}

TEST(SmallestSeen, GrowsWithTheVoxelsOutThere) {
  ParticleOptions options;
  EXPECT_EQ(smallestSeen(options, 1000), 0);
  options.refine = Refine::None;
  EXPECT_DOUBLE_EQ(smallestSeen(options, 1), 0.05);
  double last = 0;
  for (double range = 0.5; range < 300; range *= 1.1) {
    const double size = smallestSeen(options, range);
    EXPECT_GE(size, last);
    last = size;
    // Where the size is that of level l, the level reaches as far, and the one before does not.
    const auto level = static_cast<std::uint32_t>(std::lround(std::log2(size / 0.05)));
    EXPECT_GE(levelReach(options, level), range);
    if (level > 0) {
      EXPECT_LT(levelReach(options, level - 1), range + 0.4001);
    }
  }
  options.levels = 2;
  EXPECT_EQ(smallestSeen(options, 30), INFINITY);
  options.extent = ParticleOptions::Extent::Scene;
  EXPECT_DOUBLE_EQ(smallestSeen(options, 1e6), 0.05);
}

// Distances to a ball, in voxels, around the field's centre: 3 x 3 x 3 full bricks.
DistanceField ballField(const Vec3d& middle, double radius) {
  DistanceField field;
  field.shape.voxel = 1;
  field.shape.levels = {{{-1, -1, -1}, {3, 3, 3}}};
  field.shape.reach = 12;
  field.levels = {{{12, 12, 12}, 1, {3, 3, 3}, 0}};
  for (std::uint32_t brick = 0; brick < 27; ++brick) {
    field.table.push_back(kFullBrick + brick);
    const Vec3d first{brick % 3 * 8 - 12.0, brick / 3 % 3 * 8 - 12.0, brick / 9 * 8 - 12.0};
    for (int i = 0; i < kCornersPerBrick; ++i) {
      const Vec3d corner = first + Vec3d{i % 9 * 1.0, i / 9 % 9 * 1.0, i / 81 * 1.0};
      const double distance = std::fabs(length(corner - middle) - radius);
      field.distance.push_back(static_cast<std::uint16_t>(std::lround(distance / kDistanceStep)));
    }
    field.distance.push_back(0);
  }
  field.word.assign(field.distance.size(), 0);
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
      particles.ox = {o.x};
      particles.oy = {o.y};
      particles.oz = {o.z};
      particles.dx = {d.x};
      particles.dy = {d.y};
      particles.dz = {d.z};
      const MarchOptions options{.hit = kRest, .cone = 0, .steps = 1000};
      passed += marchOne(field, {}, options, particles, 0).outcome == Outcome::Miss ? 1 : 0;
    }
  }
  return static_cast<double>(passed) / (kBalls * kBeams);
}

TEST(SmallestSeen, BallsOfThatSizeAreMetByBeamsThroughTheirMiddles) {
  EXPECT_GT(sharePassed(0.2), 0);
  for (const double voxels : {0.5, 0.75, 0.95, 1.1, 1.25, 1.5, 1.8, 2.0, 3.0})
    EXPECT_EQ(sharePassed(voxels), 0) << voxels;
}

// The chosen voxels do what was asked for, and the defaults stay where they do.
TEST(SmallestSeen, IsWhatTheUserAsksFor) {
  for (const char* refine : {"none", "normal"}) {
    for (const char* given : {"", "voxel_m: 0.02, ", "levels: 3, ", "levels: 1, ", "field: scene, ", "voxels: 512, "}) {
      for (const double size : {0.05, 0.1, 0.25, 0.3, 0.77, 2.0}) {
        for (const double within : {1.0, 10.0, 30.0, 77.7, 200.0}) {
          const bool everywhere = std::string(given) == "field: scene, ";
          const std::string yaml = fmt::format("{}refine: {}, smallest_m: {}{}", given, refine, size,
                                               everywhere ? "" : fmt::format(", smallest_within_m: {}", within));
          const std::string message = messageOf([&] { optionsOf(yaml); });
          if (message != "accepted") {
            EXPECT_THAT(message, testing::HasSubstr("a level)")) << yaml;
            EXPECT_THAT(message, testing::HasSubstr(fmt::format("{:g} m within {:g} m", size, within)));
            continue;
          }
          const ParticleOptions options = optionsOf(yaml);
          EXPECT_LE(smallestSeen(options, within), size * (1 + 1e-11)) << yaml;
          EXPECT_GE(options.voxels, 256u);
          EXPECT_LE(options.voxels, 1024u);
          EXPECT_EQ(options.voxels % 16, 0u);
          if (std::string(given).empty()) {
            EXPECT_LE(options.voxel, 0.1);
          }
        }
      }
    }
  }
}

TEST(SmallestSeen, ChangesNothingThatDoes) {
  const ParticleOptions usual = optionsOf("refine: none, smallest_m: 0.3");
  EXPECT_EQ(usual.voxel, 0.1);
  EXPECT_EQ(usual.voxels, 256u);
  const ParticleOptions finer = optionsOf("refine: none, smallest_m: 0.1, smallest_within_m: 30");
  EXPECT_DOUBLE_EQ(finer.voxel, 0.1);
  EXPECT_GT(finer.voxels, 256u);
  EXPECT_DOUBLE_EQ(optionsOf("refine: none, smallest_m: 0.02, smallest_within_m: 4").voxel, 0.04);
}

TEST(SmallestSeen, SaysWhatItWouldTake) {
  expectInputError(
      [] { optionsOf("refine: none, smallest_m: 0.0125"); },
      {"p.yaml:1:28", "the smallest ball that every beam through its middle meets shall be one of 0.0125 m within 30 m",
       "voxels of 0.025 m", "2432 of them", "at most 1024", "GiB a level", "smallest_within_m up to 12.57",
       "refine: triangle without smallest_m"});
  expectInputError([] { optionsOf("refine: normal, smallest_m: 0.1, voxels: 256"); },
                   {"voxels of 0.2 m", "320 of them", "voxels is 256", "MiB a level"});
  expectInputError([] { optionsOf("refine: normal, smallest_m: 0.1, voxel_m: 0.5"); },
                   {"at most 0.2 m", "voxel_m is 0.5"});
  const std::string everywhere =
      messageOf([] { optionsOf("field: scene, refine: none, smallest_m: 0.1, voxel_m: 1"); });
  EXPECT_THAT(everywhere, testing::HasSubstr("shall be one of 0.1 m, which takes voxels of at most 0.2 m"));
  // The least that is asked for in the message is enough.
  EXPECT_EQ(optionsOf("refine: normal, smallest_m: 0.1, voxels: 320").voxels, 320u);
  EXPECT_NO_THROW(optionsOf("refine: none, smallest_m: 0.0125, smallest_within_m: 12.57"));
}

}  // namespace
}  // namespace scanmill
