#include "sensors/sensor.h"

#include <fmt/format.h>

#include "config/fields.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

std::shared_ptr<const BeamTable> beamsOf(const std::string& text) {
  return makeBeams(parseYaml(text, "sensor.yaml"));
}

std::shared_ptr<const BeamTable> uniform(int rings, int columns, const std::string& more = "") {
  return beamsOf(
      fmt::format("{{columns: {}, rate_hz: 10, range_m: [0.5, 100], elevation_deg: {{top: 15, bottom: -25, "
                  "rings: {}}}{}{}}}",
                  columns, rings, more.empty() ? "" : ", ", more));
}

double azimuthOf(const Vec3d& direction) {
  return degrees(std::atan2(direction.y, direction.x));
}

double elevationOf(const Vec3d& direction) {
  return degrees(std::asin(direction.z));
}

TEST(Beams, DirectionsAreUnitForEveryShape) {
  for (const auto& [rings, columns] : {std::pair{1, 1}, {1, 2048}, {4096, 1}, {7, 13}, {128, 1024}}) {
    const auto beams = uniform(rings, columns, "azimuth_offset_deg: [33.3]");
    ASSERT_EQ(beams->direction.size(), static_cast<std::size_t>(rings) * columns);
    ASSERT_EQ(beams->time.size(), beams->size());
    for (const Vec3d& d : beams->direction) ASSERT_NEAR(length(d), 1, 1e-14);
  }
}

TEST(Beams, UniformElevationsEndExactlyAtTopAndBottom) {
  for (const int rings : {5, 4096}) {
    const auto beams = uniform(rings, 4);
    for (int beam = 0; beam < 4 * rings; ++beam) {
      EXPECT_NEAR(elevationOf(beams->direction[beam]), 15 - 40.0 / (rings - 1) * (beam / 4), 1e-12);
    }
  }
}

TEST(Beams, OneRingIsTheMiddleAndOneColumnTheFirstAzimuth) {
  const auto beams = uniform(1, 1, "first_azimuth_deg: 90");
  EXPECT_NEAR(elevationOf(beams->direction[0]), -5, 1e-12);
  EXPECT_NEAR(azimuthOf(beams->direction[0]), 90, 1e-12);
  EXPECT_EQ(beams->time[0], 0);
  EXPECT_TRUE(beams->origin.empty());
}

TEST(Beams, FullTurnHasNoSeamAndIsMirrorSymmetric) {
  for (const int columns : {1, 2, 3, 360, 1023, 2048}) {
    const auto beams = uniform(1, columns);
    std::vector<double> azimuths;
    for (const Vec3d& d : beams->direction) azimuths.push_back(std::fmod(azimuthOf(d) + 360 + 1e-9, 360.0));
    std::sort(azimuths.begin(), azimuths.end());
    for (int c = 0; c < columns; ++c) EXPECT_NEAR(azimuths[c], 360.0 * c / columns, 2e-9) << columns;
    for (int c = 1; c < columns; ++c) {
      const Vec3d& left = beams->direction[c];
      const Vec3d& right = beams->direction[columns - c];
      EXPECT_NEAR(left.x, right.x, 1e-14);
      EXPECT_NEAR(left.y, -right.y, 1e-14);
    }
  }
}

TEST(Beams, DirectionOfRotationMirrorsTheTurn) {
  const auto left = uniform(3, 100, "direction: counterclockwise, first_azimuth_deg: 30");
  const auto right = uniform(3, 100, "direction: clockwise, first_azimuth_deg: -30");
  EXPECT_FALSE(left->clockwise);
  EXPECT_TRUE(right->clockwise);
  EXPECT_NEAR(azimuthOf(left->direction[0]), 30, 1e-12);
  EXPECT_NEAR(azimuthOf(left->direction[1]), 33.6, 1e-12);
  EXPECT_NEAR(azimuthOf(right->direction[1]), -33.6, 1e-12);
  for (std::size_t beam = 0; beam < left->size(); ++beam) {
    EXPECT_NEAR(left->direction[beam].x, right->direction[beam].x, 1e-14);
    EXPECT_NEAR(left->direction[beam].y, -right->direction[beam].y, 1e-14);
    EXPECT_EQ(left->time[beam], right->time[beam]);
  }
}

TEST(Beams, PartialFieldHitsBothEdgesInItsShareOfTheTurn) {
  const auto beams = uniform(1, 61, "first_azimuth_deg: -60, field_deg: 120");
  EXPECT_NEAR(azimuthOf(beams->direction.front()), -60, 1e-12);
  EXPECT_NEAR(azimuthOf(beams->direction[30]), 0, 1e-12);
  EXPECT_NEAR(azimuthOf(beams->direction.back()), 60, 1e-12);
  EXPECT_NEAR(beams->columnTime(60), 0.1 / 3, 1e-15);
  EXPECT_NEAR(azimuthOf(uniform(1, 1, "first_azimuth_deg: -60, field_deg: 120")->direction[0]), 0, 1e-12);
}

TEST(Beams, TimesIncreaseByColumnAndStayWithinTheTurn) {
  const auto beams = uniform(16, 1000, "firing_time_us: {step_us: 6}");
  for (std::uint32_t ring = 0; ring < 16; ++ring) {
    for (std::uint32_t column = 0; column < 1000; ++column) {
      const float time = beams->time[ring * 1000 + column];
      ASSERT_NEAR(time, column * 1e-4 + ring * 6e-6, 1e-8);
      const float before = column > 0 ? beams->time[15 * 1000 + column - 1] : -1.0f;
      ASSERT_GT(time, before);
    }
  }
  EXPECT_LT(beams->time.back(), 0.1f);
  EXPECT_DOUBLE_EQ(beams->period, 0.1);
}

TEST(Beams, RingOrderTurnsTheTableUpsideDown) {
  const auto down = uniform(9, 4, "ring_order: top_down");
  const auto up = uniform(9, 4, "ring_order: bottom_up");
  EXPECT_TRUE(down->topDown);
  EXPECT_FALSE(up->topDown);
  for (int ring = 0; ring < 9; ++ring) EXPECT_NEAR(down->elevation[ring], up->elevation[8 - ring], 1e-15);
  const auto mixed =
      beamsOf("{columns: 4, rate_hz: 10, range_m: [0, 9], elevation_deg: [1, -3, 2], ring_order: unordered}");
  EXPECT_FALSE(mixed->topDown);
  EXPECT_NEAR(elevationOf(mixed->direction[8]), 2, 1e-12);
}

TEST(Beams, AzimuthOffsetsRepeatOverTheRings) {
  const auto beams = uniform(8, 36, "azimuth_offset_deg: [4, 1, -1, -4], first_azimuth_deg: 90, direction: clockwise");
  const std::vector<double> pattern = {4, 1, -1, -4};
  for (int ring = 0; ring < 8; ++ring) {
    EXPECT_NEAR(azimuthOf(beams->direction[ring * 36 + 3]), 60 + pattern[ring % 4], 1e-12);
  }
}

TEST(Beams, OriginsFollowTheHeadNotTheRingsOffset) {
  const auto beams = uniform(2, 8, "azimuth_offset_deg: [10, -10], origin_offset_m: 0.25, origin_height_m: 0.5");
  ASSERT_EQ(beams->origin.size(), beams->size());
  for (int ring = 0; ring < 2; ++ring) {
    for (int column = 0; column < 8; ++column) {
      const Vec3f o = beams->origin[ring * 8 + column];
      EXPECT_NEAR(o.x, 0.25 * std::cos(radians(45 * column)), 1e-7);
      EXPECT_NEAR(o.y, 0.25 * std::sin(radians(45 * column)), 1e-7);
      EXPECT_FLOAT_EQ(o.z, 0.5f);
    }
  }
}

// Square to the beam: its own offsets move it sideways, so that the origin stays where the beam passes nearest to.
TEST(Beams, OwnOriginsLieSquareToTheBeam) {
  const auto beams = uniform(2, 8, "azimuth_offset_deg: [10, -10], origin_left_m: [0.02, -0.03], origin_up_m: 0.2");
  ASSERT_EQ(beams->origin.size(), beams->size());
  for (std::size_t beam = 0; beam < beams->size(); ++beam) {
    const Vec3d origin(beams->origin[beam]);
    const Vec3d direction = beams->direction[beam];
    const Vec3d left = normalized(Vec3d{-direction.y, direction.x, 0});
    EXPECT_NEAR(dot(origin, direction), 0, 1e-8);
    EXPECT_NEAR(dot(origin, left), beam < 8 ? 0.02 : -0.03, 1e-8);
    EXPECT_NEAR(dot(origin, cross(direction, left)), 0.2, 1e-7);
  }
  EXPECT_TRUE(uniform(2, 8, "origin_left_m: [0, 0], origin_up_m: 0")->origin.empty());
}

TEST(Beams, CompactDescriptionMakesTheSameTables) {
  const auto beams = uniform(6, 50,
                             "field_deg: 200, origin_offset_m: 0.1, firing_time_us: {step_us: 3}, origin_up_m: 0.1, "
                             "origin_left_m: [0.1, 0.2, 0, 0, -0.1, 0]");
  BeamTable copy = *beams;
  copy.direction.clear();
  copy.origin.clear();
  copy.time.clear();
  fillBeams(copy);
  EXPECT_EQ(copy.direction, beams->direction);
  EXPECT_EQ(copy.origin, beams->origin);
  EXPECT_EQ(copy.time, beams->time);
}

TEST(SensorSize, CountsWithoutMakingTheTable) {
  const SensorSize largest =
      sensorSize(parseYaml("{columns: 65536, elevation_deg: {top: 1, bottom: 0, rings: 4096}}", "s.yaml"));
  EXPECT_EQ(largest.rings, 4096u);
  EXPECT_EQ(largest.columns, 65536u);
  EXPECT_EQ(sensorSize(parseYaml("{columns: 1, elevation_deg: [1, 2, 3]}", "s.yaml")).rings, 3u);
}

TEST(ResolveSensor, OwnKeysReplaceThePresets) {
  const TemporaryFolder folder;
  folder.write("sensors/base.yaml",
               "model: base\ncolumns: 10\nrate_hz: 10\nrange_m: [1, 50]\nelevation_deg: [1, 0, -1]\n");
  const auto pipeline = folder.write("pipeline.yaml",
                                     "name: roof\npreset: sensors/base.yaml\nmount: {position: [0, 0, 2]}\n"
                                     "columns: 20\nfirst_azimuth_deg: 45\n");
  const Value own = readYaml(pipeline);
  const Value merged = resolveSensor(own);
  for (const char* key : {"name", "preset", "mount"}) EXPECT_EQ(merged.find(key), nullptr);
  const auto beams = makeBeams(merged);
  EXPECT_EQ(beams->columns, 20u);
  EXPECT_EQ(beams->model, "base");
  EXPECT_NEAR(beams->firstAzimuth, kPi / 4, 1e-15);
  EXPECT_THAT(merged.find("columns")->where.file, HasSubstr("pipeline.yaml"));
  EXPECT_EQ(merged.find("columns")->where.line, 4);
  EXPECT_THAT(merged.find("rate_hz")->where.file, HasSubstr("base.yaml"));
  EXPECT_EQ(merged.find("rate_hz")->where.line, 3);
}

std::string refusedSensor(const std::string& yaml) {
  return messageOf([&] { makeBeams(resolveSensor(parseYaml(yaml, "sensor.yaml"))); });
}

TEST(ResolveSensor, AnEmptyKeyCountsAsNone) {
  const std::string cones = "columns: 100\nrate_hz: 10\nrange_m: [1, 100]\nelevation_deg: [1, 0]\n";
  const std::string rosette = "columns: 100\nrate_hz: 10\nrange_m: [1, 9]\nrosette: {field_deg: 38, turns_hz: [9]}\n";
  const std::string raster =
      "columns: 100\nrate_hz: 10\nrange_m: [1, 9]\n"
      "raster: {zones_deg: [0], width_deg: 9, top_deg: 9, bottom_deg: 0, lines: 5}\n";
  for (const std::string& kind : {cones, rosette, raster}) {
    for (const std::string key : {"name",
                                  "preset",
                                  "mount",
                                  "model",
                                  "source",
                                  "direction",
                                  "first_azimuth_deg",
                                  "field_deg",
                                  "calibration",
                                  "pattern",
                                  "rosette",
                                  "raster",
                                  "sweep_ms",
                                  "beams",
                                  "elevation_deg",
                                  "ring_order",
                                  "firing_time_us",
                                  "azimuth_offset_deg",
                                  "origin_offset_m",
                                  "origin_height_m",
                                  "origin_left_m",
                                  "origin_up_m",
                                  "exit_width_mm",
                                  "turns_while_firing",
                                  "divergence_mrad",
                                  "beam_shape",
                                  "pulse_ns",
                                  "effects"}) {
      if (kind.find(key + ":") != std::string::npos) continue;
      EXPECT_EQ(refusedSensor(kind + key + ":\n"), "accepted") << kind;
    }
  }
}

TEST(ResolveSensor, MisspeltKeysAreToldBeforeOthersAreMissed) {
  expectRefusals(refusedSensor, {{"mout: {}", "did you mean 'mount'"},
                                 {"nmae: roof", "did you mean 'name'"},
                                 {"presett: vlp_16", "sensor.yaml:1:1: sensor: unknown key 'presett' (did you mean"},
                                 {"calibraton: unit.yaml", "did you mean 'calibration'"},
                                 {"rosete: {}", "did you mean 'rosette'"},
                                 {"rastr: {}", "did you mean 'raster'"},
                                 {"beems: b.csv", "did you mean 'beams'"},
                                 {"{columns: 9, raster: {zones_deg: [0], width_deg: 9, top_deg: 9, bottom_deg: 0, "
                                  "line_us: 9}}",
                                  "the key 'lines' is missing"}});
}

TEST(ResolveSensor, MissingPresetIsNamed) {
  const Value own = parseYaml("{name: a, preset: sensors/no_such.yaml}", "/nowhere/p.yaml");
  expectInputError([&] { return resolveSensor(own); }, {"no_such.yaml"});
}

struct BadSensor {
  std::string change;   // a line that replaces or is added to a good sensor
  std::string message;  // part of what is said
};

class MalformedSensor : public testing::TestWithParam<BadSensor> {};

TEST_P(MalformedSensor, IsRefusedWithItsPlace) {
  const BadSensor& bad = GetParam();
  const std::string key = bad.change.substr(0, bad.change.find(':'));
  std::string text = "# a comment\n";
  for (const std::string line : {"columns: 100", "rate_hz: 10", "elevation_deg: [3, 2, 1, 0]", "range_m: [1, 100]"}) {
    if (line.substr(0, line.find(':')) != key) text += line + "\n";
  }
  try {
    makeBeams(parseYaml(text + bad.change + "\n", "bad.yaml"));
    FAIL() << text << bad.change;
  } catch (const InputError& e) {
    const std::string message = e.what();
    EXPECT_THAT(message, testing::StartsWith("bad.yaml:"));
    EXPECT_THAT(message, HasSubstr(bad.message));
    if (bad.change != "") {
      const auto lines = std::count(text.begin(), text.end(), '\n') + 1;
      EXPECT_THAT(message, testing::StartsWith(fmt::format("bad.yaml:{}:", lines)));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Sensors, MalformedSensor,
    testing::Values(BadSensor{"colums: 3", "columns"}, BadSensor{"columns: 0", "rings x columns = 4 x 0 = 0"},
                    BadSensor{"columns: -5", "rings x columns"}, BadSensor{"columns: 2.5", "whole number"},
                    BadSensor{"columns: 65537", "rings x columns = 4 x 65537 = 262148"},
                    BadSensor{"columns: 1e12", "rings x columns = 4 x 1000000000000 = 4000000000000"},
                    BadSensor{"rate_hz: 0", "rate_hz"}, BadSensor{"direction: left", "direction"},
                    BadSensor{"first_azimuth_deg: 361", "first_azimuth_deg"}, BadSensor{"field_deg: 0", "field_deg"},
                    BadSensor{"elevation_deg: 5", "elevation_deg"},
                    BadSensor{"elevation_deg: []", "rings x columns = 0 x 100"},
                    BadSensor{"elevation_deg: [91]", "elevation_deg"}, BadSensor{"elevation_deg: [1, 2, 3]", "above"},
                    BadSensor{"elevation_deg: {top: 1, bottom: 2, rings: 4}", "above bottom"},
                    BadSensor{"elevation_deg: {top: 1, bottom: -1}", "rings"},
                    BadSensor{"elevation_deg: {top: 1, bottom: -1, rings: 0}", "rings x columns = 0 x 100"},
                    BadSensor{"elevation_deg: {top: 1, bottom: -1, rings: 8193}",
                              "rings x columns = 8193 x 100 = 819300"},
                    BadSensor{"elevation_deg: {top: 1, bottom: -1, rings: 2, step: 3}", "step"},
                    BadSensor{"azimuth_offset_deg: []", "azimuth_offset_deg"},
                    BadSensor{"azimuth_offset_deg: [1, 2, 3]", "divides the number of rings"},
                    BadSensor{"azimuth_offset_deg: [1, 2, 3, 4, 5, 6, 7, 8]", "has 8 entries"},
                    BadSensor{"origin_offset_m: -1", "origin_offset_m"},
                    BadSensor{"origin_left_m: [1, 2, 3, 4, 5, 6, 7]", "origin_left_m has 7 entries"},
                    BadSensor{"firing_time_us: [0, 1, 2]", "has 3 entries for 4 rings"},
                    BadSensor{"firing_time_us: {step_us: 400}", "a column lasts 1000 us"},
                    BadSensor{"firing_time_us: {step: 1}", "step_us"}, BadSensor{"range_m: [5, 5]", "range_m"},
                    BadSensor{"range_m: [1, 2, 3]", "range_m"}, BadSensor{"range_m: 100", "range_m"}));

TEST(MalformedSensorFile, MissingKeysAndContradictionsAreRefused) {
  const auto refusal = [](const std::string& text) { return messageOf([&] { beamsOf(text); }); };
  EXPECT_THAT(refusal(""), HasSubstr("columns"));
  EXPECT_THAT(refusal("[1, 2]"), HasSubstr("sensor.yaml"));
  EXPECT_THAT(refusal("{columns: 4}"), HasSubstr("elevation_deg"));
  EXPECT_THAT(refusal("{columns: 4, elevation_deg: [0]}"), HasSubstr("rate_hz"));
  EXPECT_THAT(refusal("{columns: 4, elevation_deg: [0], rate_hz: 9}"), HasSubstr("range_m"));
  const std::string rest = "columns: 4\nrate_hz: 9\nrange_m: [0, 1]\n";
  EXPECT_THAT(refusal(rest + "ring_order: bottom_up\nelevation_deg: [3, 2]"), HasSubstr("sensor.yaml:5:20: "));
  EXPECT_THAT(refusal(rest + "ring_order: unordered\nelevation_deg: {top: 1, bottom: 0, rings: 2}"),
              HasSubstr("sensor.yaml:4:"));
}

}  // namespace
}  // namespace scanmill
