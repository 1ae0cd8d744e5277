// What lies between a noisy scan and its noise-free reference where beams have two returns, one or none.

#include "tests/core/pipeline/two_returns_yard.h"
#include "viewer/frames/frame_source.h"
#include "viewer/frames/stored_frames.h"

namespace scanmill {
namespace {

constexpr double kRounding = 2e-5;  // m, of coordinates

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
