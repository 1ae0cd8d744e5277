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

}  // namespace

double DropSizes::above(double diameter) const {
  return intercept / slope * exponential(-slope * diameter);
}

double DropSizes::squares() const {
  return 2 * intercept / (slope * slope * slope);
}

DropSizes rainDrops(double rate) {
  return {8000, 4.1 * power(rate, -0.21)};
}

DropSizes snowFlakes(double rate) {
  return {3800 * power(rate, -0.87), 2.55 * power(rate, -0.48)};
}

Weather rainOf(double rate) {
  Weather made;
  made.drops = rainDrops(rate);
  made.extinction = kLargeDrops * kPi / 4 * made.drops.squares() * kSquareMillimetre;
  const double face = fresnel(1, kWaterIndex);
  const double focus = kWaterIndex / (2 - kWaterIndex);
  const double gain = face + (1 - face) * (1 - face) * face * focus * focus;
  // pi times the drop's echo per steradian, which is gain a^2 / 4 for the radius a = D / 2.
  made.dropEcho = kPi * gain / 16 * kSquareMillimetre;
  return made;
}

Weather snowOf(double rate) {
  Weather made;
  made.drops = snowFlakes(rate);
  const double width = power(1 / kFlakeDensity, 1.0 / 3);  // width of a flake, relative to the drop that it melts into
  made.extinction = kLargeDrops * kPi / 4 * width * width * made.drops.squares() * kSquareMillimetre;
  // The echo is pi times the flake's extinction cross section over the lidar ratio, for D = 1. The cross section is
  // twice the area of a disc with the radius width * D / 2.
  made.dropEcho = kPi * kLargeDrops * kPi / kIceLidarRatio * width * width / 4 * kSquareMillimetre;
  return made;
}

Weather fogOf(double visibility) {
  Weather made;
  made.extinction = -naturalLog(0.05) / visibility;
  made.backscatter = made.extinction / kFogLidarRatio;
  return made;
}

Weather dustOf(double visibility) {
  Weather made;
  made.extinction = -naturalLog(0.05) / visibility;
  made.backscatter = made.extinction / kDustLidarRatio;
  return made;
}

double mistEcho(const Weather& weather, double length) {
  return kPi * weather.backscatter * length;
}

double dampness(double reflectance) {
  return 1 / (kWaterIndex * kWaterIndex * (1 - reflectance) + reflectance);
}

double filmTransmission(double cosine) {
  const double in = (1 - fresnel(cosine, kWaterIndex)) / (1 - fresnel(1, kWaterIndex));
  return in * in;
}

}  // namespace scanmill
