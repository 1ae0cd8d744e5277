// The presets against closed forms and against the vendors' own files.

#include <fmt/format.h>

#include <cstring>
#include <map>
#include <numeric>
#include <set>
#include <sstream>

#include "base/file.h"
#include "config/fields.h"
#include "sensors/calibration.h"
#include "sensors/sensor.h"
#include "tests/support/shared_data.h"
#include "tests/support/street.h"

namespace scanmill {
namespace {

using ::testing::HasSubstr;

TEST(Presets, EveryFileIsASensorWithASource) {
  int count = 0;
  const auto folder = std::filesystem::path(SCANMILL_SOURCE_DIR) / "pipelines" / "sensors";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const auto beams = presetBeams(entry.path().stem().string());
    EXPECT_NE(beams->model, "custom") << entry.path();
    EXPECT_FALSE(beams->source.empty()) << entry.path();
    EXPECT_GT(beams->maxRange, beams->minRange);
    ++count;
  }
  // All but the paper's sensor are counted in the README and on the page of sensors.
  for (const char* page : {"/README.md", "/docs/own_sensor.md"}) {
    EXPECT_THAT(readFile(std::string(SCANMILL_SOURCE_DIR) + page), HasSubstr(fmt::format("{} sensors of", count - 1)));
  }
}

TEST(Presets, Vlp16FollowsTheManual) {
  const auto beams = presetBeams("vlp_16");
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

// 7294 and -4664 revolutions a minute: after 30 s, and no sooner, both prisms are where they were.
TEST(Presets, Mid70DrawsARosetteThatRepeatsAfterHalfAMinute) {
  const auto first = presetBeams("livox_mid_70");
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

// Every point of a real turn lies on our beam: the vendor's decoder and our table agree on directions, origins, the way
// the sensor turns and the order of rings and columns.
TEST(Presets, Os1BeamsPassThroughARealRecording) {
  SKIP_WITHOUT_SHARED_DATA("lidar/ouster_os1_128/frame_1795.pcd");
  const std::string bytes = readFile(sharedData() / "lidar/ouster_os1_128/frame_1795.pcd");
  const std::string marker = "DATA binary\n";
  const char* row = bytes.data() + bytes.find(marker) + marker.size();
  constexpr std::size_t kRow = 4 * sizeof(float) + 1 + 3 * sizeof(std::uint16_t);

  const auto beams = presetBeams("os1_128");
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
  const auto beams = presetBeams(unit.preset);
  const auto real = makeBeams(
      parseYaml("{calibration: \"" + file.string() + "\", columns: 1000, rate_hz: 10, range_m: [1, 100]}", "unit"));
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
    testing::Values(Unit{"vlp_16", "velodyne/VLP16db.yaml", 1e-6, 1e-6},
                    Unit{"hdl_64e", "velodyne/64e_utexas.yaml", 0.4, 5.1e-4},
                    Unit{"os1_128", "ouster/OS-1-128_v2.3.0_1024x10.json", 1e-6, 1e-6},
                    Unit{"vlp_16_hires", "velodyne/VLP16_hires_db.yaml", 1e-3, 1e-6},
                    Unit{"vlp_32c", "velodyne/VeloView-VLP-32C.yaml", 1e-3, 0.01},
                    Unit{"hdl_32e", "velodyne/32db.yaml", 0.01, 1e-6},
                    Unit{"os0_32", "ouster/OS-0-32-U1_v2.2.0_1024x10.json", 1.4, 1.8},
                    Unit{"os0_128", "ouster/OS-0-128-U1_v2.3.0_1024x10.json", 1.7, 2.3},
                    Unit{"os1_32", "ouster/2_0_rc2_os-992011000121-32U0_legacy.json", 0.8, 0.1},
                    Unit{"os1_64", "ouster/2_1_2_os1-991913000010-64_legacy.json", 0.3, 0.4},
                    Unit{"os2_32", "ouster/OS-2-32-U0_v2.0.0_1024x10.json", 0.9, 0.1},
                    Unit{"os2_128", "ouster/OS-2-128-U1_v2.3.0_1024x10.json", 0.6, 0.1},
                    Unit{"pandar_xt_16", "hesai/angle_correction/PandarXT-16_Angle Correction File.csv", 1e-6, 1e-6},
                    Unit{"pandar_xt_32", "hesai/angle_correction/PandarXT_Angle Correction File.csv", 1e-6, 1e-6},
                    Unit{"pandar_xt_32m2x", "hesai/angle_correction/XT32M2X_Angle Correction File.csv", 0.1, 0.05},
                    Unit{"pandar_128", "hesai/angle_correction/Pandar128E3X_Angle Correction File.csv", 1e-6, 1e-6},
                    Unit{"pandar_qt_64", "hesai/angle_correction/PandarQT_Angle Correction File.csv", 1e-6, 1e-6},
                    Unit{"vls_128", "velodyne/VLS128.yaml", 1e-6, 1e-6}),
    [](const auto& unit) { return std::string(unit.param.preset); });

TEST(Presets, HesaisSensorsFireAsTheirTablesSay) {
  SKIP_WITHOUT_SHARED_DATA("sensors/hesai/firetime_correction");
  for (const auto& [name, file] : {std::pair{"pandar_xt_16", "PandarXT-16_Firetime Correction File.csv"},
                                   std::pair{"pandar_xt_32", "PandarXT-32_Firetime Correction File.csv"},
                                   std::pair{"pandar_qt_64", "PandarQT_Firetime Correction File.csv"},
                                   std::pair{"at_128", "AT128E2X_Firetime Correction File.csv"}}) {
    const auto beams = presetBeams(name);
    const std::vector<double> times = readFiringTable(sharedData() / "sensors/hesai/firetime_correction" / file);
    for (std::uint32_t ring = 0; ring < beams->rings; ++ring) {
      EXPECT_NEAR(beams->firingOffset[ring] * 1e6, times.at(ring), 0.01) << name << " " << ring;
    }
  }
}

// The table has the times (ns) of several states: column 9 is that of the standard mode for targets beyond 2.85 m.
TEST(Presets, Pandar128FiresAsItsTableSays) {
  const std::filesystem::path file = "sensors/hesai/firetime_correction/Pandar128E3X_Firetime Correction File.csv";
  SKIP_WITHOUT_SHARED_DATA(file);
  const auto beams = presetBeams("pandar_128");
  std::istringstream lines(readFile(sharedData() / file));
  std::string line;
  for (int head = 0; head < 3; ++head) std::getline(lines, line);
  for (std::uint32_t ring = 0; ring < 128; ++ring) {
    ASSERT_TRUE(std::getline(lines, line));
    std::istringstream cells(line);
    std::string cell;
    for (int column = 0; column <= 9; ++column) std::getline(cells, cell, ',');
    EXPECT_NEAR(beams->firingOffset[ring] * 1e9, std::stod(cell), 1e-6) << ring;
  }
}

// Hesai's binary file: int32 azimuths from byte 40, elevations from byte 552, in units of `resolution` / 25600 deg.
TEST(Presets, At128AgreesWithItsAngleFile) {
  const auto beams = presetBeams("at_128");
  EXPECT_EQ(beams->rings, 128u);
  EXPECT_NEAR(beams->columnPeriod(), 41.667e-6, 1e-9);
  const std::filesystem::path file = "sensors/hesai/angle_correction/AT128E2X_Angle Correction File.dat";
  SKIP_WITHOUT_SHARED_DATA(file);
  const std::string bytes = readFile(sharedData() / file);
  const auto numberAt = [&](std::size_t at) {
    std::int32_t number = 0;
    std::memcpy(&number, bytes.data() + at, sizeof(number));
    return number * (static_cast<unsigned char>(bytes[15]) / 25600.0);
  };
  for (std::uint32_t ring = 0; ring < 128; ++ring) {
    EXPECT_NEAR(degrees(beams->elevation[ring]), numberAt(552 + 4 * std::size_t{ring}), 1e-5) << ring;
    // The beam moves on, clockwise, until the laser fires.
    const double moved = -2400 * beams->firingOffset[ring];
    EXPECT_NEAR(degrees(beams->azimuthOffset[ring]) - moved, numberAt(40 + 4 * std::size_t{ring}), 1e-3) << ring;
  }
}

// VLS-128 User Manual 63-9483, section 9.4: groups of eight lasers, 2.665 us apart, with a pause after the eighth
// group.
TEST(Presets, Vls128FiresInGroupsOfEight) {
  const auto beams = presetBeams("vls_128");
  EXPECT_NEAR(beams->columnPeriod(), 53.3e-6, 0.01e-6);
  std::map<long, int> groups;
  for (const double time : beams->firingOffset) ++groups[std::lround(time / 2.665e-6)];
  EXPECT_EQ(groups.size(), 16u);
  EXPECT_FALSE(groups.contains(8));
  for (const auto& [group, lasers] : groups) EXPECT_EQ(lasers, 8) << group;
}

// The largest field of all firings within some seconds (deg): azimuths and elevations of the beams.
struct SeenField {
  double left = -180, right = 180, lowest = 90, highest = -90;
  std::size_t cells = 0;  // squares of one degree with a beam
};

SeenField seenField(const std::shared_ptr<const BeamTable>& first, int scans, double cell = 1) {
  SeenField field;
  std::set<std::pair<int, int>> cells;
  for (int scan = 0; scan < scans; ++scan) {
    const auto beams = beamsAt(first, scan * first->period);
    for (const Vec3d& d : beams->direction) {
      const double azimuth = degrees(std::atan2(d.y, d.x));
      const double elevation = degrees(std::asin(d.z));
      field.left = std::max(field.left, azimuth);
      field.right = std::min(field.right, azimuth);
      field.lowest = std::min(field.lowest, elevation);
      field.highest = std::max(field.highest, elevation);
      cells.emplace(static_cast<int>(std::floor(azimuth / cell)), static_cast<int>(std::floor(elevation / cell)));
    }
  }
  field.cells = cells.size();
  return field;
}

// Livox: 360 deg, -7 to 52 deg, 200,000 points/s. Two recordings of a unit (RoboSim, docs/LIVOX_MID360.md) cover 62 %
// of the cells of one degree in 0.1 s and 98 % in 1 s.
TEST(Presets, Mid360CoversItsField) {
  const auto beams = presetBeams("livox_mid_360");
  EXPECT_EQ(beams->rings, 4u);
  EXPECT_NEAR(static_cast<double>(beams->size()) / beams->period, 200e3, 1);
  const SeenField second = seenField(beams, 10);
  EXPECT_NEAR(second.lowest, -7, 0.5);
  EXPECT_NEAR(second.highest, 52, 2);
  EXPECT_GT(second.left - second.right, 359.9);
  constexpr double kCells = 360 * 59;
  EXPECT_NEAR(static_cast<double>(second.cells) / kCells, 0.976, 0.03);
  EXPECT_NEAR(static_cast<double>(seenField(beams, 1).cells) / kCells, 0.619, 0.03);
  EXPECT_NEAR(beams->time[std::size_t{3} * beams->columns] * 1e6, 15, 1e-3) << "lasers fire 5 us apart";
}

// Livox's figures: the field, and for the Horizon a coverage near 60 % in 0.1 s and near 100 % in 0.5 s (in cells as
// high as the beam, 0.28 deg, of what is seen in the end).
TEST(Presets, AviaAndHorizonFillTheirFields) {
  const auto avia = presetBeams("livox_avia");
  const auto horizon = presetBeams("livox_horizon");
  for (const auto& beams : {avia, horizon}) {
    EXPECT_EQ(beams->rings, 6u);
    EXPECT_NEAR(static_cast<double>(beams->size()) / beams->period, 240e3, 1);
  }
  const SeenField wide = seenField(avia, 100);
  EXPECT_NEAR(wide.left - wide.right, 70.4, 0.2);
  EXPECT_NEAR(wide.highest - wide.lowest, 77.2, 0.2);
  const SeenField flat = seenField(horizon, 100, 0.28);
  EXPECT_NEAR(flat.left - flat.right, 81.7, 0.2);
  EXPECT_NEAR(flat.highest - flat.lowest, 25.1, 0.2);
  EXPECT_NEAR(static_cast<double>(seenField(horizon, 1, 0.28).cells) / static_cast<double>(flat.cells), 0.6, 0.05);
  EXPECT_GT(static_cast<double>(seenField(horizon, 5, 0.28).cells) / static_cast<double>(flat.cells), 0.95);
}

// RoboSense: 120 x 25 deg, five zones of 126 lines of 125 points, 78,750 points a scan; lines 0.2 deg apart.
TEST(Presets, M1ScansItsZonesLineByLine) {
  const auto beams = presetBeams("rs_m1");
  EXPECT_EQ(beams->size(), 78750u);
  const SeenField field = seenField(beams, 1);
  EXPECT_NEAR(field.left, 60, 1e-9);
  EXPECT_NEAR(field.right, -60, 1e-9);
  EXPECT_NEAR(field.highest, 12.5, 1e-9);
  EXPECT_NEAR(field.lowest, -12.5, 1e-9);
  for (std::uint32_t column = 1; column < beams->columns; ++column) {
    const bool sameLine = column % 125 != 0;
    const Vec3d& before = beams->direction[column - 1];
    const Vec3d& d = beams->direction[column];
    EXPECT_NEAR(degrees(std::asin(before.z) - std::asin(d.z)), sameLine ? 0 : 0.2, 1e-9);
    if (sameLine) {
      EXPECT_NEAR(degrees(std::atan2(before.y, before.x) - std::atan2(d.y, d.x)), 0.2, 1e-9);
    }
    EXPECT_GT(beams->columnTime(column), beams->columnTime(column - 1));
    EXPECT_EQ(beams->time[column], beams->time[std::size_t{4} * beams->columns + column]) << "all zones at once";
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
       {Sheet{"lms111", 1, 541, 0.5, 270, 50, 20}, Sheet{"lms291", 1, 361, 0.5, 180, 37.5, 80},
        Sheet{"lms511", 1, 381, 0.5, 190, 50, 80}, Sheet{"tim571", 1, 811, 1 / 3.0, 270, 15, 25},
        Sheet{"utm_30lx", 1, 1081, 0.25, 270, 40, 30}, Sheet{"ust_10lx", 1, 1081, 0.25, 270, 40, 10},
        Sheet{"urg_04lx", 1, 682, 360 / 1024.0, 681 * 360 / 1024.0, 10, 5.6},
        Sheet{"ibeo_lux", 4, 341, 0.25, 85, 25, 200}, Sheet{"rs_lidar_16", 16, 1800, 0.2, 360, 10, 150},
        Sheet{"os_dome_128", 128, 1024, 360 / 1024.0, 360, 10, 45}, Sheet{"pandar_128", 128, 1800, 0.2, 360, 10, 200},
        Sheet{"pandar_qt_64", 64, 600, 0.6, 360, 10, 60}, Sheet{"at_128", 128, 1200, 0.1, 119.9, 10, 200},
        Sheet{"rs_ruby", 128, 1800, 0.2, 360, 10, 250}, Sheet{"vls_128", 128, 1876, 360 / 1876.0, 360, 10, 262.14}}) {
    SCOPED_TRACE(s.preset);
    const auto beams = presetBeams(s.preset);
    EXPECT_EQ(beams->rings, s.rings);
    ASSERT_EQ(beams->columns, s.columns);
    EXPECT_NEAR(degrees(beams->field), s.fieldDeg, 1e-9);
    EXPECT_NEAR(std::fabs(degrees(beams->azimuth(1) - beams->azimuth(0))), s.stepDeg, 1e-9);
    EXPECT_NEAR(1 / beams->period, s.hz, 1e-9);
    EXPECT_EQ(beams->maxRange, s.farthest);
    // What scans a plane looks ahead in its middle.
    if (s.rings > 1 || s.preset == std::string("urg_04lx")) continue;
    EXPECT_NEAR(beams->azimuth(0), -beams->azimuth(s.columns - 1), 1e-9);
  }
  // Step 384 of the URG-04LX, which begins at 44, looks ahead.
  EXPECT_NEAR(presetBeams("urg_04lx")->azimuth(384 - 44), 0, 1e-9);
  const auto dome = presetBeams("os_dome_128");
  EXPECT_NEAR(degrees(dome->elevation.front()), 90, 1e-9);
  EXPECT_NEAR(degrees(dome->elevation.back()), 0, 1e-9);
}

}  // namespace
}  // namespace scanmill
