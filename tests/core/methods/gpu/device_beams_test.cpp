// Rays that a device makes have the bits of those that the processor sets up.

#include "methods/gpu/device_beams.h"

#include <vector>

#include "methods/gpu/device_march.h"
#include "methods/world/resolve.h"
#include "tests/support/gl.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

// Six doubles a ray: origin and direction.
constexpr const char* kWriteRays = R"(
layout(std140, binding = 0) uniform Parameters { uint columns, rays, shotPoses, withOrigins; };
layout(std430, binding = 4) writeonly restrict buffer Written { double written[]; };
void invoke(uint i) {
  uint ray = i % rays;
  dvec3 o, d;
  rayOf(ray, ray % columns, i / rays * shotPoses, withOrigins != 0u, o, d);
  for (uint k = 0u; k < 3u; ++k) {
    written[6u * i + k] = o[k];
    written[6u * i + 3u + k] = d[k];
  }
}
)";

struct Maker {
  ComputeDevice device{{"tests cannot compute", "do it by hand"}};
  DeviceBeams beams{device};
  ComputeProgram program{device, "rays", std::string(kRaysShader) + kWriteRays};
  ComputeBuffer written{device};

  // Returns the rays of shots that share a table.
  std::vector<double> raysOf(const std::vector<Shot>& shots) {
    const BeamTable& table = *shots.front().beams;
    std::vector<ShotFrame> frames;
    for (const Shot& shot : shots) frames.push_back(frameOf(shot, {}));
    DeviceBeams::Shots together;
    for (std::size_t i = 0; i < shots.size(); ++i) {
      together.shots.push_back(&shots[i]);
      together.frames.push_back(&frames[i]);
    }
    const std::uint32_t count = table.rings * table.columns;
    beams.ensureUploaded(together);
    const std::uint32_t parameters[4]{table.columns, count,
                                      static_cast<std::uint32_t>(shots.front().worldFromSensor.size()),
                                      table.origin.empty() ? 0u : 1u};
    const std::size_t numbers = 6 * shots.size() * count;
    written.reserve(numbers * sizeof(double));
    program.run(shots.size() * count, {&beams.directions(), &beams.origins(), &beams.poses(), &beams.steps(), &written},
                std::as_bytes(std::span(parameters)));
    return copyOf<double>(device, written, numbers);
  }
};

std::vector<double> raysOnProcessor(const std::vector<Shot>& shots) {
  std::vector<double> made;
  for (const Shot& shot : shots) {
    const ShotFrame frame = frameOf(shot, {});
    for (std::uint32_t ring = 0; ring < shot.beams->rings; ++ring) {
      for (std::uint32_t column = 0; column < shot.beams->columns; ++column) {
        Rays rays;
        setUpRays(shot, frame, {ring, column, 1, 1}, rays);
        made.insert(made.end(), {rays.ox[0], rays.oy[0], rays.oz[0], rays.dx[0], rays.dy[0], rays.dz[0]});
      }
    }
  }
  return made;
}

Shot turning(std::shared_ptr<const BeamTable> beams, std::size_t poses, double start) {
  Shot shot;
  shot.beams = std::move(beams);
  for (std::size_t i = 0; i < poses; ++i) {
    const double t = start + 0.01 * static_cast<double>(i);
    shot.worldFromSensor.push_back({fromYawPitchRoll(3 * t, 0.1 + t, -0.2), {1e3 * t, -7, 1.9}});
  }
  return shot;
}

TEST(DeviceBeams, HaveTheProcessorsBits) {
  SKIP_WITHOUT_GL();
  Maker maker;
  auto plain = spinning(5, 300, -25, 5);
  auto shifted = spinning(4, 99, -25, 5);
  for (std::size_t i = 0; i < shifted->size(); ++i) shifted->origin.push_back({0.1f, 0.003f * float(i), -0.2f});
  for (const auto& beams : {plain, shifted}) {
    for (const std::size_t poses : {1u, 7u}) {
      const std::vector<Shot> shots{turning(beams, poses, 0.1), turning(beams, poses, 0.7), turning(beams, poses, 2)};
      EXPECT_EQ(maker.raysOf(shots), raysOnProcessor(shots));
    }
  }
}

// More tables take turns than stay on the device, and some are gone before their place is taken.
TEST(DeviceBeams, TablesTakeTurns) {
  SKIP_WITHOUT_GL();
  Maker maker;
  std::vector<std::shared_ptr<BeamTable>> tables;
  for (std::uint32_t i = 0; i < 12; ++i) tables.push_back(spinning(2 + i % 3, 40 + i, -20.0 - i, 5));
  for (int round = 0; round < 3; ++round) {
    for (const auto& beams : tables) {
      const std::vector<Shot> one{turning(beams, 1, 0.3 * round)};
      EXPECT_EQ(maker.raysOf(one), raysOnProcessor(one));
      const std::vector<Shot> gone{turning(spinning(3, 50, -30.0 + round, 1), 1, 0.5)};
      EXPECT_EQ(maker.raysOf(gone), raysOnProcessor(gone));
    }
  }
}

}  // namespace
}  // namespace scanmill
