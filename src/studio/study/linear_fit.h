#pragma once

// Linear least squares.

#include <cstddef>
#include <span>
#include <vector>

namespace scanmill {

// The result of fitting design * coefficients = values. Columns of the design that are linear combinations of earlier
// columns are left out: their coefficients are zero.
struct LinearFit {
  std::vector<double> coefficients;
  std::vector<double> residuals;
  // The leverage of each row: the weight of its own value in its fitted value. The variance of a residual is (1 -
  // leverage) times the variance of the value.
  std::vector<double> leverages;
  double squares = 0;    // sum of the residuals' squares
  std::size_t rank = 0;  // number of columns not left out

  // Returns the degrees of freedom, the number of values less the rank: squares / freedom is an unbiased estimate of
  // the values' variance.
  std::size_t freedom() const { return residuals.size() - rank; }
};

// Fits by least squares. The design is given row by row; `columns` is the length of a row.
LinearFit fitLinear(std::span<const double> design, std::size_t columns, std::span<const double> values);

}  // namespace scanmill
