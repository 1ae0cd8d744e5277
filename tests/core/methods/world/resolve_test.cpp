#include "methods/world/resolve.h"

#include <memory>
#include <utility>

#include "sensors/footprint.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

// A shot from poses that turn, climb and are far from the origin.
Shot drive(std::shared_ptr<const BeamTable> beams, std::size_t poses) {
  Shot shot = shotAt(std::move(beams));
  shot.worldFromSensor.clear();
  for (std::size_t i = 0; i < poses; ++i) {
    const double t = static_cast<double>(i);
    shot.worldFromSensor.push_back(
        {fromYawPitchRoll(0.01 * t, 0.02, 0.001 * t), {4e5 + 0.3 * t, -2e5 + 0.1 * t, 0.02 * t}});
  }
  return shot;
}

// All tables of rays: one ray a beam or seven, from one point or from points of their own.
std::vector<std::shared_ptr<const BeamTable>> tables() {
  auto plain = spinning(8, 50, -20, 5, 100);
  auto shifted = std::make_shared<BeamTable>(*plain);
  shifted->origin.resize(shifted->size());
  for (std::size_t i = 0; i < shifted->size(); ++i)
    shifted->origin[i] = {0.01f * static_cast<float>(i % 7), 0.02f, 0.03f};
  auto wide = std::make_shared<BeamTable>(*shifted);
  wide->divergence = {0.003, 0.001};
  return {plain, shifted, makeFootprint(*wide, 7).rays};
}

TEST(Resolve, RaysDoNotDependOnTheirPacket) {
  for (const auto& beams : tables()) {
    for (const std::size_t poses : {1, 7, 50}) {
      const Shot shot = drive(beams, poses);
      const Vec3d origin{4e5, -2e5, 0};
      const ShotFrame frame = frameOf(shot, origin);
      Rays row;
      Rays one;
      for (std::uint32_t column = 0; column < beams->columns; column += kPacket) {
        const std::uint32_t width = std::min<std::uint32_t>(kPacket, beams->columns - column);
        setUpRays(shot, frame, {3, column, 1, width}, row);
        ASSERT_EQ(row.count, static_cast<int>(width));
        for (std::uint32_t i = 0; i < width; ++i) {
          setUpRays(shot, frame, {3, column + i, 1, 1}, one);
          const std::size_t ray = std::size_t{3} * beams->columns + column + i;
          const Pose& pose = shot.worldFromSensor[shot.stepOf(column + i)];
          const Vec3d direction = toMatrix(pose.rotation) * beams->direction[ray];
          Vec3d start = pose.translation - origin;
          if (!beams->origin.empty()) start += toMatrix(pose.rotation) * Vec3d(beams->origin[ray]);
          for (const auto& [rays, lane] : {std::pair(&row, i), std::pair(&one, 0u)}) {
            ASSERT_EQ((Vec3d{rays->dx[lane], rays->dy[lane], rays->dz[lane]}), direction) << column + i;
            ASSERT_EQ((Vec3d{rays->ox[lane], rays->oy[lane], rays->oz[lane]}), start) << column + i;
          }
        }
      }
    }
  }
}

TEST(Resolve, PartsAreThoseOfTheRays) {
  for (const auto& beams : tables()) {
    const Shot shot = drive(beams, 7);
    for (const double duration : {0.0, 0.1, 0.05}) {
      const ShotFrame frame = frameOf(shot, {}, duration);
      const Tile tile{2, 8, 2, 8};
      float parts[kPacket];
      fillFiringFractions(shot, frame, tile, duration, parts);
      for (std::uint32_t lane = 0; lane < kPacket; ++lane) {
        const std::size_t ray = std::size_t{tile.ring + lane / 8} * beams->columns + tile.column + lane % 8;
        EXPECT_EQ(parts[lane], firingFraction(*beams, ray, duration));
      }
    }
  }
}

}  // namespace
}  // namespace scanmill
