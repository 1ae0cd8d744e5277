#include "sensors/beam_patterns.h"

#include <fmt/format.h>

#include <set>

#include "sensors/sensor.h"
#include "sensors/shot.h"
#include "sensors/trajectory.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class BeamPatterns : public testing::Test {
 protected:
  std::shared_ptr<const BeamTable> sensor(const std::string& yaml) const {
    return makeBeams(resolveSensor(parseYaml("{" + yaml + "}", (folder_.path() / "s.yaml").string())));
  }
  std::string refusal(const std::string& yaml) const {
    return messageOf([&] { sensor(yaml); });
  }
  TemporaryFolder folder_;
};

constexpr const char* kFlash =
    "pattern: flash, columns: 9, rate_hz: 20, range_m: [0, 50], first_azimuth_deg: 40, "
    "direction: clockwise, field_deg: 80, elevation_deg: {top: 30, bottom: -30, rings: 5}";

// A camera's pixels: on the plane x = 1 they are an even grid, and all fire at once.
TEST_F(BeamPatterns, AFlashIsAnEvenGridInItsPlane) {
  const auto beams = sensor(kFlash);
  ASSERT_EQ(beams->size(), 45u);
  for (std::uint32_t ring = 0; ring < 5; ++ring) {
    for (std::uint32_t column = 0; column < 9; ++column) {
      const Vec3d d = beams->direction[ring * 9 + column];
      EXPECT_NEAR(length(d), 1, 1e-12);
      EXPECT_NEAR(d.y / d.x, std::tan(radians(40)) * (1 - column / 4.0), 1e-12);
      EXPECT_NEAR(d.z / d.x, std::tan(radians(30 - 15.0 * ring)), 1e-12);
      EXPECT_EQ(beams->time[ring * 9 + column], 0);
      EXPECT_EQ(beams->columnTime(column), 0);
    }
  }
  EXPECT_THAT(refusal(std::string(kFlash) + ", firing_time_us: {step_us: 1}"),
              HasSubstr("firing_time_us has no effect"));
  std::string wide = kFlash;
  wide.replace(wide.find("field_deg: 80"), 13, "field_deg: 360");
  EXPECT_THAT(refusal(wide), HasSubstr("at most 170"));
}

TEST_F(BeamPatterns, ListedBeamsAreWhatTheTableSays) {
  folder_.write(
      "b.csv",
      "ring,column,azimuth_deg,elevation_deg,time_us,origin_z_m\n1,0,10,-5,7,0.1\n0,1,20,5,100,0\n0,0,30,6,5,0\n"
      "1,1,-170,0,120,0\n");
  const auto beams = sensor("beams: b.csv, rate_hz: 10, range_m: [0, 50]");
  ASSERT_EQ(beams->rings, 2u);
  ASSERT_EQ(beams->columns, 2u);
  EXPECT_NEAR(degrees(std::atan2(beams->direction[2].y, beams->direction[2].x)), 10, 1e-12);
  EXPECT_NEAR(degrees(std::asin(beams->direction[2].z)), -5, 1e-12);
  EXPECT_FLOAT_EQ(beams->time[2], 7e-6f);
  EXPECT_FLOAT_EQ(beams->origin[2].z, 0.1f);
  EXPECT_DOUBLE_EQ(beams->columnTime(0), 5e-6);
  EXPECT_DOUBLE_EQ(beams->columnTime(1), 100e-6);
  // Without rings each line is a column.
  folder_.write("c.csv", "azimuth_deg;elevation_deg\n1;2\n3;4\n5;6\n");
  EXPECT_EQ(sensor("beams: c.csv, rate_hz: 10, range_m: [0, 50]")->columns, 3u);
}

// Tables of Livox's simulation have seconds, and angles from straight up.
TEST_F(BeamPatterns, TablesStateTheirUnits) {
  folder_.write("b.csv", "Time/s,Azimuth/deg,Zenith/deg\n0,0,90\n0.00001,90,60\n0.05,180,100\n");
  const auto beams = sensor("beams: b.csv, rate_hz: 10, range_m: [0, 50]");
  ASSERT_EQ(beams->columns, 3u);
  EXPECT_DOUBLE_EQ(beams->columnTime(1), 1e-5);
  EXPECT_DOUBLE_EQ(beams->columnTime(2), 0.05);
  EXPECT_NEAR(degrees(std::asin(beams->direction[1].z)), 30, 1e-12);
  EXPECT_NEAR(degrees(std::asin(beams->direction[2].z)), -10, 1e-12);
  EXPECT_NEAR(beams->direction[1].y, std::cos(radians(30)), 1e-12);
}

TEST_F(BeamPatterns, TablesThatAreNoneAreRefused) {
  const auto refuse = [&](const std::string& table) {
    folder_.write("b.csv", table);
    return refusal("beams: b.csv, rate_hz: 10, range_m: [0, 50]");
  };
  expectRefusals(
      refuse, {{"elevation_deg\n1\n", "b.csv:1: the table has no column azimuth_deg"},
               {"azimuth_deg\n1\n", "needs one of the columns elevation_deg"},
               {"azimuth_rad,elevation_deg\n1,2\n", "did you mean 'azimuth_deg'? Its unit is deg"},
               {"time,azimuth_deg,elevation_deg\n0,1,2\n", "the column 'time' is unknown"},
               {"azimuth_deg,elevation_deg,ring\n1,2,0\n", "both or none"},
               {"azimuth_deg,elevation_deg\n1,91\n", "b.csv:2: elevation_deg is 91, but must be from -90 to 90"},
               {"azimuth_deg,elevation_deg,ring,column\n1,2,0,0\n1,2,0,0\n", "2 beams, but 1 rings"},
               {"azimuth_deg,elevation_deg,ring,column\n1,2,0,0\n1,2,1,1\n1,2,1,1\n1,2,0,1\n", "b.csv:4: has ring 1"},
               {"azimuth_deg,elevation_deg,time_us\n1,2,9\n1,2,3\n", "column 1 fires before column 0"},
               {"azimuth_deg,elevation_deg,time_us\n1,2,9\n1,2,200000\n", "lower rate_hz"}});
  EXPECT_THAT(refusal("beams: b.csv, columns: 9, rate_hz: 10, range_m: [0, 50]"), HasSubstr("columns has no effect"));
}

constexpr const char* kRosette =
    "columns: 10000, rate_hz: 10, range_m: [0, 90], rosette: {field_deg: 38.4, turns_hz: "
    "[121.57, -77.73]}";

// Two circles of a quarter of the field: the sum reaches its half where the prisms point the same way, and its middle
// where they point against each other.
TEST_F(BeamPatterns, ARosetteFillsItsField) {
  const auto beams = sensor(kRosette);
  double widest = 0;
  double narrowest = 1;
  for (std::size_t i = 0; i < beams->size(); ++i) {
    const double off = std::acos(std::min(beams->direction[i].x, 1.0));
    widest = std::max(widest, off);
    narrowest = std::min(narrowest, off);
    // Closed form: |a e^(i w t) + a e^(i v t)| = 2 a |cos((w - v) t / 2)|.
    const double t = beams->columnTime(static_cast<std::uint32_t>(i));
    EXPECT_NEAR(off, radians(19.2) * std::fabs(std::cos(kPi * (121.57 + 77.73) * t)), 1e-7);
  }
  EXPECT_NEAR(degrees(widest), 19.2, 0.01);
  EXPECT_LT(degrees(narrowest), 0.1);
}

// It goes on where the last revolution ended, so that it covers more of its field the longer it looks.
TEST_F(BeamPatterns, ARosetteDoesNotRepeat) {
  const auto table = sensor(kRosette);
  const auto cells = [&](int revolutions) {
    std::set<std::pair<int, int>> seen;
    for (int r = 0; r < revolutions; ++r) {
      const auto beams = beamsAt(table, 0.1 * r);
      for (const Vec3d& d : beams->direction) {
        seen.emplace(static_cast<int>(std::floor(d.y / 0.004)), static_cast<int>(std::floor(d.z / 0.004)));
      }
    }
    return seen.size();
  };
  EXPECT_GT(cells(4), 1.5 * static_cast<double>(cells(1)));
  const Vec3d last = table->direction.back();
  const Vec3d next = beamsAt(table, 0.1)->direction.front();
  const Vec3d second = table->direction[1];
  EXPECT_LT(length(next - last), 2 * length(second - table->direction[0])) << "no jump from one to the next";
  EXPECT_EQ(beamsAt(table, 7.3)->direction, beamsAt(table, 7.3)->direction);
  // After a day the phase is still exact to a thousandth of a degree.
  const double day = 86400;
  const double t = beamsAt(table, day)->columnTime(5);
  const double turn = std::fmod(121.57 * (day + t), 1.0) * 2 * kPi;
  const double other = std::fmod(-77.73 * (day + t), 1.0) * 2 * kPi;
  const double left = radians(9.6) * (std::cos(turn) + std::cos(other));
  const Vec3d d = beamsAt(table, day)->direction[5];
  EXPECT_NEAR(std::atan2(d.y, std::hypot(d.y, d.z)),
              std::atan2(left, std::hypot(left, radians(9.6) * (std::sin(turn) + std::sin(other)))), 2e-5);
  // What does not go on is itself.
  const auto flash = sensor(kFlash);
  EXPECT_EQ(beamsAt(flash, 3).get(), flash.get());
}

// One prism draws a circle; lasers above each other draw it at their heights, one after the other; all that the
// manifest stores gives the same beams again.
TEST_F(BeamPatterns, LasersOfARosetteAreRings) {
  const auto beams = sensor(
      "columns: 100, rate_hz: 10, range_m: [0, 9], firing_time_us: [0, 500], rosette: {deflection_deg: [5], turns_hz: "
      "[20], laser_elevation_deg: [0, 3]}");
  ASSERT_EQ(beams->rings, 2u);
  for (std::uint32_t column = 0; column < 100; ++column) {
    const Vec3d one = beams->direction[column];
    EXPECT_NEAR(degrees(std::acos(one.x)), 5, 1e-9);
    EXPECT_NEAR(beams->time[100 + column] - beams->time[column], 500e-6, 1e-8);
    const double turn = 2 * kPi * 20 * double{beams->columnTime(column) + 500e-6};
    const double left = radians(5) * std::cos(turn);
    const double up = radians(5) * std::sin(turn) + radians(3);
    EXPECT_NEAR(std::acos(beams->direction[100 + column].x), std::hypot(left, up), 1e-9);
  }
}

// A mirror of 45 deg turns an upward beam level; whatever it does, angles between beams of one firing stay the same.
TEST_F(BeamPatterns, AMirrorReflectsTheBeams) {
  const std::string rest = "columns: 360, rate_hz: 10, range_m: [0, 9], rosette: {turns_hz: [-37], deflection_deg: [";
  const auto level = sensor(rest + "0], mirror: {tilt_deg: 45, turns_hz: 10, phase_deg: 0}}");
  for (std::uint32_t c = 0; c < 360; ++c) {
    EXPECT_NEAR(level->direction[c].z, 0, 1e-12);
    EXPECT_NEAR(std::remainder(std::atan2(level->direction[c].y, level->direction[c].x) - radians(c), 2 * kPi), 0,
                1e-9);
  }
  const std::string lasers = "20], laser_azimuth_deg: [-4, 5]";
  const auto plain = sensor(rest + lasers + "}");
  const auto mirrored = sensor(rest + lasers + ", mirror: {tilt_deg: 60, turns_hz: 181, phase_deg: 11}}");
  for (std::uint32_t c = 0; c < 360; ++c) {
    EXPECT_NEAR(dot(plain->direction[c], plain->direction[360 + c]),
                dot(mirrored->direction[c], mirrored->direction[360 + c]), 1e-12);
    EXPECT_NEAR(length(mirrored->direction[c]), 1, 1e-12);
  }
}

TEST_F(BeamPatterns, ARasterScansZonesLineByLine) {
  const std::string zones = "zones_deg: [20, -20], width_deg: 30, top_deg: 6, bottom_deg: -6, lines: 4, line_us: 9000";
  const std::string rest = "columns: 12, rate_hz: 10, range_m: [0, 9], ";
  const auto beams = sensor(rest + "raster: {" + zones + ", alternate: true}");
  ASSERT_EQ(beams->rings, 2u);
  const double azimuths[] = {35, 20, 5, 5, 20, 35};
  for (std::uint32_t c = 0; c < 12; ++c) {
    const Vec3d& d = beams->direction[c];
    EXPECT_NEAR(degrees(std::atan2(d.y, d.x)), azimuths[c % 6], 1e-9);
    EXPECT_NEAR(degrees(std::asin(d.z)), 6 - 4.0 * (c / 3), 1e-9);
    EXPECT_NEAR(beams->columnTime(c), 0.025 * (c / 3) + 0.0045 * (c % 3), 1e-9);
  }
  EXPECT_THAT(refusal("columns: 13, rate_hz: 10, range_m: [0, 9], raster: {" + zones + "}"),
              HasSubstr("multiple of the 4 lines"));
  EXPECT_THAT(refusal(rest + "firing_time_us: [0, 1], raster: {" + zones + "}"),
              HasSubstr("firing_time_us has no effect"));
}

// Ten pulses a line, of which there are four in a frame.
TEST_F(BeamPatterns, LinesOfAnAircraftFollowTheirMirror) {
  const std::string rest = "columns: 40, rate_hz: 5, range_m: [1, 900], ";
  const auto nadir = [](const Vec3d& d) { return std::atan2(d.y, -d.z); };  // rad, from straight down to the left
  const auto turning = sensor(rest + "lines: {mirror: rotating, rate_hz: 20, field_deg: 90}");
  const auto swinging = sensor(rest + "lines: {mirror: oscillating, rate_hz: 20, field_deg: 60, line_us: 40000}");
  const auto nodding = sensor(rest + "lines: {mirror: palmer, rate_hz: 20, field_deg: 40}");
  for (std::uint32_t c = 0; c < 40; ++c) {
    const double inLine = c % 10 / 10.0;
    EXPECT_NEAR(degrees(nadir(turning->direction[c])), 45 - 90 * inLine, 1e-9) << c;
    EXPECT_NEAR(turning->time[c], 0.05 * (c / 10) + 0.0125 * inLine, 1e-7) << "a quarter of the turn";
    EXPECT_NEAR(degrees(nadir(swinging->direction[c])), 30 * std::cos(kPi * c / 10), 1e-9) << c;
    EXPECT_NEAR(swinging->time[c], 0.05 * (c / 10) + 0.04 * inLine, 1e-7);
    EXPECT_NEAR(degrees(std::acos(-nodding->direction[c].z)), 20, 1e-9) << c;
    EXPECT_NEAR(std::hypot(turning->direction[c].x, swinging->direction[c].x), 0, 1e-12);
  }
  EXPECT_GT(nodding->direction[0].y, 0.3) << "begins at the left";
  EXPECT_GT(nodding->direction[2].x, 0.3) << "passes the front";
  const auto refused = [&](const std::string& lines) { return refusal(rest + "lines: {" + lines + "}"); };
  expectRefusals(refused, {{"mirror: rotating, rate_hz: 22, field_deg: 90", "4.4 lines, but needs a whole number"},
                           {"mirror: oscillating, rate_hz: 15, field_deg: 90", "of pairs, there and back"},
                           {"mirror: palmer, rate_hz: 20, field_deg: 200", "field_deg"},
                           {"mirror: rotating, rate_hz: 20, field_deg: 90, line_us: 60000", "line_us"},
                           {"rate_hz: 20, field_deg: 90", "mirror"}});
  EXPECT_THAT(refusal(rest + "sectors: 2, lines: {mirror: palmer, rate_hz: 20, field_deg: 20}"),
              HasSubstr("sectors has no effect beside `lines`"));
}

// The beams of the sectors, one after another, are those of the turn.
TEST_F(BeamPatterns, SectorsFollowEachOther) {
  const std::string rest =
      "columns: 120, rate_hz: 0.01, range_m: [1, 300], elevation_deg: [40, 0, -60], origin_offset_m: 0.2, "
      "azimuth_offset_deg: [1, 0, -2], direction: clockwise, first_azimuth_deg: 30, firing_time_us: {step_us: 900}, "
      "turns_while_firing: true";
  const auto turn = sensor(rest);
  const auto sector = sensor(rest + ", sectors: 8");
  ASSERT_EQ(sector->columns, 15u);
  EXPECT_DOUBLE_EQ(sector->period, 12.5);
  for (std::uint32_t k = 0; k < 24; ++k) {  // three turns
    const auto beams = beamsAt(sector, k * 12.5);
    for (std::size_t i = 0; i < beams->size(); ++i) {
      const std::size_t beam = i / 15 * 120 + k % 8 * 15 + i % 15;
      ASSERT_LT(length(beams->direction[i] - turn->direction[beam]), 1e-12) << k << " " << i;
      ASSERT_LT(length(Vec3d(beams->origin[i]) - Vec3d(turn->origin[beam])), 1e-7);
      ASSERT_NEAR(k % 8 * 12.5 + double{beams->time[i]}, double{turn->time[beam]}, 1e-5);
    }
    EXPECT_NEAR(std::remainder(beams->azimuth(0) - turn->azimuth(k % 8 * 15), 2 * kPi), 0, 1e-12);
  }
  EXPECT_THAT(refusal(rest + ", sectors: 7"), HasSubstr("sectors must divide the 120 columns"));
  EXPECT_THAT(refusal(rest + ", sectors: 4, field_deg: 90"), HasSubstr("sectors divides a full circle"));
}

// The time of a sweep is that of its columns, whatever the rate of scans.
TEST_F(BeamPatterns, APartialFieldMayBeSweptInAStatedTime) {
  const std::string rest =
      "columns: 101, rate_hz: 10, range_m: [0, 9], elevation_deg: [0, -1], ring_order: unordered, "
      "firing_time_us: [0, 100], turns_while_firing: true, ";
  const auto beams = sensor(rest + "field_deg: 100, sweep_ms: 50");
  EXPECT_NEAR(beams->columnTime(100), 0.05, 1e-12);
  // 100 deg in 50 ms: the head turns by 0.2 deg until the second laser fires.
  EXPECT_NEAR(degrees(beams->azimuthOffset[1]), 0.2, 1e-9);
  EXPECT_THAT(refusal(rest + "sweep_ms: 50"), HasSubstr("full circle"));
  EXPECT_THAT(refusal(rest + "field_deg: 100, sweep_ms: 101"), HasSubstr("sweep_ms"));
}

TEST_F(BeamPatterns, ShotsOfARosetteAreThoseOfTheirTime) {
  const auto table = sensor(kRosette);
  const Trajectory stands = readTrajectory(parseYaml("{poses: [{}, {}, {}], every_s: 0.25}", "t.yaml"), "t", 0.1);
  for (std::uint32_t frame = 0; frame < 3; ++frame) {
    const Shot shot = makeShot(table, stands, frame, {}, {});
    EXPECT_EQ(shot.beams->direction, beamsAt(table, 0.25 * frame)->direction);
  }
  const auto refused = [&](const std::string& rosette) {
    return refusal("columns: 9, rate_hz: 10, range_m: [0, 9], rosette: {" + rosette + "}");
  };
  expectRefusals(refused,
                 {{"field_deg: 30, turns_hz: []", "must be one to four"},
                  {"field_deg: 30, deflection_deg: [15], turns_hz: [3]", "either field_deg or"},
                  {"deflection_deg: [15], turns_hz: [3, 4]", "must be 2 numbers"},
                  {"field_deg: 9, turns_hz: [3], laser_azimuth_deg: [1, 2], laser_elevation_deg: [1]", "2 angles"},
                  {"field_deg: 9, turns_hz: [3], mirror: {turns_hz: 3}", "tilt_deg"}});
  EXPECT_THAT(
      refusal("columns: 9, rate_hz: 10, range_m: [0, 9], elevation_deg: [1], rosette: {field_deg: 30, turns_hz: "
              "[3, 4]}"),
      HasSubstr("elevation_deg has no effect beside"));
}

}  // namespace
}  // namespace scanmill
