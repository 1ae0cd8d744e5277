#include "study/sensor/fit_sensor.h"

#include "base/random.h"
#include "dataset/scan_store.h"
#include "sensors/sensor.h"
#include "tests/support/message_of.h"
#include "tests/support/shared_data.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

std::shared_ptr<const BeamTable> sensor(const std::string& yaml) {
  return makeBeams(parseYaml("{rate_hz: 10, range_m: [0.1, 200], " + yaml + "}", "s.yaml"));
}

double draw(std::uint32_t beam, std::uint32_t frame, std::size_t k) {
  return uniform(randomBlock({11, frame, beam, 0, 0, 0, Purpose::Placement})[k]);
}

// A revolution in a place where ranges are anything from 2 to 60 m and a fifth of the beams returns nothing; `noise` is
// that of the range (m).
Scan scanOf(const BeamTable& beams, std::uint32_t frame, bool organised, double noise = 0.02) {
  Scan scan;
  scan.rings = beams.rings;
  scan.columns = beams.columns;
  scan.organised = organised;
  for (std::uint32_t beam = 0; beam < beams.size(); ++beam) {
    const bool lost = draw(beam, frame, 0) < 0.2;
    if (lost && !organised) continue;
    const double range = 2 + 58 * draw(beam, frame, 1) + noise * (draw(beam, frame, 2) - 0.5);
    const Vec3d origin = beams.origin.empty() ? Vec3d{} : Vec3d(beams.origin[beam]);
    const Vec3d p = origin + beams.direction[beam] * range;
    const float nan = std::nanf("");
    scan.position.push_back(lost ? Vec3f{nan, nan, nan} : static_cast<Vec3f>(p));
    scan[kTime].push_back(beams.time[beam]);
    if (organised) continue;
    scan[kRing].push_back(static_cast<std::uint16_t>(beam / beams.columns));
    scan[kColumn].push_back(static_cast<std::uint16_t>(beam % beams.columns));
  }
  return scan;
}

// The greatest angle (deg) and distance (m) between beams of two tables.
std::pair<double, double> apart(const BeamTable& a, const BeamTable& b) {
  EXPECT_EQ(a.rings, b.rings);
  EXPECT_EQ(a.columns, b.columns);
  double angle = 0;
  double origin = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    angle = std::max(angle, degrees(2 * std::asin(length(a.direction[i] - b.direction[i]) / 2)));
    const Vec3d from = a.origin.empty() ? Vec3d{} : Vec3d(a.origin[i]);
    origin = std::max(origin, length(from - (b.origin.empty() ? Vec3d{} : Vec3d(b.origin[i]))));
  }
  return {angle, origin};
}

struct Kind {
  const char* name;
  const char* yaml;
};

constexpr Kind kKinds[] = {
    {"plain", "columns: 360, elevation_deg: {top: 15, bottom: -15, rings: 16}"},
    {"clockwise and staggered",
     "columns: 512, direction: clockwise, first_azimuth_deg: 123, azimuth_offset_deg: [4.2, 1.4, -1.4, -4.2], "
     "elevation_deg: [20, 14, 9, 3, -1, -6, -11, -20], origin_offset_m: 0.0275, origin_height_m: 0.038"},
    {"part of a turn, from below, one after the other",
     "columns: 241, first_azimuth_deg: -60, field_deg: 120, ring_order: bottom_up, elevation_deg: [-8, -4, 0, 4], "
     "firing_time_us: {step_us: 25}"},
};

TEST(FitSensor, RecoversTheBeamsFromNoisyScans) {
  for (const Kind& kind : kKinds) {
    for (const bool organised : {true, false}) {
      SCOPED_TRACE(kind.name);
      const auto truth = sensor(kind.yaml);
      std::vector<Scan> scans;
      for (std::uint32_t frame = 0; frame < 3; ++frame) scans.push_back(scanOf(*truth, frame, organised));
      const SensorFit fit = fitSensor(scans);
      const auto found = makeBeams(parseYaml(sensorYaml(fit, "a test"), "fitted.yaml"));
      const auto [angle, origin] = apart(*truth, *found);
      EXPECT_LT(angle, 0.002);
      EXPECT_LT(origin, 0.0015);
      EXPECT_NEAR(found->period, 0.1, 1e-4);
      EXPECT_EQ(found->topDown, truth->topDown);
      EXPECT_EQ(found->clockwise, truth->clockwise);
      for (std::uint32_t r = 0; r < truth->rings; ++r) {
        EXPECT_NEAR(found->firingOffset[r] - found->firingOffset[0], truth->firingOffset[r] - truth->firingOffset[0],
                    1e-7);
      }
      EXPECT_LT(degrees(fit.elevationSpread), 1e-3);
      EXPECT_TRUE(fit.bareRings.empty());
    }
  }
}

// Rings that meet nothing lie between, or beyond, their neighbours.
TEST(FitSensor, GuessesRingsWithoutPoints) {
  const auto truth =
      sensor("columns: 360, elevation_deg: {top: 14, bottom: -16, rings: 16}, firing_time_us: {step_us: 5}");
  Scan scan = scanOf(*truth, 0, true);
  const float nan = std::nanf("");
  for (const std::size_t ring : {0, 1, 7}) {
    for (std::size_t c = 0; c < 360; ++c) scan.position[ring * 360 + c] = {nan, nan, nan};
  }
  const SensorFit fit = fitSensor({scan});
  EXPECT_THAT(fit.bareRings, testing::ElementsAre(0, 1, 7));
  EXPECT_NEAR(fit.firing[2], 0, 1e-7) << "times count from the first ring whose time is known";
  for (std::size_t ring = 0; ring < 16; ++ring)
    EXPECT_NEAR(degrees(fit.elevation[ring]), 14 - 2.0 * static_cast<double>(ring), 0.01) << ring;
}

TEST(FitSensor, SaysWhatScansLack) {
  Scan scan;
  scan.position = {{1, 2, 3}};
  EXPECT_THAT(messageOf([&] { fitSensor({scan}); }), HasSubstr("the beams of the scans' points are unknown"));
  EXPECT_THAT(messageOf([] { fitSensor({}); }), HasSubstr("no scan"));
  const auto truth = sensor("columns: 360, elevation_deg: [1, 2, 3, 4], ring_order: bottom_up");
  Scan bare = scanOf(*truth, 0, true);
  for (Vec3f& p : bare.position) p.x = std::nanf("");
  EXPECT_THAT(messageOf([&] { fitSensor({bare}); }), HasSubstr("too few"));
}

// Three real revolutions against the unit's own metadata, in which ring 0 is the top beam: elevations and offsets of
// the 128 lasers, whose angles the vendor gives to a hundredth of a degree.
TEST(FitSensor, RecoversARealUnit) {
  SKIP_WITHOUT_SHARED_DATA("lidar/ouster_os1_128");
  const std::filesystem::path folder = sharedData() / "lidar/ouster_os1_128";
  std::vector<Scan> scans;
  for (const char* frame : {"frame_1795.pcd", "frame_1796.pcd", "frame_1797.pcd"}) {
    scans.push_back(findScan(folder / frame, "", "").scan);
  }
  const SensorFit fit = fitSensor(scans);
  std::filesystem::path metadata;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".json") metadata = entry.path();
  }
  const auto truth = makeBeams(
      parseYaml("{calibration: " + metadata.string() + ", range_m: [0.1, 200]}", (folder / "s.yaml").string()));
  ASSERT_EQ(fit.rings, truth->rings);
  double middle = 0;
  for (std::uint32_t r = 0; r < fit.rings; ++r) {
    EXPECT_NEAR(degrees(fit.elevation[r]), degrees(truth->elevation[r]), 0.001) << r;
    middle += (fit.azimuthOffset[r] - truth->azimuthOffset[r]) / fit.rings;
  }
  for (std::uint32_t r = 0; r < fit.rings; ++r) {
    EXPECT_NEAR(degrees(fit.azimuthOffset[r] - middle), degrees(truth->azimuthOffset[r]), 0.005) << r;
  }
  EXPECT_EQ(fit.clockwise, truth->clockwise);
  EXPECT_NEAR(fit.originOffset, truth->originOffset, 5e-4);
  EXPECT_EQ(fit.originHeight, 0) << "the recording leaves it out";
}

}  // namespace
}  // namespace scanmill
