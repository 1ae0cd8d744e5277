#pragma once

// Fits linear models by least squares.

#include <cstddef>
#include <span>
#include <vector>

namespace scanmill {

// The result of fitting design * coefficients = values. Columns of the design that are linear combinations of earlier
// columns are not used; their coefficients are zero.
struct LinearFit {
  std::vector<double> coefficients, residuals;
  // The leverage of each row: the derivative of the row's fitted value with respect to the row's value. The variance of
  // a residual is (1 - leverage) times the variance of the value.
  std::vector<double> leverages;
  double squares = 0;    // sum of squared residuals
  std::size_t rank = 0;  // number of columns that are used

  // Returns the degrees of freedom: the number of values minus the rank. squares / freedom() is an unbiased estimate of
  // the values' variance.
  double freedom() const { return static_cast<double>(residuals.size() - rank); }
};

// Fits a linear model by least squares. `design`: row by row; each row has `columns` entries and belongs to one value.
LinearFit fitLinear(std::span<const double> design, std::size_t columns, std::span<const double> values);

}  // namespace scanmill
