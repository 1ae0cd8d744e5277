#include "viewer/frames/beam_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/dataset/fixture.h"

namespace scanmill {

namespace {

using testing::HasSubstr;

// Each point goes that far along its beam.
double shift(std::size_t point) {
  return 0.01 * static_cast<double>(point % 7) - 0.02;
}

Scan noisy(Scan scan) {
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const Vec3d p(scan.position[i]);
    scan.position[i] = Vec3f(p + normalized(p) * shift(i));
  }
  return scan;
}

std::vector<float> joined(const Scan& scan, const Scan& reference) {
  std::string why;
  std::vector<float> errors = referenceErrors(scan, reference, why);
  EXPECT_EQ(why, "");
  return errors;
}

std::string refusal(const Scan& scan, const Scan& reference) {
  std::string why;
  EXPECT_TRUE(referenceErrors(scan, reference, why).empty());
  return why;
}

TEST(ReferenceErrors, AreTheNoiseByConstruction) {
  const Scan clean = testScan(testBeams(32, 64), 3);
  const Scan scan = noisy(clean);
  const std::vector<float> errors = joined(scan, clean);
  ASSERT_EQ(errors.size(), scan.size());
  for (std::size_t i = 0; i < scan.size(); ++i) EXPECT_NEAR(errors[i], std::abs(shift(i)), 2e-5) << i;
  for (const float e : joined(clean, clean)) EXPECT_EQ(e, 0);
}

// The order of the points says nothing: beams do. Nor does it matter which of the two is organised.
TEST(ReferenceErrors, AnyOrderAndLayoutGivesTheSame) {
  const Scan clean = testScan(testBeams(32, 64), 3);
  const Scan scan = noisy(clean);
  const std::vector<float> expected = joined(scan, clean);
  Scan turned = clean;
  std::reverse(turned.position.begin(), turned.position.end());
  std::reverse(turned[kRing].begin(), turned[kRing].end());
  std::reverse(turned[kColumn].begin(), turned[kColumn].end());
  EXPECT_EQ(joined(scan, turned), expected);
  Scan image = organised(clean);
  image[kRing].clear();
  image[kColumn].clear();
  EXPECT_EQ(joined(scan, image), expected);
  const std::vector<float> ofImage = joined(organised(scan), image);
  ASSERT_EQ(ofImage.size(), image.size());
  for (std::size_t i = 0; i < scan.size(); ++i) {
    EXPECT_EQ(ofImage[std::size_t{scan[kRing][i]} * scan.columns + scan[kColumn][i]], expected[i]);
  }
  EXPECT_EQ(std::count_if(ofImage.begin(), ofImage.end(), [](float e) { return std::isnan(e); }),
            static_cast<std::ptrdiff_t>(image.size() - scan.size()));
}

TEST(ReferenceErrors, AreUnknownWhereTheReferenceHasNoPoint) {
  const Scan scan = testScan(testBeams(8, 16), 3);
  Scan reference = scan;
  for (auto* column : {&reference[kRing], &reference[kColumn]}) column->resize(10);
  reference.position.resize(10);
  reference.position[4].y = NAN;
  const std::vector<float> errors = joined(scan, reference);
  for (std::size_t i = 0; i < errors.size(); ++i) EXPECT_EQ(std::isnan(errors[i]), i >= 10 || i == 4) << i;
  Scan empty;
  for (const float e : joined(scan, empty)) EXPECT_TRUE(std::isnan(e));
  EXPECT_TRUE(joined(empty, scan).empty());
}

TEST(ReferenceErrors, NeedToKnowTheBeams) {
  const Scan scan = testScan(testBeams(8, 16), 3);
  Scan bare = scan;
  bare[kColumn].clear();
  EXPECT_THAT(refusal(bare, scan), testing::AllOf(HasSubstr("the scan"), HasSubstr("output.columns")));
  EXPECT_THAT(refusal(scan, bare), HasSubstr("the noise-free reference does not say"));
  EXPECT_THAT(refusal(scan, testScan(testBeams(4, 16), 3)), HasSubstr("4 x 16 beams, not 8 x 16"));
  Scan wide = scan;
  wide.rings = wide.columns = 0;
  wide[kRing][0] = wide[kColumn][1] = 65535;
  EXPECT_THAT(refusal(scan, wide), HasSubstr("65536 x 65536"));
}

TEST(RangeErrors, CountFromWhereTheBeamStarts) {
  const BeamTable beams = testBeams(16, 32);
  ASSERT_FALSE(beams.origin.empty());
  Scan scan = testScan(beams, 5);
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const std::size_t beam = std::size_t{scan[kRing][i]} * beams.columns + scan[kColumn][i];
    scan.position[i] =
        Vec3f(Vec3d(beams.origin[beam]) + beams.direction[beam] * (double{scan[kRangeTrue][i]} + shift(i)));
  }
  const std::vector<float> errors = rangeErrors(scan, &beams);
  ASSERT_EQ(errors.size(), scan.size());
  for (std::size_t i = 0; i < scan.size(); ++i) EXPECT_NEAR(errors[i], std::abs(shift(i)), 2e-5) << i;
  const std::vector<float> ofImage = rangeErrors(organised(scan), &beams);
  std::size_t known = 0;
  for (const float e : ofImage) known += std::isnan(e) ? 0 : 1;
  EXPECT_EQ(known, scan.size());

  for (std::size_t i = 0; i < scan.size(); ++i) {
    scan.position[i] = Vec3f(normalized(Vec3d(scan.position[i])) * (double{scan[kRangeTrue][i]} + shift(i)));
  }
  const std::vector<float> central = rangeErrors(scan, nullptr);
  for (std::size_t i = 0; i < scan.size(); ++i) EXPECT_NEAR(central[i], std::abs(shift(i)), 2e-5) << i;
}

TEST(RangeErrors, NeedTheColumn) {
  const BeamTable beams = testBeams(4, 8);
  Scan scan = testScan(beams, 5);
  scan[kRing][0] = 60000;  // damage
  EXPECT_TRUE(std::isnan(rangeErrors(scan, &beams)[0]));
  scan[kRangeTrue].clear();
  EXPECT_TRUE(rangeErrors(scan, &beams).empty());
}

}  // namespace

}  // namespace scanmill
