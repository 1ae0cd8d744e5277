// The presets against closed forms and against the vendors' own files.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "base/file.h"
#include "config/fields.h"
#include "sensors/beam_files.h"
#include "sensors/sensor.h"
#include "tests/support/shared_data.h"

namespace scanmill {
namespace {

using ::testing::HasSubstr;

std::shared_ptr<const BeamTable> preset(const std::string& name) {
  return makeBeams(readYaml(std::filesystem::path(SCANMILL_SOURCE_DIR) / "pipelines" / "sensors" / name));
}

std::vector<double> numbersOf(const Value& map, const char* key) {
  return readNumbers(*map.find(key), key);
}

TEST(Presets, EveryFileIsASensorWithASource) {
  int count = 0;
  const auto folder = std::filesystem::path(SCANMILL_SOURCE_DIR) / "pipelines" / "sensors";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const auto beams = preset(entry.path().filename().string());
    EXPECT_NE(beams->model, "custom") << entry.path();
    EXPECT_FALSE(beams->source.empty()) << entry.path();
    EXPECT_GT(beams->maxRange, beams->minRange);
    ++count;
  }
  // All but the paper's sensor are counted in the README and in the guide.
  for (const char* page : {"/README.md", "/docs/guide.md"}) {
    EXPECT_THAT(readFile(std::string(SCANMILL_SOURCE_DIR) + page), HasSubstr(fmt::format("{} sensors of", count - 1)));
  }
}

TEST(Presets, Vlp16FollowsTheManual) {
  const auto beams = preset("vlp_16.yaml");
  ASSERT_EQ(beams->rings, 16u);
  EXPECT_FALSE(beams->topDown);
  for (std::uint32_t ring = 0; ring < 16; ++ring) {
    const int laser = static_cast<int>(ring < 8 ? 2 * ring : 2 * (ring - 8) + 1);
    EXPECT_NEAR(degrees(beams->elevation[ring]), -15.0 + 2 * ring, 1e-12);
    EXPECT_NEAR(beams->firingOffset[ring], laser * 2.304e-6, 1e-12);
    // What the head turns until the laser fires, clockwise.
    EXPECT_NEAR(degrees(beams->azimuthOffset[ring]), -3600 * beams->firingOffset[ring], 1e-9);
  }
  EXPECT_NEAR(beams->columnPeriod(), 55.296e-6, 0.02e-6);
}

TEST(Presets, Vlp16AgreesWithTheCalibrationTable) {
  SKIP_WITHOUT_SHARED_DATA("sensors/velodyne/VLP16db.yaml");
  const Value file = readYaml(sharedData() / "sensors/velodyne/VLP16db.yaml");
  const auto beams = preset("vlp_16.yaml");
  for (const Value& laser : file.find("lasers")->items) {
    const double elevation = readNumber(*laser.find("vert_correction"), "vert_correction");
    const auto id = readInteger(*laser.find("laser_id"), "laser_id", 0, 15);
    const auto ring = std::find_if(beams->elevation.begin(), beams->elevation.end(),
                                   [&](double e) { return std::fabs(e - elevation) < 1e-9; });
    ASSERT_NE(ring, beams->elevation.end());
    EXPECT_NEAR(beams->firingOffset[ring - beams->elevation.begin()], static_cast<double>(id) * 2.304e-6, 1e-12);
  }
}

// 7294 and -4664 revolutions a minute: after 30 s, and no sooner, both prisms are where they were.
TEST(Presets, Mid70DrawsARosetteThatRepeatsAfterHalfAMinute) {
  const auto first = preset("livox_mid_70.yaml");
  EXPECT_EQ(first->size(), 10000u);
  EXPECT_NEAR(first->time[1], 1e-5, 1e-9);
  double widest = 0;
  for (const Vec3d& d : first->direction) widest = std::max(widest, degrees(std::acos(d.x)));
  EXPECT_NEAR(widest, 35.2, 0.01);
  const auto apart = [&](double time) {
    const auto later = beamsAt(first, time);
    double most = 0;
    for (std::size_t i = 0; i < first->size(); ++i) {
      most = std::max(most, length(later->direction[i] - first->direction[i]));
    }
    return most;
  };
  EXPECT_LT(apart(30), 0.01);
  for (int tenths = 1; tenths < 300; tenths += 7) EXPECT_GT(apart(0.1 * tenths), 0.02) << tenths;
}

TEST(Presets, Paper64SpansItsFieldOfView) {
  const auto beams = preset("paper_64.yaml");
  EXPECT_EQ(beams->rings, 64u);
  EXPECT_EQ(beams->columns, 2048u);
  EXPECT_NEAR(degrees(beams->elevation.front() - beams->elevation.back()), 26.8, 1e-12);
  for (std::size_t ring = 1; ring < 64; ++ring) {
    EXPECT_NEAR(degrees(beams->elevation[ring - 1] - beams->elevation[ring]), 26.8 / 63, 1e-12);
  }
}

TEST(Presets, Hdl64eAgreesWithTheCalibrationTable) {
  const auto beams = preset("hdl_64e.yaml");
  ASSERT_EQ(beams->rings, 64u);
  EXPECT_TRUE(beams->topDown);
  SKIP_WITHOUT_SHARED_DATA("sensors/velodyne/64e_utexas.yaml");
  const Value file = readYaml(sharedData() / "sensors/velodyne/64e_utexas.yaml");
  std::vector<std::pair<double, double>> lasers;
  for (const Value& laser : file.find("lasers")->items) {
    lasers.emplace_back(readNumber(*laser.find("vert_correction"), "vert_correction"),
                        readNumber(*laser.find("rot_correction"), "rot_correction"));
  }
  std::sort(lasers.rbegin(), lasers.rend());
  ASSERT_EQ(lasers.size(), 64u);
  for (std::size_t ring = 0; ring < 64; ++ring) {
    EXPECT_NEAR(degrees(beams->elevation[ring]), degrees(lasers[ring].first), 5.1e-4);
    EXPECT_NEAR(degrees(beams->azimuthOffset[ring]), degrees(lasers[ring].second), 5.1e-4);
  }
}

TEST(Presets, Os1AgreesWithItsMetadata) {
  const auto beams = preset("os1_128.yaml");
  ASSERT_EQ(beams->rings, 128u);
  EXPECT_EQ(beams->columns, 1024u);
  EXPECT_TRUE(beams->topDown);
  EXPECT_TRUE(beams->clockwise);
  SKIP_WITHOUT_SHARED_DATA("sensors/ouster/OS-1-128_v2.3.0_1024x10.json");
  const Value file = readYaml(sharedData() / "sensors/ouster/OS-1-128_v2.3.0_1024x10.json");  // JSON is YAML
  const std::vector<double> altitude = numbersOf(file, "beam_altitude_angles");
  const std::vector<double> azimuth = numbersOf(file, "beam_azimuth_angles");
  ASSERT_EQ(altitude.size(), 128u);
  for (std::size_t ring = 0; ring < 128; ++ring) {
    EXPECT_NEAR(degrees(beams->elevation[ring]), altitude[ring], 1e-12);
    EXPECT_NEAR(degrees(beams->azimuthOffset[ring]), -azimuth[ring], 1e-12);
  }
  EXPECT_DOUBLE_EQ(beams->originOffset * 1000, readNumber(*file.find("lidar_origin_to_beam_origin_mm"), "n"));
  EXPECT_NEAR(beams->originHeight * 1000, numbersOf(file, "lidar_to_sensor_transform")[11], 1e-12);
}

// Every point of a real turn lies on our beam: the vendor's decoder and our table agree on directions, origins, the way
// the sensor turns and the order of rings and columns.
TEST(Presets, Os1BeamsPassThroughARealRecording) {
  SKIP_WITHOUT_SHARED_DATA("lidar/ouster_os1_128/frame_1795.pcd");
  const std::string bytes = readFile(sharedData() / "lidar/ouster_os1_128/frame_1795.pcd");
  const std::string marker = "DATA binary\n";
  const char* row = bytes.data() + bytes.find(marker) + marker.size();
  constexpr std::size_t kRow = 4 * sizeof(float) + 1 + 3 * sizeof(std::uint16_t);

  const auto beams = preset("os1_128.yaml");
  ASSERT_GE(bytes.size() - static_cast<std::size_t>(row - bytes.data()), beams->size() * kRow);
  std::size_t hits = 0;
  double worst = 0;
  for (std::size_t i = 0; i < beams->size(); ++i, row += kRow) {
    float point[4];  // x y z range, lidar frame: half a turn and 36.18 mm from the sensor frame
    std::uint16_t place[2];
    std::memcpy(point, row, sizeof(point));
    std::memcpy(place, row + kRow - sizeof(place), sizeof(place));
    if (!std::isfinite(point[0])) continue;
    ++hits;
    const std::size_t beam = std::size_t{place[0]} * beams->columns + place[1];
    const Vec3d measured{-point[0], -point[1], point[2] + beams->originHeight};
    const double range = point[3] - beams->originOffset;  // the sensor counts from its axis
    const Vec3d ours = static_cast<Vec3d>(beams->origin[beam]) + beams->direction[beam] * range;
    worst = std::max(worst, length(ours - measured));
  }
  EXPECT_GT(hits, 100000u);
  EXPECT_LT(worst, 5e-5);  // float32 positions at up to 217 m
}

// Unused beams of 32- and 16-beam sensors are zeros in between, hence unordered.
TEST(Presets, EveryOusterBeamTableCanBeDescribed) {
  SKIP_WITHOUT_SHARED_DATA("sensors/ouster");
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(sharedData() / "sensors/ouster")) {
    if (entry.path().extension() != ".json") continue;
    std::string text = readFile(entry.path());
    std::replace(text.begin(), text.end(), '\t', ' ');  // JSON allows tabs, YAML does not
    const Value file = parseYaml(text, entry.path().string());
    const Value* intrinsics = file.kind == Value::Kind::Map ? file.find("beam_intrinsics") : nullptr;
    const Value& angles = intrinsics != nullptr ? *intrinsics : file;
    const Value* altitude = angles.find("beam_altitude_angles");
    if (altitude == nullptr) continue;
    Value sensor = parseYaml("{columns: 512, rate_hz: 10, range_m: [0.3, 100], ring_order: unordered}", "s.yaml");
    sensor.entries.push_back({"elevation_deg", *altitude});
    sensor.entries.push_back({"azimuth_offset_deg", *angles.find("beam_azimuth_angles")});
    EXPECT_EQ(makeBeams(sensor)->rings, altitude->items.size()) << entry.path();
    ++count;
  }
  EXPECT_GT(count, 5);
}

// A preset against a calibration of a real unit: elevations and azimuths to within what units differ by.
struct Unit {
  const char* preset;
  const char* file;
  double elevation, azimuth;  // deg
};

class PresetsOfUnits : public testing::TestWithParam<Unit> {};

TEST_P(PresetsOfUnits, AgreeWithTheVendorsFile) {
  const Unit& unit = GetParam();
  const auto file = sharedData() / "sensors" / unit.file;
  SKIP_WITHOUT_SHARED_DATA(std::filesystem::path("sensors") / unit.file);
  const auto beams = preset(unit.preset);
  const auto real = makeBeams(parseYaml(
      "{calibration: \"" + file.string() + "\", columns: 1000, rate_hz: 10, range_m: [1, 100]}", "unit.yaml"));
  ASSERT_EQ(beams->rings, real->rings);
  // Rings of some count upwards, and the real azimuths are without what the head turns until a laser fires, and with
  // an offset that all lasers of a unit have.
  std::vector<std::size_t> order(real->rings);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) {
    return beams->topDown ? real->elevation[a] > real->elevation[b] : real->elevation[a] < real->elevation[b];
  });
  const auto azimuthOf = [&](std::uint32_t ring) {
    const double turned = 2 * kPi / beams->period * beams->firingOffset[ring];
    return beams->azimuthOffset[ring] + turned - real->azimuthOffset[order[ring]];
  };
  double common = 0;
  for (std::uint32_t ring = 0; ring < beams->rings; ++ring) common += azimuthOf(ring) / beams->rings;
  for (std::uint32_t ring = 0; ring < beams->rings; ++ring) {
    EXPECT_NEAR(degrees(beams->elevation[ring]), degrees(real->elevation[order[ring]]), unit.elevation) << ring;
    EXPECT_NEAR(degrees(azimuthOf(ring)), degrees(common), unit.azimuth) << ring;
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, PresetsOfUnits,
    testing::Values(
        Unit{"vlp_16_hires.yaml", "velodyne/VLP16_hires_db.yaml", 1e-3, 1e-6},
        Unit{"vlp_32c.yaml", "velodyne/VeloView-VLP-32C.yaml", 1e-3, 0.01},
        Unit{"hdl_32e.yaml", "velodyne/32db.yaml", 0.01, 1e-6},
        Unit{"os0_32.yaml", "ouster/OS-0-32-U1_v2.2.0_1024x10.json", 1.4, 1.8},
        Unit{"os0_128.yaml", "ouster/OS-0-128-U1_v2.3.0_1024x10.json", 1.7, 2.3},
        Unit{"os1_32.yaml", "ouster/2_0_rc2_os-992011000121-32U0_legacy.json", 0.8, 0.1},
        Unit{"os1_64.yaml", "ouster/2_1_2_os1-991913000010-64_legacy.json", 0.3, 0.4},
        Unit{"os2_32.yaml", "ouster/OS-2-32-U0_v2.0.0_1024x10.json", 0.9, 0.1},
        Unit{"os2_128.yaml", "ouster/OS-2-128-U1_v2.3.0_1024x10.json", 0.6, 0.1},
        Unit{"pandar_xt_16.yaml", "hesai/angle_correction/PandarXT-16_Angle Correction File.csv", 1e-6, 1e-6},
        Unit{"pandar_xt_32.yaml", "hesai/angle_correction/PandarXT_Angle Correction File.csv", 1e-6, 1e-6},
        Unit{"pandar_xt_32m2x.yaml", "hesai/angle_correction/XT32M2X_Angle Correction File.csv", 0.1, 0.05}),
    [](const auto& unit) {
      const std::string name = unit.param.preset;
      return name.substr(0, name.find('.'));
    });

TEST(Presets, PandarXtFiresAsItsTableSays) {
  SKIP_WITHOUT_SHARED_DATA("sensors/hesai/firetime_correction");
  for (const auto& [name, file] : {std::pair{"pandar_xt_16.yaml", "PandarXT-16_Firetime Correction File.csv"},
                                   std::pair{"pandar_xt_32.yaml", "PandarXT-32_Firetime Correction File.csv"}}) {
    const auto beams = preset(name);
    const std::vector<double> times = readFiringTable(sharedData() / "sensors/hesai/firetime_correction" / file);
    for (std::uint32_t ring = 0; ring < beams->rings; ++ring) {
      EXPECT_NEAR(beams->firingOffset[ring] * 1e6, times.at(ring), 0.01) << name << " " << ring;
    }
  }
}

// Scanners of a plane and others, by the figures of their data sheets: steps, field, where the first column looks.
TEST(Presets, OthersFollowTheirDataSheets) {
  struct Sheet {
    const char* preset;
    std::uint32_t rings, columns;
    double stepDeg, fieldDeg, hz, farthest;
  };
  for (const Sheet& s :
       {Sheet{"lms111.yaml", 1, 541, 0.5, 270, 50, 20}, Sheet{"lms291.yaml", 1, 361, 0.5, 180, 37.5, 80},
        Sheet{"lms511.yaml", 1, 381, 0.5, 190, 50, 80}, Sheet{"tim571.yaml", 1, 811, 1 / 3.0, 270, 15, 25},
        Sheet{"utm_30lx.yaml", 1, 1081, 0.25, 270, 40, 30}, Sheet{"ust_10lx.yaml", 1, 1081, 0.25, 270, 40, 10},
        Sheet{"urg_04lx.yaml", 1, 682, 360 / 1024.0, 681 * 360 / 1024.0, 10, 5.6},
        Sheet{"ibeo_lux.yaml", 4, 341, 0.25, 85, 25, 200}, Sheet{"rs_lidar_16.yaml", 16, 1800, 0.2, 360, 10, 150},
        Sheet{"os_dome_128.yaml", 128, 1024, 360 / 1024.0, 360, 10, 45}}) {
    SCOPED_TRACE(s.preset);
    const auto beams = preset(s.preset);
    EXPECT_EQ(beams->rings, s.rings);
    ASSERT_EQ(beams->columns, s.columns);
    EXPECT_NEAR(degrees(beams->field), s.fieldDeg, 1e-9);
    EXPECT_NEAR(std::fabs(degrees(beams->azimuth(1) - beams->azimuth(0))), s.stepDeg, 1e-9);
    EXPECT_NEAR(1 / beams->period, s.hz, 1e-9);
    EXPECT_EQ(beams->maxRange, s.farthest);
    // What scans a plane looks ahead in its middle.
    if (s.rings > 1 || s.preset == std::string("urg_04lx.yaml")) continue;
    EXPECT_NEAR(beams->azimuth(0), -beams->azimuth(s.columns - 1), 1e-9);
  }
  // Step 384 of the URG-04LX, which begins at 44, looks ahead.
  EXPECT_NEAR(preset("urg_04lx.yaml")->azimuth(384 - 44), 0, 1e-9);
  const auto dome = preset("os_dome_128.yaml");
  EXPECT_NEAR(degrees(dome->elevation.front()), 90, 1e-9);
  EXPECT_NEAR(degrees(dome->elevation.back()), 0, 1e-9);
}

}  // namespace
}  // namespace scanmill
