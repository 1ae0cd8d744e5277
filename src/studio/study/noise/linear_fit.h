#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace scanmill {

// Least squares: design * coefficients = values, the design given row by row. Columns that depend on those before them
// are left out: their coefficients are zero.
struct LinearFit {
  std::vector<double> coefficients;
  std::vector<double> residuals;
  // Per row: the share of its own value that the fit follows. A residual's variance is (1 - leverage) of a value's.
  std::vector<double> leverages;
  double squares = 0;    // sum of the residuals' squares
  std::size_t rank = 0;  // columns that count

  // Values beyond those that determine the coefficients: squares / freedom is their variance, without bias.
  std::size_t freedom() const { return residuals.size() - rank; }
};

LinearFit fitLinear(std::span<const double> design, std::size_t columns, std::span<const double> values);

}  // namespace scanmill
