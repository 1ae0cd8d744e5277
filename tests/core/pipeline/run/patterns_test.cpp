// Sensors whose beams do not lie on cones, from the pipeline to the manifest that others read.

#include <fmt/format.h>

#include <array>
#include <map>
#include <utility>

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
    "8000}",
    "columns: 130, lines: {mirror: oscillating, rate_hz: 40, field_deg: 150}"};

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

// The sectors of a sample together see what a turn sees at once, at each of two places of a tripod.
TEST_F(Patterns, SectorsOfASampleAreItsTurn) {
  const std::string places = "trajectories=[{name: tripod, poses: [{}, {position: [4, 3, 0], yaw_deg: 40}]}]";
  const std::string keys = "columns: 120, elevation_deg: {top: 60, bottom: -60, rings: 40}";
  const Manifest whole = sound({sensor(keys), places}, "whole");
  const Manifest parts = sound({sensor(keys + ", sectors: 12"), places}, "parts");
  const MembersByName turns = members("whole");
  const MembersByName sectors = members("parts");
  ASSERT_EQ(parts.samples.size(), 2u);
  for (const SampleRecord& sample : parts.samples) {
    ASSERT_EQ(sample.scans.size(), 12u);
    const std::string turnName = sample.key + ".top.ray_tracing.pcd";
    const Scan turn = decodeMember(turnName, turns.at(turnName));
    std::map<std::pair<std::size_t, std::size_t>, Vec3d> seen;
    for (std::size_t k = 0; k < 12; ++k) {
      const ScanRecord& record = sample.scans[k];
      EXPECT_NEAR(record.time, 0.1 * (&sample == &parts.samples[1]) + 0.1 / 12 * static_cast<double>(k), 1e-12);
      const std::string name = fmt::format("{}.{}.ray_tracing.pcd", sample.key, revolutionName(record));
      const Scan scan = decodeMember(name, sectors.at(name));
      for (std::size_t i = 0; i < scan.size(); ++i) {
        EXPECT_LT(scan[kColumn][i], 10);
        seen[{scan[kRing][i], 10 * k + scan[kColumn][i]}] = Vec3d(scan.position[i]);
      }
    }
    ASSERT_EQ(seen.size(), turn.size());
    for (std::size_t i = 0; i < turn.size(); ++i) {
      const auto place = seen.find({turn[kRing][i], turn[kColumn][i]});
      ASSERT_TRUE(place != seen.end() && length(place->second - Vec3d(turn.position[i])) < 1e-4) << i;
    }
  }
  EXPECT_THAT(refusal({sensor(keys + ", sectors: 12"), places, "output.objects=true"}), HasSubstr("boxes of objects"));
  EXPECT_THAT(refusal({sensor(keys + ", sectors: 12"), "trajectories.0.every_s=0.25"}),
              HasSubstr("begin with its turns"));
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
