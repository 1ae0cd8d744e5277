// What lies between a noisy scan and its noise-free reference where beams have two returns, one or none.

#include "tests/core/sense/several_returns.h"

#include <cmath>

#include "sense/gather.h"
#include "tests/core/pipeline/two_returns_yard.h"
#include "viewer/frames/beam_error.h"
#include "viewer/frames/frame_source.h"

namespace scanmill {
namespace {

constexpr ScanLayout kDense{ColumnSet::all(), false};
constexpr double kRounding = 2e-5;  // m, of coordinates

std::vector<float> joined(const Scan& scan, const Scan& reference) {
  std::string why;
  std::vector<float> errors = referenceErrors(scan, reference, why);
  EXPECT_EQ(why, "");
  return errors;
}

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

TEST_F(ReturnErrors, AreTheNoiseThatWasPutIn) {
  make({kAllColumns}, "clean");
  make({kAllColumns, "effects=[range_noise: {sigma_m: 0.02}]"}, "noisy");
  make({kAllColumns, "effects=[range_noise: {sigma_m: 0.02}]", "output.layout=organised"}, "image");
  EXPECT_EQ(expectNoise("noisy", "clean"), 0u);
  EXPECT_EQ(expectNoise("image", "clean"), 0u);
}

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

// Range errors need no partner.
TEST_F(ReturnErrors, OfRangeTrueAreTheNoiseToo) {
  make({kAllColumns, "effects=[range_noise: {sigma_m: 0.02}, dropout: {probability: 0.3}]"}, "noisy");
  for (const Scan& scan : scans(".pcd", "noisy")) {
    const std::vector<float> errors = rangeErrors(scan, nullptr);
    ASSERT_EQ(errors.size(), scan.size());
    for (std::size_t i = 0; i < scan.size(); ++i) EXPECT_LT(errors[i], 0.2);
  }
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
  const Scan clean = senseOnce(world, {}, kDense);
  Returns returns;
  returns.start(world.hits);
  for (std::uint32_t beam = 0; beam < world.hits.size(); ++beam) {
    returns.add({.beam = beam, .range = 3, .cause = Cause::FalsePositive}, world.hits);
  }
  for (std::size_t row = 0; row < returns.size(); ++row) {  // as many returns as there were
    if (returns.returned(row) && returns.cause(row) == Cause::Surface && returns.number(row) == 1) returns.remove(row);
  }
  Scan noisy;
  gather(world.hits, world.shot, returns, kDense, nullptr, noisy);
  const std::vector<float> errors = joined(noisy, clean);
  ASSERT_EQ(errors.size(), noisy.size());
  std::size_t surfaces = 0;
  for (std::size_t i = 0; i < noisy.size(); ++i) {
    const bool surface = noisy[kCause][i] == static_cast<std::uint8_t>(Cause::Surface);
    surfaces += surface ? 1 : 0;
    EXPECT_EQ(std::isnan(errors[i]), !surface);
    if (surface) {
      EXPECT_EQ(errors[i], 0);
    }
  }
  EXPECT_EQ(surfaces, 24u);
}

}  // namespace
}  // namespace scanmill
