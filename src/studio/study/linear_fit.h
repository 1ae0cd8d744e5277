#pragma once

// Linear least squares.

#include <cstddef>
#include <span>
#include <vector>

namespace scanmill {

// The result of fitting design * coefficients = values. Columns of the design that depend on columns before them are
// left out: their coefficients are zero.
struct LinearFit {
  std::vector<double> coefficients;
  std::vector<double> residuals;
  // For each row the share of its own value that the fit follows. A residual's variance is (1 - leverage) times that of
  // the value.
  std::vector<double> leverages;
  double squares = 0;    // sum of the residuals' squares
  std::size_t rank = 0;  // columns that are not left out

  // The number of values beyond those that determine the coefficients: squares / freedom is the values' variance,
  // without bias.
  std::size_t freedom() const { return residuals.size() - rank; }
};

// Fits by least squares. The design is given row by row, with so many columns.
LinearFit fitLinear(std::span<const double> design, std::size_t columns, std::span<const double> values);

}  // namespace scanmill
