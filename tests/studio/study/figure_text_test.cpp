#include "study/figure_text.h"

namespace scanmill {
namespace {

TEST(FigureText, IsReadable) {
  EXPECT_EQ(metresText(0), "0");
  EXPECT_EQ(metresText(0.0464), "46.4 mm");
  EXPECT_EQ(metresText(3e-7), "< 1 \xC2\xB5m");
  EXPECT_EQ(metresText(0.9999), "1 m");
  EXPECT_EQ(metresText(12.34), "12.3 m");
  EXPECT_EQ(secondsText(0.0054), "5.4 ms");
  EXPECT_EQ(secondsText(3.5e-5), "35 \xC2\xB5s");
  EXPECT_EQ(shareText(1), "100 %");
  EXPECT_EQ(shareText(0), "0 %");
  EXPECT_EQ(shareText(0.5), "50.0 %");
  EXPECT_EQ(shareText(0.98451), "98.5 %");
  EXPECT_EQ(shareText(0.999991), "99.99910 %");
  EXPECT_EQ(shareText(1 - 1e-9), "above 99.99999 %");
  EXPECT_EQ(shareText(7e-4), "0.070 %");
  EXPECT_EQ(factorText(2.14), "2.1");
  EXPECT_EQ(factorText(26.6), "27");
  EXPECT_EQ(factorText(0.346), "0.35");
}

}  // namespace
}  // namespace scanmill
