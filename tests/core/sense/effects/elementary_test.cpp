#include "sense/effects/elementary.h"

#include <limits>

namespace scanmill {
namespace {

TEST(Elementary, LogarithmAgreesWithTheLibrary) {
  for (double x = 1e-300; x < 1e300; x *= 1.7) EXPECT_NEAR(naturalLog(x) / std::log(x), 1, 1e-13) << x;
  for (int k = 1; k < 2000; ++k) {
    const double x = k * 0.001;
    EXPECT_NEAR(naturalLog(x), std::log(x), 1e-14 * std::abs(std::log(x)) + 1e-16) << x;
  }
  for (double distance = 0x1p-33; distance < 0.5; distance *= 2) {
    EXPECT_NEAR(naturalLog(1 - distance) / std::log(1 - distance), 1, 1e-13);
  }
  EXPECT_EQ(naturalLog(1), 0);
}

TEST(Elementary, ExponentialAgreesWithTheLibraryAndStaysFinite) {
  for (double x = -700; x <= 700; x += 0.37) EXPECT_NEAR(exponential(x) / std::exp(x), 1, 1e-13) << x;
  EXPECT_EQ(exponential(0), 1);
  EXPECT_EQ(exponential(-std::numeric_limits<double>::infinity()), exponential(-700));
  EXPECT_EQ(exponential(std::numeric_limits<double>::infinity()), exponential(700));
}

TEST(Elementary, SinesAndCosinesOfSmallAngles) {
  for (double a = -kPi / 4; a <= kPi / 4; a += 1e-3) {
    const SinCos v = sinCosSmall(a);
    EXPECT_NEAR(v.sin, std::sin(a), 3e-16);
    EXPECT_NEAR(v.cos, std::cos(a), 3e-16);
  }
}

TEST(Elementary, RandomAnglesCoverTheCircleEvenly) {
  for (std::uint64_t bits = 0; bits < (1ull << 32); bits += 0x00FEDCB1) {
    const SinCos v = sinCosRandom(static_cast<std::uint32_t>(bits));
    const double angle = (static_cast<double>(bits) + 0.5 - 0x1p31) * (2 * kPi * 0x1p-32);
    EXPECT_NEAR(v.sin, std::sin(angle), 2e-15);
    EXPECT_NEAR(v.cos, std::cos(angle), 2e-15);
  }
}

TEST(Elementary, IntegersBecomeDoublesExactly) {
  for (std::uint32_t bits : {0u, 1u, 0x7FFFFFFFu, 0x80000000u, 0xFFFFFFFFu})
    EXPECT_EQ(toDouble(bits), static_cast<double>(bits));
}

}  // namespace
}  // namespace scanmill
