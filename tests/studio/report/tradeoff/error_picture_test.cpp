#include <limits>
#include <map>

#include "images/images.h"
#include "report/tradeoff/report.h"
#include "tests/support/test_scene.h"
#include "viewer/color_map.h"
#include "viewer/image.h"

namespace scanmill {
namespace {

constexpr Rgb kFalseNegative{255, 70, 70};
constexpr Rgb kFalsePositive{255, 255, 255};
constexpr Rgb kOtherLabel{255, 150, 220};
constexpr double kDarkest = 0.15;  // of the colour map: no error

// A cylinder of points 10 m around the sensor, all of one thing.
TrueShot cylinder() {
  TrueShot truth;
  truth.shot = shotAt(spinning(32, 180, -20, 20));
  truth.shot.sample = "yard-s1-drive-000002";
  Hits& hits = truth.truth.hits;
  hits.reset(32, 180, kErrorChannels);
  std::ranges::fill(hits.range, 10.0f);
  std::ranges::fill(hits.instance, 3u);
  std::ranges::fill(hits.semantic, std::uint16_t{2});
  std::ranges::fill(hits.incidence, 0.0f);
  truth.truth.range.assign(hits.size(), 10.0);
  return truth;
}

struct Drawn {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::map<Rgb, std::size_t> pixels;  // of each colour
};

Drawn drawn(const TrueShot& truth, const Hits& tested) {
  const DecodedImage image = decodeImage(drawErrors(truth, tested), "errors.png");
  Drawn counted{image.width, image.height, {}};
  for (std::size_t p = 0; p < image.rgba.size(); p += 4) {
    ++counted.pixels[{image.rgba[p], image.rgba[p + 1], image.rgba[p + 2]}];
  }
  return counted;
}

TEST(ErrorPicture, IsTheSameEveryTime) {
  const TrueShot truth = cylinder();
  EXPECT_EQ(drawErrors(truth, truth.truth.hits), drawErrors(truth, truth.truth.hits));
  const Drawn picture = drawn(truth, truth.truth.hits);
  EXPECT_EQ(picture.width, 1200u);
  EXPECT_EQ(picture.height, 675u);
}

// Errors of every kind fill the picture with the colour that the legend gives them.
TEST(ErrorPicture, EveryKindOfErrorHasItsColor) {
  const TrueShot truth = cylinder();
  const Hits& real = truth.truth.hits;
  Drawn exact = drawn(truth, real);

  Hits unhit = real;
  std::ranges::fill(unhit.range, kMiss);
  Hits relabelled = real;
  std::ranges::fill(relabelled.semantic, std::uint16_t{1});
  Hits othered = real;
  std::ranges::fill(othered.instance, 4u);
  Hits off = real;
  for (float& range : off.range) range += 2;  // more than the scale holds
  Hits slightly = real;
  for (float& range : slightly.range) range += 0.03162f;  // 10^-1.5 m: in the middle of the scale
  TrueShot nothing = truth;
  std::ranges::fill(nothing.truth.hits.range, kMiss);
  std::ranges::fill(nothing.truth.range, std::numeric_limits<double>::infinity());

  const auto filled = [&](Drawn picture, const Rgb& color) {
    return static_cast<double>(picture.pixels[color]) - static_cast<double>(exact.pixels[color]);
  };
  EXPECT_GT(filled(drawn(truth, unhit), kFalseNegative), 3000);
  EXPECT_GT(filled(drawn(nothing, real), kFalsePositive), 3000);
  EXPECT_GT(filled(drawn(truth, relabelled), kOtherLabel), 3000);
  EXPECT_GT(filled(drawn(truth, othered), kOtherLabel), 3000);
  EXPECT_GT(filled(drawn(truth, off), viridis(1)), 3000);
  EXPECT_GT(exact.pixels[viridis(kDarkest)], 3000u);
  Drawn middle = drawn(truth, slightly);
  EXPECT_LT(middle.pixels[viridis(kDarkest)], 3000u);
  EXPECT_LT(middle.pixels[viridis(1)], 3000u);
}

TEST(ErrorPicture, ScansWithoutAnyHitAreDrawnToo) {
  TrueShot nothing = cylinder();
  std::ranges::fill(nothing.truth.hits.range, kMiss);
  std::ranges::fill(nothing.truth.range, std::numeric_limits<double>::infinity());
  EXPECT_EQ(drawn(nothing, nothing.truth.hits).width, 1200u);
}

}  // namespace
}  // namespace scanmill
