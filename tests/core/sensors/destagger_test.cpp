#include <set>

#include "config/fields.h"
#include "sensors/beams.h"
#include "sensors/sensor.h"
#include "tests/support/shared_data.h"
#include "tests/support/street.h"

namespace scanmill {
namespace {

class DestaggeredPreset : public testing::TestWithParam<const char*> {};

// Each beam is within half a column of the direction of its image column, and no two beams share a pixel. A partial
// field (AT128) needs a wider image, whose first column depends on the ring with the least shift.
TEST_P(DestaggeredPreset, EachImageColumnLooksInOneDirection) {
  const auto beams = presetBeams(GetParam());
  const Destagger image = destagger(*beams);
  ASSERT_EQ(image.shift.size(), beams->rings);
  EXPECT_EQ(image.width > beams->columns, !beams->fullTurn());
  const double step = beams->azimuth(1) - beams->azimuth(0);
  double first = beams->azimuth(0);  // of the image's column 0
  if (!beams->fullTurn()) first += *std::ranges::max_element(beams->azimuthOffset);
  double stray = 0;
  double staggered = 0;
  for (std::uint32_t ring = 0; ring < beams->rings; ++ring) {
    std::set<std::uint32_t> places;
    for (std::uint32_t column = 0; column < beams->columns; ++column) {
      const Vec3d& d = beams->direction[std::size_t{ring} * beams->columns + column];
      const std::uint32_t place = image.columnOf(ring, column);
      ASSERT_LT(place, image.width);
      places.insert(place);
      const double azimuth = std::atan2(d.y, d.x);
      const auto off = [&](std::uint32_t x) { return std::remainder(azimuth - first - step * x, 2 * kPi) / step; };
      stray = std::max(stray, std::abs(off(place)));
      staggered = std::max(staggered, std::abs(off(column)));
    }
    EXPECT_EQ(places.size(), beams->columns);
  }
  EXPECT_LE(stray, 0.5 + 1e-5);
  EXPECT_GT(staggered, 2);
}

INSTANTIATE_TEST_SUITE_P(Presets, DestaggeredPreset,
                         testing::Values("hdl_64e", "os1_128", "vlp_32c", "vls_128", "pandar_128", "at_128"));

TEST(Destagger, FollowsTheVendorsShiftsPerRow) {
  SKIP_WITHOUT_SHARED_DATA("sensors/ouster/OS-1-128_v2.3.0_1024x10.json");
  const Value file = readYaml(sharedData() / "sensors/ouster/OS-1-128_v2.3.0_1024x10.json");  // JSON is YAML
  const std::vector<double> vendors = readNumbers(*file.find("data_format")->find("pixel_shift_by_row"), "shifts");
  const Destagger image = destagger(*presetBeams("os1_128"));
  ASSERT_EQ(vendors.size(), image.shift.size());
  for (std::size_t ring = 0; ring < vendors.size(); ++ring) {
    // The vendor's shifts count from the least one: all are 12 columns larger.
    EXPECT_EQ((image.shift[ring] + 12) % 1024, static_cast<std::uint32_t>(vendors[ring])) << ring;
  }
}

TEST(Destagger, SensorsWithoutAzimuthOffsetsKeepTheirColumns) {
  for (const char* name : {"livox_mid_360", "rs_m1", "paper_64", "lms511"}) {
    const auto beams = presetBeams(name);
    const Destagger image = destagger(*beams);
    EXPECT_EQ(image.width, beams->columns) << name;
    EXPECT_EQ(image.shift, std::vector<std::uint32_t>(beams->rings)) << name;
  }
}

}  // namespace
}  // namespace scanmill
