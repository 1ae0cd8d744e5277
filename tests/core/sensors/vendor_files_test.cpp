// What vendors say of their sensors' beams: Ouster's metadata, Hesai's correction files, tables.

#include <fmt/format.h>

#include <map>

#include "base/file.h"
#include "config/fields.h"
#include "sensors/calibration.h"
#include "sensors/sensor.h"
#include "tests/support/message_of.h"
#include "tests/support/shared_data.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class VendorFiles : public testing::Test {
 protected:
  std::shared_ptr<const BeamTable> sensor(const std::string& yaml) const {
    return makeBeams(resolveSensor(parseYaml("{" + yaml + "}", (folder_.path() / "s.yaml").string())));
  }
  std::string refusal(const std::string& yaml) const {
    return messageOf([&] { sensor(yaml); });
  }
  std::string refusedJson(const std::string& json) const {
    folder_.write("m.json", json);
    return refusal("calibration: m.json, range_m: [1, 100]");
  }

  TemporaryFolder folder_;
};

constexpr const char* kOld =
    R"({"prod_line": "OS-1-3", "lidar_mode": "512x20", "beam_altitude_angles": [10, 0, -11], "beam_azimuth_angles": [3, 0, -3],
        "lidar_origin_to_beam_origin_mm": 15.5, "lidar_to_sensor_transform": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 40, 0, 0, 0, 1]})";
constexpr const char* kNew =
    R"({"sensor_info": {"prod_line": "OS-1-3"}, "config_params": {"lidar_mode": "512x20"},
        "beam_intrinsics": {"beam_altitude_angles": [10, 0, -11], "beam_azimuth_angles": [3, 0, -3],
                            "lidar_origin_to_beam_origin_mm": 15.5},
        "lidar_intrinsics": {"lidar_to_sensor_transform": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 40, 0, 0, 0, 1]}})";

TEST_F(VendorFiles, OustersMetadataMakesASensorByItself) {
  for (const char* json : {kOld, kNew}) {
    folder_.write("m.json", json);
    const auto beams = sensor("calibration: m.json, range_m: [1, 100]");
    EXPECT_EQ(beams->model, "OS-1-3");
    EXPECT_EQ(beams->rings, 3u);
    EXPECT_EQ(beams->columns, 512u);
    EXPECT_DOUBLE_EQ(beams->period, 0.05);
    EXPECT_TRUE(beams->clockwise);
    EXPECT_TRUE(beams->topDown);
    EXPECT_NEAR(degrees(beams->elevation[2]), -11, 1e-12);
    EXPECT_NEAR(degrees(beams->azimuthOffset[0]), -3, 1e-12) << "Ouster counts clockwise";
    EXPECT_NEAR(degrees(beams->firstAzimuth), -90, 1e-9);
    EXPECT_NEAR(beams->originOffset, 0.0155, 1e-12);
    EXPECT_NEAR(beams->originHeight, 0.04, 1e-12);
    EXPECT_THAT(beams->source, HasSubstr("calibration m.json (SHA-256"));
  }
}

TEST_F(VendorFiles, ASensorMaySayOtherwiseThanItsMetadata) {
  folder_.write("m.json", kOld);
  const auto beams = sensor("calibration: m.json, columns: 1024, rate_hz: 10, model: mine, range_m: [1, 100]");
  EXPECT_EQ(beams->columns, 1024u);
  EXPECT_DOUBLE_EQ(beams->period, 0.1);
  EXPECT_EQ(beams->model, "mine");
  EXPECT_THAT(refusal("calibration: m.json, elevation_deg: [1, 2, 3], range_m: [1, 100]"),
              HasSubstr("leave one of them out"));
}

// Columns 500 to 11 of 512: 24 in all, the first 12 steps before column 0.
TEST_F(VendorFiles, AWindowOfColumnsIsAPartOfTheRevolution) {
  std::string json = kOld;
  json.insert(1, R"("data_format": {"column_window": [500, 11]}, )");
  folder_.write("m.json", json);
  const auto window = sensor("calibration: m.json, range_m: [1, 100]");
  json.replace(json.find("[500, 11]"), 9, "[0, 511]");
  folder_.write("m.json", json);
  const auto whole = sensor("calibration: m.json, range_m: [1, 100]");
  ASSERT_EQ(window->columns, 24u);
  for (std::uint32_t c = 0; c < 24; ++c) {
    const std::uint32_t other = (500 + c) % 512;
    for (std::uint32_t ring = 0; ring < 3; ++ring) {
      EXPECT_LT(length(window->direction[ring * 24 + c] - whole->direction[ring * 512 + other]), 1e-12) << c;
    }
    EXPECT_NEAR(window->columnTime(c), whole->columnTime(c), 1e-12) << c;
  }
  // With columns of one's own it is the whole turn again, from where that begins.
  json.replace(json.find("[0, 511]"), 8, "[128, 255]");
  folder_.write("m.json", json);
  const auto own = sensor("calibration: m.json, range_m: [1, 100], columns: 1024");
  EXPECT_TRUE(own->fullTurn());
  EXPECT_LT(length(own->direction[0] - whole->direction[0]), 1e-12);
  json.replace(json.find("[128, 255]"), 10, "[128, 128]");
  EXPECT_THAT(refusedJson(json), HasSubstr("one column"));
}

// Early firmware: no mode, so that the columns and the rate come from the packets' format, or from the pipeline.
TEST_F(VendorFiles, MetadataWithoutAModeNeedTheSensorsColumnsAndRate) {
  const std::string mode = R"("lidar_mode": "512x20")";
  std::string json = kOld;
  json.replace(json.find(mode), mode.size(), R"("lidar_mode": "")");
  EXPECT_THAT(refusedJson(json), AllOf(HasSubstr("m.json"), HasSubstr("give `columns` and `rate_hz`")));
  EXPECT_THAT(refusal("calibration: m.json, range_m: [1, 100], columns: 100"),
              HasSubstr("give `columns` and `rate_hz`"));
  const auto own = sensor("calibration: m.json, range_m: [1, 100], columns: 100, rate_hz: 5");
  EXPECT_EQ(own->columns, 100u);
  EXPECT_NEAR(own->originHeight, 0.04, 1e-12);
  folder_.write("p.yaml", "columns: 90\nrate_hz: 2\nelevation_deg: [3, 2, 1]\nrange_m: [1, 100]\n");
  EXPECT_EQ(sensor("preset: p.yaml, calibration: m.json")->columns, 90u);
  json.insert(1, R"("data_format": {"columns_per_frame": 2048, "fps": 10}, )");
  folder_.write("m.json", json);
  const auto packets = sensor("calibration: m.json, range_m: [1, 100]");
  EXPECT_EQ(packets->columns, 2048u);
  EXPECT_DOUBLE_EQ(packets->period, 0.1);
  json = kOld;
  json.insert(1, R"("data_format": {"columns_per_frame": 1024}, )");
  EXPECT_THAT(refusedJson(json), HasSubstr("has columns_per_frame 1024 and the lidar_mode '512x20'"));
  json = kOld;
  json.insert(1, R"("data_format": {"pixels_per_column": 64}, )");
  EXPECT_THAT(refusedJson(json), HasSubstr("has angles of 3 beams, 0 of which are unused, but its pixels_per_column"));
  json = kOld;
  json.insert(1, R"("data_format": {"fps": 10}, )");
  EXPECT_THAT(refusedJson(json), HasSubstr("has fps 10 and the lidar_mode '512x20'"));
}

// The lists of sensors with few lasers are filled up with zeros, as are their packets.
TEST_F(VendorFiles, PixelsPerColumnMayCountUnusedBeams) {
  folder_.write("m.json", R"({"lidar_mode": "512x20", "beam_altitude_angles": [10, 0, -11, 0, 0],
                    "beam_azimuth_angles": [3, 1, -3, 0, 0], "data_format": {"pixels_per_column": 5}})");
  EXPECT_EQ(sensor("calibration: m.json, range_m: [1, 100]")->rings, 3u);
}

// The beams of an OSDome start above the lidar's origin: lidar_origin_to_beam_origin_mm is then the hypotenuse.
TEST_F(VendorFiles, TransformsOfMetadataAreReadOrRefused) {
  const auto with = [](const std::string& key, const std::string& numbers) {
    std::string json = kOld;
    json.erase(json.find(", \"lidar_to_sensor_transform\""));
    return json + ", \"" + key + "\": [" + numbers + "]}";
  };
  folder_.write("m.json", with("beam_to_lidar_transform", "1, 0, 0, 9, 0, 1, 0, 0, 0, 0, 1, 7, 0, 0, 0, 1"));
  const auto dome = sensor("calibration: m.json, range_m: [1, 100]");
  EXPECT_NEAR(dome->originOffset, 0.009, 1e-12);
  EXPECT_NEAR(dome->originHeight, 0.03618 + 0.007, 1e-12);
  const char* const kShifted = "1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 36, 0, 0, 0, 1";
  const char* const kTilted = "1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 36, 0, 0, 0, 1";
  const char* const kMirrored = "1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 36, 0, 0, 0, 1";
  for (const char* numbers : {kShifted, kTilted, kMirrored}) {
    EXPECT_THAT(refusedJson(with("lidar_to_sensor_transform", numbers)), HasSubstr("tilts, mirrors or shifts"));
  }
  EXPECT_THAT(refusedJson(with("beam_to_lidar_transform", "-1, 0, 0, 9, 0, -1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1")),
              HasSubstr("beam_to_lidar_transform tilts"));
  std::string json = kOld;
  json.insert(1, R"("config_params": {"azimuth_window": [0, 90000], "lidar_frame_azimuth_offset": 5},
                    "ouster-sdk": {"extrinsic": [1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}, )");
  EXPECT_THAT(printedBy([&] { EXPECT_EQ(refusedJson(json), "accepted"); }),
              AllOf(HasSubstr("m.json: left out: "), HasSubstr("1 azimuth windows"), HasSubstr("which `mount` gives"),
                    HasSubstr("1 azimuths at which frames begin")));
  json = kOld;
  json.insert(1, R"("config_params": {"azimuth_window": [0, 90000]}, "data_format": {"column_window": [0, 511]}, )");
  EXPECT_THAT(printedBy([&] { refusedJson(json); }), HasSubstr("1 azimuth windows")) << "beside all columns";
}

TEST_F(VendorFiles, MetadataThatIsNoneIsRefused) {
  const auto with = [](const std::string& altitude, const std::string& azimuth, const std::string& more = "") {
    return fmt::format(R"({{"beam_altitude_angles": {}, "beam_azimuth_angles": {}{}}})", altitude, azimuth, more);
  };
  const auto mode = [&](const std::string& more) { return with("[1]", "[1]", ", \"lidar_mode\": " + more); };
  expectRefusals([&](const std::string& json) { return refusedJson(json); },
                 {{"{", "m.json:"},
                  {"[]", "a map"},
                  {"{}", "no beam_altitude_angles"},
                  {with("[1, 2]", "[1]"), "2 beam_altitude_angles and 1"},
                  {with("[1, \"x\"]", "[1, 2]"), "beam_altitude_angles[1] must be a number"},
                  {with("[[1], [2]]", "[[1], [2]]"), "only metadata of spinning sensors"},
                  {with("[100]", "[1]"), "altitude 100"},
                  {with("[1]", "[1]"), "has no lidar_mode"},
                  {mode("\"fast\""), "'fast'"},
                  {mode("\"0x10\""), "columns x revolutions"},
                  {mode(R"("512x10", "data_format": {"column_window": [0, 600]})"), "column_window"},
                  {mode(R"("512x10", "lidar_to_sensor_transform": [1, 2])"), "16 numbers"}});
}

// Every real file, whatever its firmware: as many rings as its name says, steps as the angles have them.
TEST_F(VendorFiles, AllOfOustersRealFilesAreRead) {
  SKIP_WITHOUT_SHARED_DATA("sensors/ouster");
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(sharedData() / "sensors/ouster")) {
    if (entry.path().extension() != ".json") continue;
    SCOPED_TRACE(entry.path().string());
    const auto beams = sensor("calibration: " + entry.path().string() + ", range_m: [0.5, 120]");
    ++count;
    const std::string& model = beams->model;
    const std::size_t digits = model.find_first_of("0123456789", 5);
    if (model.starts_with("OS-") && model != "OS-1-16-A0") {
      EXPECT_EQ(beams->rings, std::stoul(model.substr(digits)));
    }
    EXPECT_TRUE(beams->topDown);
    EXPECT_NEAR(std::fabs(degrees(beams->firstAzimuth)), 180, model.empty() || beams->columns < 512 ? 180 : 1e-9);
    // The field of view of the family, by its data sheets: 90, 45 and 22.5 degrees; 33 of the first OS1.
    const double field = degrees(*std::max_element(beams->elevation.begin(), beams->elevation.end()) -
                                 *std::min_element(beams->elevation.begin(), beams->elevation.end()));
    if (model.starts_with("OS-0")) {
      EXPECT_NEAR(field, 90, 3);
    }
    if (model.starts_with("OS-1")) {
      EXPECT_TRUE(field > 27 && field < 46) << field;
    }
    if (model.starts_with("OS-2")) {
      EXPECT_NEAR(field, 22.5, 2.5);
    }
  }
  EXPECT_EQ(count, 38);
}

TEST_F(VendorFiles, HesaisAnglesAreClockwiseAndByChannel) {
  folder_.write("h.csv",
                "\xEF\xBB\xBF"
                "Laser id,Elevation,Azimuth\r\n2,-1.5,-2\r\n1,3,1.25\r\n3,-7,350\r\n\r\n");
  const auto beams = sensor("calibration: h.csv, columns: 100, rate_hz: 10, range_m: [1, 100]");
  ASSERT_EQ(beams->rings, 3u);
  const double elevations[] = {3, -1.5, -7};
  const double azimuths[] = {-1.25, 2, 10};
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(degrees(beams->elevation[i]), elevations[i], 1e-12);
    EXPECT_NEAR(degrees(beams->azimuthOffset[i]), azimuths[i], 1e-9);
  }
}

TEST_F(VendorFiles, TablesOfOnesOwnNameTheirColumns) {
  folder_.write(
      "t.csv",
      "elevation_deg;azimuth_offset_deg;origin_left_m;origin_up_m;firing_time_us\n-3;1;0.1;0.2;0\n4;-2;0;0.3;9\n");
  const auto beams = sensor("calibration: t.csv, columns: 100, rate_hz: 10, range_m: [1, 100]");
  EXPECT_FALSE(beams->topDown);
  EXPECT_NEAR(degrees(beams->azimuthOffset[1]), -2, 1e-12);
  EXPECT_THAT(beams->originLeft, ElementsAre(0.1, 0));
  EXPECT_THAT(beams->originUp, ElementsAre(0.2, 0.3));
  EXPECT_NEAR(beams->firingOffset[1], 9e-6, 1e-12);
}

// The firing times of a preset are those of its rings, whichever way a calibration sorts its lasers.
TEST_F(VendorFiles, CalibrationsBesideAPresetKeepTheOrderOfItsRings) {
  folder_.write("p.yaml",
                "model: two\nsource: here\ncolumns: 100\nrate_hz: 10\nring_order: bottom_up\nelevation_deg: [-5, 5]\n"
                "firing_time_us: [0, 7]\nrange_m: [1, 100]\n");
  folder_.write("unit.yaml",
                "lasers:\n- {laser_id: 0, vert_correction: 0.09, rot_correction: 0}\n"
                "- {laser_id: 1, vert_correction: -0.08, rot_correction: 0.01}\n");
  const auto beams = sensor("preset: p.yaml, calibration: unit.yaml");
  EXPECT_FALSE(beams->topDown);
  EXPECT_NEAR(beams->elevation[0], -0.08, 1e-12);
  EXPECT_NEAR(beams->azimuthOffset[0], 0.01, 1e-12);
  EXPECT_NEAR(beams->firingOffset[1], 7e-6, 1e-12);
}

TEST_F(VendorFiles, FiringTimesComeFromATable) {
  folder_.write("h.csv", "Channel,Elevation,Azimuth\n1,3,0\n2,1,0\n3,-1,0\n");
  folder_.write("f.csv", "Channel,fire time(\xCE\xBCs)\n3,-3.62\n1,2\n2,-1\n");
  const auto beams =
      sensor("calibration: h.csv, columns: 100, rate_hz: 10, range_m: [1, 100], firing_time_us: {file: f.csv}");
  const double times[] = {5.62e-6, 2.62e-6, 0};
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(beams->firingOffset[i], times[i], 1e-12);
  folder_.write("n.csv", "Channel,Even_fire time(ns),Odd_fire time(ns)\n1,4960,4960\n2,5480,5480\n");
  EXPECT_THAT(readFiringTable(folder_.path() / "n.csv"), ElementsAre(0, testing::DoubleNear(0.52, 1e-9)));
  folder_.write("n.csv", "Channel,Even_fire time(ns),Odd_fire time(ns)\n1,4960,4960\n2,5480,5500\n");
  EXPECT_THAT(messageOf([&] { readFiringTable(folder_.path() / "n.csv"); }), HasSubstr("two firing states"));
  folder_.write("f.csv", "Channel,fire time(us)\n1,0\n2,0\n");
  EXPECT_THAT(
      refusal("calibration: h.csv, columns: 100, rate_hz: 10, range_m: [1, 100], firing_time_us: {file: f.csv}"),
      AllOf(HasSubstr("f.csv"), HasSubstr("2 lasers for 3 rings")));
}

// A decimal comma, a column too many or a name that is nearly right would give other beams without a word.
TEST_F(VendorFiles, TablesThatAreNoneAreRefusedWithTheirLine) {
  const auto refuse = [&](const std::string& table) {
    folder_.write("t.csv", table);
    return refusal("calibration: t.csv, columns: 100, rate_hz: 10, range_m: [1, 100]");
  };
  expectRefusals(
      refuse,
      {{"", "is empty"},
       {"a,b\n1,2\n", "t.csv:1: must name the columns, such as Channel,Elevation,Azimuth"},
       {"Channel,Elevation,Azimuth\n1,2\n", "t.csv:2: has 2 cells"},
       {"Channel,Elevation,Azimuth\n1,2,0\n1,3,0\n", "t.csv:3: has the channel of an earlier line"},
       {"Channel,Elevation,Azimuth\n1,2,0\n5,3,0\n", "t.csv:3: has the channel 5"},
       {"Channel,Elevation,Azimuth\n1,95,0\n", "t.csv:2: elevation is 95"},
       {"Channel,Elevation,Elevation\n1,2,3\n", "'elevation' is listed twice"},
       {"Channel,Elevation,Azimut\n1,2,3\n", "did you mean 'azimuth'"},
       {"Channel;Elevation;Azimuth\n1;2,5;0,1\n", "t.csv:2: '2,5' is not a number (write it as 1234.5"},
       {"elevation_deg\n+-5\n", "'+-5' is not a number"},
       {"elevation_deg,azimut_offset_deg\n-3,1\n", "t.csv:1: the column 'azimut_offset_deg' is unknown (did you"},
       {"elevation_deg\n", "no line after the column names"}});
  for (const char* table :
       {"Channel,fire time(s)\n1,2\n", "Channel,fire time\n1,0\n", "Operational State,0,0\n1,2,3\n"}) {
    EXPECT_THAT(messageOf([&] { readFiringTable(folder_.write("s.csv", table)); }),
                AllOf(HasSubstr("s.csv:1"), HasSubstr("fire time(us)"), HasSubstr("several firing states")));
  }
  folder_.write("a.dat", "x");
  EXPECT_THAT(refusal("calibration: a.dat, columns: 100, rate_hz: 10, range_m: [1, 100]"), HasSubstr("mirrors"));
  folder_.write("f.csv", "Channel,fire time(us)\n1,0\n");
  folder_.write("e.csv", "elevation_deg\n2\n");
  EXPECT_THAT(refusal("calibration: e.csv, columns: 100, rate_hz: 10, range_m: [1, 100], "
                      "firing_time_us: {file: f.csv, step_us: 3}"),
              HasSubstr("not both"));
}

// All tables of one state are read, with as many lasers as the sensor's name says; the others are refused with a word.
TEST_F(VendorFiles, AllOfHesaisRealTablesAreReadOrRefused) {
  SKIP_WITHOUT_SHARED_DATA("sensors/hesai");
  const std::map<std::string, std::size_t> lasers{
      {"JT128", 128},      {"JT16", 16},      {"OT128_40", 40},  {"OT128", 128},      {"Pandar128E3X", 128},
      {"Pandar40M", 40},   {"Pandar40P", 40}, {"Pandar64", 64},  {"Pandar90E3X", 90}, {"PandarQT", 64},
      {"PandarXT-16", 16}, {"PandarXT", 32},  {"QT128C2X", 128}, {"XT32M2X", 32}};
  std::size_t read = 0;
  for (const auto& entry : std::filesystem::directory_iterator(sharedData() / "sensors/hesai/angle_correction")) {
    const std::string name = entry.path().filename().string();
    const auto known = lasers.find(name.substr(0, name.find("_Angle")));
    if (known == lasers.end()) continue;
    EXPECT_EQ(readBeamTable(entry.path()).size(), known->second) << name;
    ++read;
  }
  EXPECT_EQ(read, lasers.size());
  std::size_t times = 0;
  std::size_t refused = 0;
  for (const auto& entry : std::filesystem::directory_iterator(sharedData() / "sensors/hesai/firetime_correction")) {
    try {
      EXPECT_GE(readFiringTable(entry.path()).size(), 16u) << entry.path();
      ++times;
    } catch (const InputError& e) {
      EXPECT_THAT(e.what(),
                  testing::ContainsRegex("several firing states|two firing states|cells, but the first line has"))
          << entry.path();
      ++refused;
    }
  }
  EXPECT_EQ(times, 9u);
  EXPECT_EQ(refused, 8u);
}

// A preset whose rings fire from bottom to top, beside a file that lists its lasers from top to bottom.
TEST_F(VendorFiles, FiringTimesOfAPresetAreNotSwapped) {
  std::string down = "Channel,Elevation,Azimuth\n";
  std::string up = down;
  for (int i = 0; i < 16; ++i) {
    down += fmt::format("{},{},0\n", i + 1, 15 - 2 * i);
    up += fmt::format("{},{},0\n", i + 1, 2 * i - 15);
  }
  folder_.write("down.csv", down);
  folder_.write("up.csv", up);
  EXPECT_THAT(refusal("preset: vlp_16, calibration: down.csv"), HasSubstr("are for rings in the order bottom_up"));
  const auto turned = sensor("preset: vlp_16, calibration: up.csv");
  EXPECT_EQ(turned->firingOffset, sensor("preset: vlp_16")->firingOffset);
}

}  // namespace
}  // namespace scanmill
