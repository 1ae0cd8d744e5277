#pragma once

// Elementary functions that use only additions, multiplications, divisions and bit operations, without branches. They
// return the same bits on every machine, whereas mathematical libraries differ in the last bit. With -fno-math-errno
// and -fno-trapping-math, loops that call them are vectorised, and then three to six times as fast.

#include <bit>
#include <cstdint>

#include "base/vec.h"

namespace scanmill {

struct SinCos {
  double sin, cos;
};

// Returns sine and cosine of `a` (rad), which must be from -pi / 4 to pi / 4, by Taylor series to the 15th and 16th
// power; errors are below 3e-16.
inline SinCos sinCosSmall(double a) {
  const double z = a * a;
  const double sinTail =
      z * (-1.0 / 6 +
           z * (1.0 / 120 +
                z * (-1.0 / 5040 + z * (1.0 / 362880 +
                                        z * (-1.0 / 39916800 + z * (1.0 / 6227020800 + z * (-1.0 / 1307674368000)))))));
  const double cosTail =
      z * (-0.5 +
           z * (1.0 / 24 +
                z * (-1.0 / 720 + z * (1.0 / 40320 + z * (-1.0 / 3628800 +
                                                          z * (1.0 / 479001600 + z * (-1.0 / 87178291200 +
                                                                                      z * (1.0 / 20922789888000))))))));
  return {a + a * sinTail, 1.0 + cosTail};
}

// The bits of 2^52. Or-ing an integer below 2^52 into them gives 2^52 plus this integer.
constexpr std::uint64_t kBitsOf2To52 = 0x4330000000000000u;
// Returns `bits` as a double, exactly: the bits become the mantissa of a number between 2^52 and 2^53.
inline double toDouble(std::uint32_t bits) {
  return std::bit_cast<double>(kBitsOf2To52 | bits) - 0x1p52;
}

// Returns sine and cosine of a random angle of the full circle, from 32 random bits: computes sine and cosine of a
// quarter of the angle and doubles this angle twice, which avoids a case for each quadrant.
inline SinCos sinCosRandom(std::uint32_t bits) {
  const SinCos quarter = sinCosSmall((toDouble(bits) + (0.5 - 0x1p31)) * (kPi * 0x1p-33));
  const SinCos half{2 * quarter.sin * quarter.cos, 1 - 2 * quarter.sin * quarter.sin};
  return {2 * half.sin * half.cos, 1 - 2 * half.sin * half.sin};
}

// Returns the natural logarithm of `x`, which must be a positive normal number. With x = 2^k m and m in [sqrt(1/2),
// sqrt(2)), log m = 2 artanh((m - 1) / (m + 1)), by the series of Abramowitz and Stegun, 4.1.27, to the 19th power;
// relative errors are below 1e-14.
inline double naturalLog(double x) {
  constexpr std::uint64_t kSqrtHalf = 0x3FE6A09E667F3BCDu;  // bits of sqrt(1/2)
  constexpr std::uint64_t kBias = 1023;
  // Subtracting the bits of sqrt(1/2) makes the exponent change at sqrt(1/2) instead of 1.
  const std::uint64_t shifted = std::bit_cast<std::uint64_t>(x) - kSqrtHalf + (kBias << 52);
  const double k = std::bit_cast<double>(kBitsOf2To52 | (shifted >> 52)) - (0x1p52 + kBias);
  const double m = std::bit_cast<double>((shifted & 0x000FFFFFFFFFFFFFu) + kSqrtHalf);
  const double s = (m - 1) / (m + 1);
  const double z = s * s;
  const double tail =
      z *
      (1.0 / 3 +
       z * (1.0 / 5 +
            z * (1.0 / 7 +
                 z * (1.0 / 9 + z * (1.0 / 11 + z * (1.0 / 13 + z * (1.0 / 15 + z * (1.0 / 17 + z * (1.0 / 19)))))))));
  return k * 0.693147180559945309417 + 2 * (s + s * tail);
}

// Returns exp(x), with `x` clamped to -700 to 700. exp(x) = 2^k exp(f) with |f| <= log(2) / 2, by the Taylor series to
// the 12th power; relative errors are below 1e-13.
inline double exponential(double x) {
  constexpr double kLog2High = 0x1.62e42feep-1;  // upper bits of log(2); their product with k is exact
  constexpr double kLog2Low = 1.90821492927058770002e-10;
  x = x > -700 ? x : -700;
  x = x < 700 ? x : 700;
  const double shifted = x * 1.44269504088896340736 + 0x1.8p52;  // its last bits are the integer nearest to x / log(2)
  const double k = shifted - 0x1.8p52;
  const double f = (x - k * kLog2High) - k * kLog2Low;
  double series = 1.0 + f * (1.0 / 12);
  series = 1.0 + f * (1.0 / 11) * series;
  series = 1.0 + f * (1.0 / 10) * series;
  series = 1.0 + f * (1.0 / 9) * series;
  series = 1.0 + f * (1.0 / 8) * series;
  series = 1.0 + f * (1.0 / 7) * series;
  series = 1.0 + f * (1.0 / 6) * series;
  series = 1.0 + f * (1.0 / 5) * series;
  series = 1.0 + f * (1.0 / 4) * series;
  series = 1.0 + f * (1.0 / 3) * series;
  series = 1.0 + f * (1.0 / 2) * series;
  series = 1.0 + f * series;
  const double power = std::bit_cast<double>(std::bit_cast<std::uint64_t>(k + (0x1p52 + 1023)) << 52);
  return power * series;
}

}  // namespace scanmill
