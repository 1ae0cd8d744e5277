#include "town/relief.h"

#include <cmath>

namespace scanmill::town {
namespace {

// Returns a hash of 64 bits by SplitMix64's finaliser (Steele, Lea and Flood, "Fast splittable pseudorandom number
// generators", OOPSLA 2014).
std::uint64_t mixed(std::uint64_t v) {
  v = (v ^ (v >> 30)) * 0xBF58476D1CE4E5B9u;
  v = (v ^ (v >> 27)) * 0x94D049BB133111EBu;
  return v ^ (v >> 31);
}

// Returns the dot product of the gradient (a unit vector) at the lattice's corner (ix, iy) and the offset (dx, dy).
double sloped(std::uint64_t lattice, std::int64_t ix, std::int64_t iy, double dx, double dy) {
  // The sines and cosines of 22.5 and 45 degrees.
  constexpr double kSin = 0.38268343236508977, kCos = 0.92387953251128674, kHalf = 0.70710678118654752;
  static constexpr double kGradients[16][2] = {{1, 0},  {kCos, kSin},   {kHalf, kHalf},   {kSin, kCos},
                                               {0, 1},  {-kSin, kCos},  {-kHalf, kHalf},  {-kCos, kSin},
                                               {-1, 0}, {-kCos, -kSin}, {-kHalf, -kHalf}, {-kSin, -kCos},
                                               {0, -1}, {kSin, -kCos},  {kHalf, -kHalf},  {kCos, -kSin}};
  const std::uint64_t key = lattice + 0x9E3779B97F4A7C15u * static_cast<std::uint64_t>(ix) +
                            0xD1B54A32D192ED03u * static_cast<std::uint64_t>(iy);
  const double* const g = kGradients[mixed(key) >> 60];
  return g[0] * dx + g[1] * dy;
}

// Returns the quintic smoothstep, as in Perlin's improved noise, of `t` between 0 and 1.
double faded(double t) {
  return t * t * t * (t * (t * 6 - 15) + 10);
}

}  // namespace

double relief(const FieldAddress& address, double x, double y, double size) {
  // Two rounds of mixing make the lattices of different addresses independent.
  const std::uint64_t lattice = mixed(
      mixed(address.seed + 1) ^ (std::uint64_t{address.number} << 32 | static_cast<std::uint32_t>(address.field)));
  const double u = x / size;
  const double v = y / size;
  const double fu = std::floor(u);
  const double fv = std::floor(v);
  const auto ix = static_cast<std::int64_t>(fu);
  const auto iy = static_cast<std::int64_t>(fv);
  const double dx = u - fu;
  const double dy = v - fv;
  const double a = sloped(lattice, ix, iy, dx, dy);
  const double b = sloped(lattice, ix + 1, iy, dx - 1, dy);
  const double c = sloped(lattice, ix, iy + 1, dx, dy - 1);
  const double d = sloped(lattice, ix + 1, iy + 1, dx - 1, dy - 1);
  const double s = faded(dx);
  const double low = a + (b - a) * s;
  const double high = c + (d - c) * s;
  constexpr double kSqrtTwo = 1.4142135623730951;  // scales the largest value, which is at a cell's centre, to 1
  return (low + (high - low) * faded(dy)) * kSqrtTwo;
}

}  // namespace scanmill::town
