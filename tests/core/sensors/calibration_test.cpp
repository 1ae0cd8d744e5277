#include "sensors/calibration.h"

#include "config/fields.h"
#include "sensors/sensor.h"
#include "tests/support/message_of.h"
#include "tests/support/shared_data.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

struct DriverLaser {
  double vertical, rotation, up, left;
};

std::vector<DriverLaser> lasersOf(const Value& file) {
  std::vector<DriverLaser> lasers;
  for (const Value& item : file.find("lasers")->items) {
    const auto figure = [&](const char* key) {
      const Value* value = item.find(key);
      return value == nullptr ? 0.0 : readNumber(*value, key);
    };
    lasers.push_back({figure("vert_correction"), figure("rot_correction"), figure("vert_offset_correction"),
                      figure("horiz_offset_correction")});
  }
  return lasers;
}

// What velodyne_pointcloud makes of a distance: rawdata.cc, unpack(), with the head turned clockwise by an angle, in
// the frame of ROS (x forward, y left).
Vec3d driversPoint(const DriverLaser& laser, double turned, double distance) {
  const double rotation = turned - laser.rotation;
  const double flat = distance * std::cos(laser.vertical) - laser.up * std::sin(laser.vertical);
  const double x = flat * std::sin(rotation) - laser.left * std::cos(rotation);
  const double y = flat * std::cos(rotation) + laser.left * std::sin(rotation);
  const double z = distance * std::sin(laser.vertical) + laser.up * std::cos(laser.vertical);
  return {y, -x, z};
}

void expectTheDriversBeams(const std::filesystem::path& file) {
  const Value text = readYaml(file);
  const auto beams = makeBeams(resolveSensor(parseYaml(
      "{calibration: " + file.string() + ", columns: 90, rate_hz: 10, direction: clockwise, range_m: [0.9, 120]}",
      "s.yaml")));
  std::vector<DriverLaser> lasers = lasersOf(text);
  std::stable_sort(lasers.begin(), lasers.end(),
                   [](const DriverLaser& a, const DriverLaser& b) { return a.vertical > b.vertical; });
  ASSERT_EQ(beams->rings, lasers.size());
  EXPECT_TRUE(beams->topDown);
  for (std::uint32_t ring = 0; ring < beams->rings; ++ring) {
    for (std::uint32_t column = 0; column < 90; column += 13) {
      const std::size_t beam = std::size_t{ring} * 90 + column;
      const Vec3d origin = beams->origin.empty() ? Vec3d{} : Vec3d(beams->origin[beam]);
      const Vec3d ours = origin + beams->direction[beam] * 40.0;
      EXPECT_LT(length(ours - driversPoint(lasers[ring], radians(4.0 * column), 40.0)), 1e-7) << ring;
    }
  }
}

TEST(Calibration, MakesTheBeamsOfTheDriver) {
  const TemporaryFolder folder;
  expectTheDriversBeams(
      folder.write("unit.yaml",
                   "distance_resolution: 0.002\nlasers:\n"
                   "- {laser_id: 0, vert_correction: -0.15, rot_correction: -0.12, dist_correction: 1.5,\n"
                   "   horiz_offset_correction: 0.026, vert_offset_correction: 0.195}\n"
                   "- {laser_id: 1, vert_correction: 0.03, rot_correction: 0.07, vert_offset_correction: 0.21}\n"
                   "- {laser_id: 2, vert_correction: -0.4, rot_correction: 0, horiz_offset_correction: -0.026}\n"));
}

TEST(Calibration, RealUnitsAreReadAsTheirDriverDoes) {
  SKIP_WITHOUT_SHARED_DATA("sensors/velodyne");
  for (const char* name :
       {"64e_s2.1-sztaki.yaml", "64e_s3-xiesc.yaml", "64e_utexas.yaml", "32db.yaml", "VLP16db.yaml", "VLS128.yaml"}) {
    SCOPED_TRACE(name);
    expectTheDriversBeams(sharedData() / "sensors/velodyne" / name);
  }
}

TEST(Calibration, StandsInPlaceOfThePresetsAngles) {
  const TemporaryFolder folder;
  folder.write("unit.yaml",
               "lasers: [{vert_correction: 0.1, rot_correction: 0}, {vert_correction: -0.1, "
               "rot_correction: 0.2}]\n");
  folder.write("sensor.yaml", "columns: 10\nrate_hz: 5\nelevation_deg: [3, 2]\nsource: data sheet\nrange_m: [1, 50]\n");
  const std::string file = folder.write("p.yaml", "{preset: sensor.yaml, calibration: unit.yaml}\n");
  const auto beams = makeBeams(resolveSensor(readYaml(file)));
  ASSERT_EQ(beams->rings, 2u);
  EXPECT_NEAR(beams->elevation[1], -0.1, 1e-12);
  EXPECT_NEAR(beams->azimuthOffset[1], 0.2, 1e-12);
  EXPECT_TRUE(beams->origin.empty());
  EXPECT_THAT(beams->source, AllOf(HasSubstr("unit.yaml"), HasSubstr("SHA-256"), HasSubstr("data sheet")));
  const std::string empty = folder.write(
      "e.yaml", "{preset: sensor.yaml, calibration: unit.yaml, azimuth_offset_deg: , ring_order: , source: }\n");
  const auto same = makeBeams(resolveSensor(readYaml(empty)));
  EXPECT_NEAR(same->azimuthOffset[1], 0.2, 1e-12) << "an empty key counts as none";
  EXPECT_THAT(same->source, HasSubstr("unit.yaml"));
  folder.write("sensor.yaml", "columns: 10\nrate_hz: 5\nelevation_deg: [3, 2, 1]\nrange_m: [1, 50]\n");
  EXPECT_THAT(messageOf([&] { return resolveSensor(readYaml(file)); }),
              AllOf(HasSubstr("p.yaml:1"), HasSubstr("2 lasers"), HasSubstr("3 rings")));
}

TEST(Calibration, RefusesWhatIsNone) {
  const TemporaryFolder folder;
  struct Case {
    const char* name;
    std::string text, words;
    const char* more = "";
  };
  // Neither a distance in place of an angle nor other units.
  for (const Case& c :
       {Case{"u.yaml", "laser: []\n", "u.yaml:1:1: is not a calibration"},
        {"u.yaml", "lasers: [{vert_correction: 0.1}]\n", "u.yaml:1:10: laser: the key 'rot_correction' is missing"},
        {"u.yaml", "lasers: [{vert_correction: 8, rot_correction: 0}]\n", "vert_correction (rad)"},
        {"u.yaml", "lasers: [{rot_correction: 0, vert_offset_correction: 0}]", "'vert_correction' is missing"},
        {"u.yaml", "lasers: [{rot_correction: 0, vert_correction: 0, horiz_offset_correction: 2.6}]",
         "horiz_offset_correction (m) must be a number from -0.5 to 0.5"},
        {"u.yaml", "lasers: [{vert_correction: 0, rot_correction: 0}]\n",
         "elevation_deg follows from the `calibration`", ", elevation_deg: [1]"},
        {"u.xml", "<boost_serialization/>", "gen_calibration.py"},
        {"u.calib", "Channel\tElevation\tAzimuth\n1\t2\t3\n", "tables of beams .csv"}}) {
    folder.write(c.name, c.text);
    const std::string keys =
        std::string("{columns: 10, rate_hz: 5, range_m: [1, 50], calibration: ") + c.name + c.more + "}";
    EXPECT_THAT(messageOf([&] { makeBeams(parseYaml(keys, (folder.path() / "s.yaml").string())); }), HasSubstr(c.words))
        << c.text;
  }
  EXPECT_THAT(messageOf([] { makeBeams(parseYaml("calibration: absent.yaml", "s.yaml")); }), HasSubstr("absent.yaml"));
}

TEST(Calibration, UnknownKeysAreTold) {
  const TemporaryFolder folder;
  const std::string file =
      folder.write("u.yaml", "lasers: [{rot_correction: 0, vert_correction: 0, focal_slope: 1, horiz_offset: 0.02}]\n");
  EXPECT_THAT(printedBy([&] { (void)withCalibration(parseYaml("calibration: " + file, "s.yaml")); }),
              AllOf(HasSubstr("u.yaml: left out: 1 unknown 'horiz_offset'\n"), testing::Not(HasSubstr("focal"))));
}

}  // namespace
}  // namespace scanmill
