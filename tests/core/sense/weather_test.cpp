#include "sense/weather.h"

#include "base/vec.h"
#include "methods/interface/light_paths.h"

namespace scanmill {
namespace {

TEST(DropSizes, AreMarshallAndPalmers) {
  const DropSizes drops = rainDrops(25);
  EXPECT_DOUBLE_EQ(drops.intercept, 8000);
  EXPECT_NEAR(drops.slope, 4.1 * std::pow(25, -0.21), 1e-9);
  // Integrals of the density, by sums.
  double above = 0;
  double squares = 0;
  const double step = 1e-3;
  for (double d = step / 2; d < 30; d += step) {
    const double density = 8000 * std::exp(-drops.slope * d) * step;
    above += d > 1.5 ? density : 0;
    squares += d * d * density;
  }
  EXPECT_NEAR(drops.above(1.5) / above, 1, 1e-5);
  EXPECT_NEAR(drops.squares() / squares, 1, 1e-5);
}

// Gunn and Marshall's law holds as much water as falls at about 1 m/s.
TEST(DropSizes, OfSnowHoldTheWaterThatFalls) {
  for (const double rate : {0.5, 1.0, 4.0}) {
    const DropSizes flakes = snowFlakes(rate);
    const double water = kPi / 6 * flakes.intercept * 6 / std::pow(flakes.slope, 4) * 1e-9;  // of the air's volume
    const double speed = rate / 3600 * 1e-3 / water;
    EXPECT_GT(speed, 0.7) << rate;
    EXPECT_LT(speed, 1.4) << rate;
  }
}

TEST(Weather, RainTakesTwiceWhatItsDropsCover) {
  // As much as the power laws that were fitted to rain: 1.076 R^0.67 dB/km (Carbonneau and Wisely 1998), within a half.
  for (const double rate : {2.0, 10.0, 40.0}) {
    const double fitted = 1.076 * std::pow(rate, 0.67) / 4.343 / 1000;
    EXPECT_NEAR(rainOf(rate).extinction / fitted, 1, 0.5) << rate;
  }
  EXPECT_NEAR(rainOf(10).extinction, kPi * 8000 / std::pow(4.1 * std::pow(10, -0.21), 3) * 1e-6, 1e-9);
}

TEST(Weather, FogLeavesATwentiethAtTheVisibility) {
  for (const double visibility : {30.0, 200.0}) {
    EXPECT_NEAR(std::exp(-fogOf(visibility).extinction * visibility), 0.05, 1e-12);
    EXPECT_NEAR(std::exp(-dustOf(visibility).extinction * visibility), 0.05, 1e-12);
  }
  EXPECT_NEAR(fogOf(50).backscatter, std::log(20) / 50 / 18.8, 1e-12);  // water at 905 nm: 18.8 +- 0.8 sr
  EXPECT_NEAR(mistEcho(fogOf(50), 0.75), kPi * fogOf(50).backscatter * 0.75, 1e-15);
}

// A drop that fills a beam sends back 2 to 3 % of what a white target does; a flake 2 pi / 25 sr of its own area times
// pi, over pi.
TEST(Weather, DropsReflectAsWaterAndFlakesAsSnow) {
  const double area = kPi / 4 * 1e-6;  // of 1 mm^2 across, in m^2
  EXPECT_NEAR(rainOf(5).dropEcho / area, 0.0235, 0.0005);
  const double width = std::pow(10, 1.0 / 3);
  EXPECT_NEAR(snowOf(5).dropEcho / (area * width * width), 2 * kPi / 25, 1e-9);
}

TEST(Weather, WetGroundIsDarkerAndItsFilmSendsGrazingLightAway) {
  EXPECT_NEAR(dampness(0), 1 / (1.328 * 1.328), 1e-12);
  EXPECT_NEAR(dampness(1), 1, 1e-12);
  EXPECT_NEAR(dampness(0.13), 0.13 / (1.328 * 1.328 * 0.87 + 0.13) / 0.13, 1e-12);
  EXPECT_NEAR(filmTransmission(1), 1, 1e-12);
  EXPECT_NEAR(filmTransmission(0), 0, 1e-12);
  for (const double degrees : {20.0, 60.0, 85.0}) {
    const double cosine = std::cos(radians(degrees));
    const double in = (1 - fresnel(cosine, 1.328)) / (1 - fresnel(1, 1.328));
    EXPECT_NEAR(filmTransmission(cosine), in * in, 1e-12) << degrees;
  }
}

}  // namespace
}  // namespace scanmill
