#include "study/linear_fit.h"

namespace scanmill {
namespace {

TEST(FitLinear, LeavesOutWhatDependsOnOthers) {
  // Value = 3 + 2 x; the third column is the sum of the others.
  std::vector<double> design;
  std::vector<double> values;
  for (int x = 0; x < 6; ++x) {
    design.insert(design.end(), {1, double(x), double(x + 1)});
    values.push_back(3 + 2 * x + (x % 2 == 0 ? 0.5 : -0.5));
  }
  const LinearFit fit = fitLinear(design, 3, values);
  EXPECT_EQ(fit.rank, 2u);
  EXPECT_EQ(fit.freedom(), 4);
  EXPECT_EQ(fit.coefficients[2], 0);
  // By hand: slope = sum (x - 2.5)(y - mean) / 17.5 = 2 - 1.5 / 17.5.
  EXPECT_NEAR(fit.coefficients[1], 2 - 1.5 / 17.5, 1e-12);
  EXPECT_NEAR(fit.coefficients[0], 8 - 2.5 * fit.coefficients[1], 1e-12);
  double leverages = 0;
  for (const double l : fit.leverages) leverages += l;
  EXPECT_NEAR(leverages, 2, 1e-12);
}

}  // namespace
}  // namespace scanmill
