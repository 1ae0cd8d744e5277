// Sensors whose beams do not lie on cones, from the pipeline to the manifest that others read.

#include <fmt/format.h>

#include <array>

#include "sensors/beams.h"
#include "tests/core/pipeline/small_world.h"
#include "tests/support/gl.h"

namespace scanmill {
namespace {

class Patterns : public Yard {
 protected:
  Patterns() {
    std::string table = "azimuth_deg,elevation_deg,time_us,ring,column,origin_y_m\n";
    for (int ring = 0; ring < 3; ++ring) {
      for (int column = 0; column < 40; ++column) {
        table +=
            fmt::format("{},{},{},{},{},{}\n", 9.1 * column - 170 + ring, 4 * std::sin(0.7 * column) - 3 * ring - 2,
                        2000 * column + ring, ring, column, 0.05 * ring);
      }
    }
    folder_.write("scenes/beams.csv", table);
    folder_.write("beams.csv", table);
  }
  static std::string sensor(const std::string& keys) {
    return "sensors=[{name: top, rate_hz: 10, range_m: [0.2, 100], mount: {position: [0, 0, 1.8]}, " + keys + "}]";
  }
  // Every point lies on the beam of the manifest's table that its ring and column name, at its range.
  void expectOnBeams(const std::string& name, double within) const {
    const Manifest manifest = readManifest(out(name));
    auto table = std::make_shared<BeamTable>(manifest.sensors.at(0).beams);
    fillBeams(*table);
    const std::vector<Scan> all = scans(".pcd", name);
    ASSERT_EQ(all.size(), manifest.samples.size());
    for (std::size_t s = 0; s < all.size(); ++s) {
      const auto beams = beamsAt(table, manifest.samples[s].scans.at(0).time);
      ASSERT_GT(all[s].size(), 0.9 * static_cast<double>(beams->size())) << "the yard is closed all around";
      for (std::size_t i = 0; i < all[s].size(); ++i) {
        const std::size_t beam = std::size_t{all[s][kRing][i]} * beams->columns + all[s][kColumn][i];
        const Vec3d origin = beams->origin.empty() ? Vec3d{} : Vec3d(beams->origin[beam]);
        const Vec3d expected = origin + beams->direction[beam] * double{all[s][kRangeTrue][i]};
        ASSERT_LT(length(Vec3d(all[s].position[i]) - expected), within) << s << ": " << beam;
        ASSERT_FLOAT_EQ(all[s][kTime][i], beams->time[beam]);
      }
    }
  }
};

constexpr const char* kPatterns[] = {
    "pattern: flash, columns: 24, first_azimuth_deg: -30, field_deg: 60, elevation_deg: {top: 10, bottom: -20, rings: "
    "12}",
    "beams: beams.csv",
    "columns: 500, rosette: {field_deg: 40, turns_hz: [121.57, -77.73]}",
    "columns: 250, firing_time_us: [0, 90], rosette: {deflection_deg: [9, 1], turns_hz: [171, -30], laser_azimuth_deg: "
    "[0, "
    "2], mirror: {tilt_deg: 47, turns_hz: 181, phase_deg: 5}}",
    "columns: 100, field_deg: 120, sweep_ms: 60, first_azimuth_deg: 60, direction: clockwise, elevation_deg: [5, 0, "
    "-5], "
    "firing_time_us: {step_us: 10}, turns_while_firing: true",
    "columns: 120, raster: {zones_deg: [12, -12], width_deg: 24, top_deg: 5, bottom_deg: -9, lines: 10, line_us: "
    "8000}"};

TEST_F(Patterns, PointsLieOnTheManifestsBeams) {
  int number = 0;
  for (const char* pattern : kPatterns) {
    const std::string name = fmt::format("p{}", number++);
    sound({sensor(pattern), "motion=per_column"}, name);
    expectOnBeams(name, 2e-5);
    const Manifest manifest = readManifest(out(name));
    EXPECT_EQ(toJson(parseManifest(toJson(manifest), "m.json")), toJson(manifest));
  }
}

// The ranges of the others are those of ray tracing, but for a few beams at edges.
TEST_F(Patterns, OfAllMethodsAgree) {
  SKIP_WITHOUT_GL();
  int number = 0;
  const auto rangesOf = [&](const char* pattern, const std::string& method) {
    const std::string name = fmt::format("m{}", number++);
    sound({sensor(pattern), "method=" + method, "trajectories.0.frames=2"}, name);
    expectOnBeams(name, 2e-5);
    std::map<std::array<std::size_t, 3>, double> ranges;
    const std::vector<Scan> all = scans(".pcd", name);
    for (std::size_t s = 0; s < all.size(); ++s) {
      for (std::size_t i = 0; i < all[s].size(); ++i) {
        ranges[{s, all[s][kRing][i], all[s][kColumn][i]}] = double{all[s][kRangeTrue][i]};
      }
    }
    return ranges;
  };
  for (const char* pattern : kPatterns) {
    const auto exact = rangesOf(pattern, "ray_tracing");
    for (const char* method : {"particle", "depth_camera"}) {
      const auto other = rangesOf(pattern, method);
      std::size_t close = 0;
      for (const auto& [beam, range] : exact) {
        const auto found = other.find(beam);
        close += found != other.end() && std::fabs(found->second - range) < 0.05 ? 1 : 0;
      }
      EXPECT_GT(static_cast<double>(close), 0.98 * static_cast<double>(exact.size())) << method << ": " << pattern;
    }
  }
}

// Rays of a footprint start with their beam's column.
TEST_F(Patterns, AFlashMayHaveAFootprint) {
  const std::string flash = sensor(std::string(kPatterns[0]) + ", divergence_mrad: 3, pulse_ns: 5");
  const Manifest m = sound({flash, "effects=[intensity, footprint: {rays: 7}, detection]", "motion=per_column"});
  EXPECT_GT(m.samples.at(0).scans.at(0).points, 24u * 12 * 9 / 10);
  folder_.write("scenes/yard.yaml", yardScene() + "    moving: {velocity: [1, 0, 0]}\n");
  sound({flash, "effects=[intensity, footprint: {rays: 7}, detection]", "motion=per_column"}, "moving");
}

TEST_F(Patterns, WhatARosetteCannotHaveIsRefused) {
  const std::string rosette = sensor(std::string(kPatterns[2]) + ", divergence_mrad: 3, pulse_ns: 5");
  EXPECT_THAT(messageOf([&] {
                run({rosette, "effects=[intensity, footprint: {rays: 7}, detection]"});
              }),
              AllOf(HasSubstr("effect footprint"), HasSubstr("effects: sensor")));
}

}  // namespace
}  // namespace scanmill
