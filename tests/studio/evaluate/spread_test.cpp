#include "evaluate/spread.h"

#include <random>

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

TEST(RocArea, IsTheShareOfPairsWithTheGreaterOfTheSecond) {
  EXPECT_EQ(rocArea({1, 2, 3}, {4, 5}), 1);
  EXPECT_EQ(rocArea({4, 5}, {1, 2, 3}), 0);
  EXPECT_EQ(rocArea({1, 3}, {2, 4}), 0.75);  // of four pairs three
  EXPECT_EQ(rocArea({7}, {7}), 0.5);
  EXPECT_NEAR(rocArea({0, 0, 1}, {0, 1, 1}), 6 / 9.0, 1e-12);  // ties count half
}

// Two normal laws of deviation 1, d apart: the area is Phi(d / sqrt 2).
TEST(RocArea, OfNormalLawsFollowsTheirDistance) {
  std::mt19937 random(4);
  std::normal_distribution<float> first(0, 1), second(1, 1);
  std::vector<float> a, b;
  for (int i = 0; i < 20000; ++i) {
    a.push_back(first(random));
    b.push_back(second(random));
  }
  EXPECT_NEAR(rocArea(a, b), 0.5 * std::erfc(-0.5), 0.01);
  EXPECT_NEAR(rocArea(b, a) + rocArea(a, b), 1, 1e-12);
  EXPECT_EQ(rocArea(a, a), 0.5);
}

TEST(Median, IsTheUpperOneOfTheMiddleTwo) {
  EXPECT_EQ(medianOf(std::vector<double>{3, 1, 2}), 2);
  EXPECT_EQ(medianOf(std::vector<float>{4, 1, 3, 2}), 3);
  EXPECT_EQ(medianOf(std::vector<double>{}), 0);
  EXPECT_TRUE(std::isnan(medianOf(std::vector<float>{}, NAN)));
}

}  // namespace
}  // namespace scanmill
