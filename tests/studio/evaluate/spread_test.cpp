#include "evaluate/spread.h"

#include <gtest/gtest.h>

#include <cmath>

namespace scanmill {
namespace {

TEST(Spread, OfTheFirstThousandNumbers) {
  std::vector<double> values;
  for (int i = 1000; i >= 1; --i) values.push_back(i);
  const Spread s = spreadOf(values);
  EXPECT_EQ(s.count, 1000u);
  EXPECT_DOUBLE_EQ(s.mean, 500.5);
  EXPECT_NEAR(s.rms, std::sqrt(1001.0 * 2001 / 6), 1e-9);
  EXPECT_EQ(s.median, 500);
  EXPECT_EQ(s.p95, 950);
  EXPECT_EQ(s.p99, 990);
  EXPECT_EQ(s.p999, 999);
  EXPECT_EQ(s.max, 1000);
}

TEST(Spread, OfOneAndOfNone) {
  const Spread one = spreadOf({3});
  EXPECT_EQ(one.median, 3);
  EXPECT_EQ(one.p999, 3);
  EXPECT_EQ(one.rms, 3);
  EXPECT_EQ(spreadOf({}).count, 0u);
  EXPECT_EQ(spreadOf({}).max, 0);
}

}  // namespace
}  // namespace scanmill
