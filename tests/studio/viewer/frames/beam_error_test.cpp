#include "sense/sense.h"
#include "tests/core/dataset/fixture.h"
#include "tests/core/pipeline/two_returns_yard.h"
#include "tests/core/sense/several_returns.h"
#include "viewer/frames/frame_source.h"
#include "viewer/frames/stored_frames.h"

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
  std::ranges::reverse(turned.position);
  std::ranges::reverse(turned[kRing]);
  std::ranges::reverse(turned[kColumn]);
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
  EXPECT_EQ(std::ranges::count_if(ofImage, [](float e) { return std::isnan(e); }),
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

// Two surfaces that are nearer to each other than the noise is large: the numbers tell them apart, as long as none is
// missing.
TEST(ReturnErrorsOfOneBeam, NumbersDecideWhereNoneIsMissing) {
  Scan clean;
  clean.rings = clean.columns = 1;
  clean.position = {{10, 0, 0}, {11, 0, 0}};
  clean[kRing] = clean[kColumn] = {0, 0};
  clean[kReturn] = {1, 2};
  Scan noisy = clean;
  noisy.position = {{10.75f, 0, 0}, {11.5f, 0, 0}};
  EXPECT_EQ(joined(noisy, clean), (std::vector<float>{0.75f, 0.5f}));
  noisy.position.pop_back();
  for (auto* column : {&noisy[kRing], &noisy[kColumn]}) column->pop_back();
  noisy[kReturn].pop_back();
  EXPECT_EQ(joined(noisy, clean), std::vector<float>{0.25f}) << "which one was lost is not known: the nearest";
}

// Damage: all points are of one beam. It must not take time that grows with their square.
TEST(ReturnErrorsOfOneBeam, AreSoonThereForMillionsOfPoints) {
  Scan scan;
  scan.rings = scan.columns = 1;
  scan.position.assign(1'000'000, {10, 0, 0});
  scan[kRing].assign(scan.size(), 0);
  scan[kColumn].assign(scan.size(), 0);
  for (const float error : joined(scan, scan)) ASSERT_EQ(error, 0);
}

// They move the numbers of the surface's returns, and have no partner themselves.
TEST(ReturnErrorsOfOneBeam, FalsePositivesHaveNone) {
  const World world = makeSeveralReturns(4, 9);
  const Scan clean = senseOnce(world, {}, ScanLayout{ColumnSet::all(), false});
  Returns returns;
  returns.start(world.hits);
  for (std::uint32_t beam = 0; beam < world.hits.size(); ++beam) {
    returns.add({.beam = beam, .range = 3, .cause = Reason::FalsePositive}, world.hits);
  }
  for (std::size_t row = 0; row < returns.size(); ++row) {  // as many returns as there were
    if (returns.returned(row) && returns.cause(row) == Reason::Surface && returns.number(row) == 1) returns.remove(row);
  }
  Scan noisy;
  gather(world.hits, world.shot, returns, ScanLayout{ColumnSet::all(), false}, nullptr, noisy);
  const std::vector<float> errors = joined(noisy, clean);
  ASSERT_EQ(errors.size(), noisy.size());
  std::size_t surfaces = 0;
  for (std::size_t i = 0; i < noisy.size(); ++i) {
    const bool surface = noisy[kCause][i] == static_cast<std::uint8_t>(Reason::Surface);
    surfaces += surface ? 1 : 0;
    EXPECT_EQ(std::isnan(errors[i]), !surface);
    if (surface) {
      EXPECT_EQ(errors[i], 0);
    }
  }
  EXPECT_EQ(surfaces, 24u);
}

constexpr double kRounding = 2e-5;  // m, of coordinates

// A noisy scan and its noise-free reference where beams have two returns, one or none.
class ReturnErrors : public TwoReturnsYard {
 protected:
  // Every point's error is the noise that was put into its range, whatever else the beam has lost. Gives the number of
  // points whose beam has lost the return before them.
  std::size_t expectNoise(const std::string& noisy, const std::string& reference) const {
    ViewInput input;
    input.path = out(noisy);
    input.reference = out(reference);
    const auto frames = openFrames(input);
    std::size_t movedUp = 0;
    for (std::size_t f = 0; f < frames->keys().size(); ++f) {
      const ViewFrame frame = frames->load(f);
      EXPECT_THAT(frame.problems, testing::IsEmpty());
      const ViewScan& viewed = frame.scans.at(0);
      const Scan& scan = viewed.scan;
      EXPECT_EQ(viewed.error.size(), scan.size());
      std::size_t known = 0;
      for (std::size_t i = 0; i < viewed.error.size(); ++i) {
        if (!isFinite(scan.position[i])) {
          EXPECT_TRUE(std::isnan(viewed.error[i]));
          continue;
        }
        const double noise = length(Vec3d(scan.position[i])) - double{scan[kRangeTrue][i]};
        EXPECT_NEAR(viewed.error[i], std::abs(noise), kRounding);
        ++known;
        const PointKey key = keyOf(scan, i);
        const std::uint32_t beam = key.ring * kColumns + key.column;
        movedUp += key.number == 0 && scan[kRangeTrue][i] > rangeOfReturn({}, beam, 0) + 1 ? 1 : 0;
      }
      EXPECT_GT(known, 100u);
    }
    return movedUp;
  }
};

TEST_F(ReturnErrors, AreTheNoiseWhereReturnsWereLost) {
  const std::string effects = "effects=[range_noise: {sigma_m: 0.02}, dropout: {probability: 0.3}]";
  make({kAllColumns}, "clean");
  make({kWithoutReturn}, "unnumbered");
  make({kWithoutReturn, "output.layout=organised"}, "clean_image");
  make({kAllColumns, effects}, "noisy");
  make({kAllColumns, effects, "output.formats=[csv]", "output.layout=organised"}, "table");
  make({kWithoutReturn, effects, "output.layout=organised"}, "image");
  for (const char* noisy : {"noisy", "table", "image"}) {
    for (const char* clean : {"clean", "unnumbered", "clean_image"}) {
      SCOPED_TRACE(fmt::format("{} against {}", noisy, clean));
      EXPECT_GT(expectNoise(noisy, clean), 20u);
    }
  }
  make({kWithoutReturn, effects}, "noisy_unnumbered");
  EXPECT_GT(expectNoise("noisy_unnumbered", "clean"), 20u);
}

}  // namespace
}  // namespace scanmill
