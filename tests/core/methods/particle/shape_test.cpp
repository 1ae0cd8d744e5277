#include <cstdlib>

#include "base/memory.h"
#include "base/random.h"
#include "base/short_text.h"
#include "methods/field/distance_field.h"
#include "methods/particle/options.h"
#include "tests/core/methods/trace.h"
#include "tests/support/message_of.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

const Box kStreet{{-250, -80, -1}, {250, 80, 25}};

ParticleOptions optionsOf(double voxel, std::uint32_t voxels, std::uint32_t levels = 0) {
  ParticleOptions options;
  options.voxel = voxel;
  options.voxels = voxels;
  options.levels = levels;
  return options;
}

std::array<double, 3> coordinates(const Vec3d& v) {
  return {v.x, v.y, v.z};
}

// In [-1, 1], of case i.
Vec3d randomDirection(std::uint32_t i) {
  const RandomBlock r = randomBlock({.seed = 5, .beam = i});
  return {2 * uniform(r[0]) - 1, 2 * uniform(r[1]) - 1, 2 * uniform(r[2]) - 1};
}

TEST(Shape, LevelsHoldWhatTheyServe) {
  for (std::uint32_t i = 0; i < 400; ++i) {
    const double voxel = std::array<double, 4>{0.001, 0.1, 0.37, 10}[i % 4];
    const std::uint32_t voxels = std::array<std::uint32_t, 3>{16, 64, 256}[i % 3];
    const Vec3d sensor = randomDirection(i) * std::pow(10.0, i % 5);
    const FieldShape shape = shapeOf(optionsOf(voxel, voxels, 5), sensor, kStreet, 100);
    ASSERT_EQ(shape.levels.size(), 5u);
    EXPECT_GT(shape.reach, 0);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_LE(std::fabs(coordinates(sensor - shape.centre)[k]), 4 * voxel * (1 + 1e-9) + 1e-9);
      for (std::size_t l = 0; l < shape.levels.size(); ++l) {
        const double size = std::ldexp(voxel, int(l));
        const double reach = shape.reach * size;
        const auto low = double(shape.levels[l].firstBrick[k] * 8) * size;
        const double high = low + shape.levels[l].bricks[k] * 8 * size;
        EXPECT_EQ(shape.levels[l].bricks[k], voxels / 8);
        const double slack = 1e-9 * (std::fabs(low) + voxel);
        EXPECT_GE(coordinates(shape.centre)[k] - reach, low + size - slack) << "level " << l;
        EXPECT_LE(coordinates(shape.centre)[k] + reach, high - size + slack) << "level " << l;
      }
    }
  }
}

TEST(Shape, ParticlesFindTheFirstCornerOfEachLevel) {
  for (std::uint32_t i = 0; i < 100; ++i) {
    const double voxel = std::array<double, 3>{0.001, 0.1, 3}[i % 3];
    const FieldShape shape = shapeOf(optionsOf(voxel, 128, 16), randomDirection(i) * 1000.0, kStreet, 100);
    const std::vector<FieldLevel> levels = fieldLevels(shape);
    ASSERT_EQ(levels.size(), 16u);
    std::uint32_t entries = 0;
    for (std::size_t l = 0; l < levels.size(); ++l) {
      EXPECT_EQ(levels[l].firstEntry, entries);
      EXPECT_EQ(levels[l].bricks, shape.levels[l].bricks);
      EXPECT_EQ(levels[l].scale, std::ldexp(1.0f, -int(l)));
      entries += static_cast<std::uint32_t>(shape.levels[l].size());
      for (std::size_t k = 0; k < 3; ++k) {
        const double centre = std::round(coordinates(shape.centre)[k] / voxel);  // a corner of the lattice
        const double first = std::ldexp(double(shape.levels[l].firstBrick[k] * 8), int(l));
        // Exactly, although in float32.
        EXPECT_EQ((first - centre) * levels[l].scale + levels[l].offset[k], 0) << "level " << l;
      }
    }
  }
}

TEST(Shape, HasAsManyLevelsAsTheRangeTakes) {
  const auto reachOf = [](const FieldShape& shape) {
    return std::ldexp(shape.reach * shape.voxel, int(shape.levels.size()) - 1);
  };
  for (const double range : {1.0, 12.0, 50.0, 120.0, 200.0}) {
    const FieldShape shape = shapeOf(optionsOf(0.1, 256), {3, 2, 1}, kStreet, range);
    EXPECT_GE(reachOf(shape), range + 0.8);
    if (shape.levels.size() > 1) {
      EXPECT_LT(reachOf(shape) / 2, range + 0.8) << range;
    }
  }
}

TEST(Shape, DoesNotReachBeyondTheScene) {
  const Box room{{-4, -3, 0}, {4, 3, 2.5}};
  const FieldShape shape = shapeOf(optionsOf(0.1, 64), {1, 1, 1}, room, 1e9);
  EXPECT_EQ(shape.levels.size(), 2u);  // 2.7 m do not hold the 5 m to the farthest wall, 5.4 m do
  const Box march = marchBox(shape);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_LT(coordinates(march.low)[k], coordinates(room.low)[k]);
    EXPECT_GT(coordinates(march.high)[k], coordinates(room.high)[k]);
  }
  EXPECT_EQ(shapeOf(optionsOf(0.1, 64), {1, 1, 1}, Box{}, 1e9).levels.size(), 1u);
  EXPECT_EQ(shapeOf(optionsOf(0.1, 64), {1, 1, 1}, room, INFINITY), shape);
}

TEST(Shape, TakesTheLevelsItIsGiven) {
  for (const std::uint32_t levels : {1u, 3u, 16u}) {
    EXPECT_EQ(shapeOf(optionsOf(0.1, 64, levels), {}, kStreet, 5).levels.size(), levels);
  }
  EXPECT_EQ(shapeOf(optionsOf(0.001, 16), {}, Box{{-1e6, 0, 0}, {1e6, 1, 1}}, 1e6).levels.size(), kMaxLevels);
}

TEST(Shape, MovesWithSceneAndSensorByWholeBricks) {
  const ParticleOptions options = optionsOf(0.25, 64, 4);
  const FieldShape shape = shapeOf(options, {1.3, -2.2, 0.4}, kStreet, 100);
  const Vec3d shift{16 * 3, -16 * 5, 16};  // bricks of 16 m at level 3
  const Box moved{kStreet.low + shift, kStreet.high + shift};
  const FieldShape other = shapeOf(options, Vec3d{1.3, -2.2, 0.4} + shift, moved, 100);
  EXPECT_EQ(other.centre, shape.centre + shift);
  for (std::size_t l = 0; l < 4; ++l) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double bricks = coordinates(shift)[k] / (2 << l);
      EXPECT_EQ(double(other.levels[l].firstBrick[k] - shape.levels[l].firstBrick[k]), bricks);
    }
    EXPECT_EQ(fieldLevels(other)[l].offset, fieldLevels(shape)[l].offset);
  }
}

TEST(Shape, StaysWhereTheSensorMovesLittle) {
  const ParticleOptions options = optionsOf(0.1, 256);
  const FieldShape shape = shapeOf(options, {0.05, 0, 1.6}, kStreet, 100);
  EXPECT_EQ(shapeOf(options, {0.3, -0.3, 1.8}, kStreet, 100), shape);
  EXPECT_NE(shapeOf(options, {0.5, 0, 1.6}, kStreet, 100), shape);
}

TEST(Shape, ListsAreForExactHits) {
  ParticleOptions options;
  for (const auto refine : {ParticleOptions::Refine::None, ParticleOptions::Refine::ByTriangle}) {
    options.refine = refine;
    EXPECT_EQ(shapeOf(options, {}, kStreet, 10).lists, refine == ParticleOptions::Refine::ByTriangle);
  }
}

TEST(CheckField, RefusesWhatTheMemoryDoesNotHold) {
  constexpr double kGibibyte = 1024.0 * 1024 * 1024;
  ParticleOptions options = optionsOf(0.05, 512);
  options.where = {"p.yaml", 3, 4};
  const double bytes = fieldBytes(options);
  EXPECT_NO_THROW(checkField(options, bytes * 0.501));
  const double memory = std::min(bytes * 0.499, kGibibyte / 2);
  const std::string message = messageOf([&] { checkField(options, memory); });
  EXPECT_THAT(message, testing::AllOf(testing::HasSubstr("p.yaml:3:4: particle: "),
                                      testing::HasSubstr("about " + shortBytes(bytes)),
                                      testing::HasSubstr("this process may take " + shortBytes(memory))));
  const std::string key = "voxels: ";
  const std::size_t at = message.find(key);
  ASSERT_NE(at, std::string::npos) << message;
  options.voxels = static_cast<std::uint32_t>(std::strtoul(message.c_str() + at + key.size(), nullptr, 10));
  EXPECT_LE(fieldBytes(options), memory) << message;
  options.levels = 2;
  const double ofTwo = fieldBytes(options);
  options.levels = 8;
  EXPECT_EQ(fieldBytes(options), 4 * ofTwo);
}

TEST(Shape, RefusesWhatIsTooFar) {
  for (const double x : {1e300, -1e300 * 1e300, std::nan("")}) {
    const std::string message = messageOf<Error>([&] { shapeOf(optionsOf(0.1, 64), {0, x, 0}, kStreet, 100); });
    EXPECT_THAT(message, testing::HasSubstr("too far"));
  }
}

}  // namespace
}  // namespace scanmill
