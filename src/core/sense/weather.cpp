#include "sense/weather.h"

#include "base/vec.h"
#include "methods/interface/light_paths.h"
#include "sense/effects/elementary.h"

namespace scanmill {

namespace {

constexpr double kWaterIndex = 1.328;
constexpr double kLargeDrops = 2;           // extinction cross section of a drop, relative to its area
constexpr double kFlakeDensity = 0.1;       // density of a snowflake, relative to water
constexpr double kIceLidarRatio = 25;       // sr, extinction over backscatter
constexpr double kFogLidarRatio = 18.8;     // sr, extinction over backscatter
constexpr double kDustLidarRatio = 50;      // sr, extinction over backscatter
constexpr double kSquareMillimetre = 1e-6;  // m^2 per mm^2

double power(double base, double exponent) {
  return exponential(exponent * naturalLog(base));
}

// Returns the properties of fog or dust. The visibility (m) is the distance at which 5 % of the contrast remains
// (Koschmieder). `lidarRatio`: extinction over backscatter (sr).
Weather hazeOf(double visibility, double lidarRatio) {
  const double extinction = -naturalLog(0.05) / visibility;
  return {.extinction = extinction, .backscatter = extinction / lidarRatio};
}

}  // namespace

double DropSizes::above(double diameter) const {
  return intercept / slope * exponential(-slope * diameter);
}

DropSizes rainDrops(double rate) {
  return {8000, 4.1 * power(rate, -0.21)};
}

DropSizes snowFlakes(double rate) {
  return {3800 * power(rate, -0.87), 2.55 * power(rate, -0.48)};
}

Weather rainOf(double rate) {
  Weather rain;
  rain.drops = rainDrops(rate);
  rain.extinction = kLargeDrops * kPi / 4 * rain.drops.squares() * kSquareMillimetre;
  const double reflectedOnce = fresnel(1, kWaterIndex);
  const double focus = kWaterIndex / (2 - kWaterIndex);
  // `gain` is the bracket in the formula of weather.h: the reflection of the front face, plus the reflection of the
  // back face, which the front face focuses.
  const double gain = reflectedOnce + (1 - reflectedOnce) * (1 - reflectedOnce) * reflectedOnce * focus * focus;
  // The echo is pi times the backscatter per steradian, gain a^2 / 4 with the radius a = D / 2, for D = 1 mm.
  rain.dropEcho = kPi * gain / 16 * kSquareMillimetre;
  return rain;
}

Weather snowOf(double rate) {
  Weather snow;
  snow.drops = snowFlakes(rate);
  const double width = power(1 / kFlakeDensity, 1.0 / 3);  // width of a flake, relative to the drop that it melts into
  snow.extinction = kLargeDrops * kPi / 4 * width * width * snow.drops.squares() * kSquareMillimetre;
  // The echo is pi times the flake's extinction cross section over the lidar ratio, for D = 1 mm. The cross section is
  // twice the area of a disc with the radius width * D / 2.
  snow.dropEcho = kPi * kLargeDrops * kPi / kIceLidarRatio * width * width / 4 * kSquareMillimetre;
  return snow;
}

Weather fogOf(double visibility) {
  return hazeOf(visibility, kFogLidarRatio);
}

Weather dustOf(double visibility) {
  return hazeOf(visibility, kDustLidarRatio);
}

double mistEcho(const Weather& weather, double length) {
  return kPi * weather.backscatter * length;
}

double dampness(double reflectance) {
  return 1 / (kWaterIndex * kWaterIndex * (1 - reflectance) + reflectance);
}

double filmTransmission(double cosine) {
  const double oneWay = (1 - fresnel(cosine, kWaterIndex)) / (1 - fresnel(1, kWaterIndex));
  return oneWay * oneWay;
}

}  // namespace scanmill
