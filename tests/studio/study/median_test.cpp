#include "study/median.h"

#include <gtest/gtest.h>

#include <cmath>

namespace scanmill {
namespace {

TEST(Median, IsTheUpperOneOfTheMiddleTwo) {
  EXPECT_EQ(medianOf(std::vector<double>{3, 1, 2}), 2);
  EXPECT_EQ(medianOf(std::vector<float>{4, 1, 3, 2}), 3);
  EXPECT_EQ(medianOf(std::vector<double>{}), 0);
  EXPECT_TRUE(std::isnan(medianOf(std::vector<float>{}, NAN)));
}

}  // namespace
}  // namespace scanmill
