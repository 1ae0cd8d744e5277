#include "evaluate/roc.h"

#include <gtest/gtest.h>

#include <random>

namespace scanmill {
namespace {

TEST(RocArea, IsTheShareOfPairsWithTheGreaterOfTheSecond) {
  EXPECT_EQ(rocArea({1, 2, 3}, {4, 5}), 1);
  EXPECT_EQ(rocArea({4, 5}, {1, 2, 3}), 0);
  EXPECT_EQ(rocArea({1, 3}, {2, 4}), 0.75);  // of four pairs three
  EXPECT_EQ(rocArea({7}, {7}), 0.5);
  EXPECT_NEAR(rocArea({0, 0, 1}, {0, 1, 1}), 6 / 9.0, 1e-12);  // ties count half
}

TEST(RocArea, OfASetAgainstItselfIsAHalf) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> few(0, 9);  // many ties
  std::vector<float> values;
  for (int i = 0; i < 1001; ++i) values.push_back(static_cast<float>(few(random)));
  EXPECT_EQ(rocArea(values, values), 0.5);
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
}

}  // namespace
}  // namespace scanmill
