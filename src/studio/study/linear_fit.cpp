#include "study/linear_fit.h"

#include <cmath>
#include <numeric>
#include <utility>

namespace scanmill {

namespace {

double innerProduct(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

void addMultiple(double factor, const std::vector<double>& added, std::vector<double>& sum) {
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += factor * added[i];
}

}  // namespace

// Decomposes design = q r, where the columns of q are orthonormal and r is an upper triangular matrix. Applies the
// Gram-Schmidt process twice to each column, which is enough to make columns orthogonal up to rounding errors (Giraud,
// Langou, Rozloznik, "The loss of orthogonality in the Gram-Schmidt orthogonalization process", 2005).
LinearFit fitLinear(std::span<const double> design, std::size_t columns, std::span<const double> values) {
  constexpr double kDependent = 1e-9;  // a column is not used if a smaller fraction of it is independent
  const std::size_t rows = values.size();
  std::vector<std::vector<double>> q(columns);    // orthonormal columns; empty for dependent columns
  std::vector<double> r(columns * columns, 0.0);  // row by row
  std::vector<double> projections(columns, 0.0);  // projections of the values onto the columns of q
  LinearFit fit;
  fit.residuals.assign(values.begin(), values.end());
  fit.leverages.assign(rows, 0.0);
  fit.coefficients.assign(columns, 0.0);
  for (std::size_t c = 0; c < columns; ++c) {
    std::vector<double> column(rows);
    for (std::size_t i = 0; i < rows; ++i) column[i] = design[i * columns + c];
    const double length = std::sqrt(innerProduct(column, column));
    for (int pass = 0; pass < 2; ++pass) {
      for (std::size_t earlier = 0; earlier < c; ++earlier) {
        if (q[earlier].empty()) continue;
        const double projection = innerProduct(q[earlier], column);
        r[earlier * columns + c] += projection;
        addMultiple(-projection, q[earlier], column);
      }
    }
    const double independentLength = std::sqrt(innerProduct(column, column));
    if (!(independentLength > kDependent * length) || fit.rank == rows) continue;
    ++fit.rank;
    r[c * columns + c] = independentLength;
    for (double& entry : column) entry /= independentLength;
    projections[c] = innerProduct(column, fit.residuals);
    addMultiple(-projections[c], column, fit.residuals);
    for (std::size_t i = 0; i < rows; ++i) fit.leverages[i] += column[i] * column[i];
    q[c] = std::move(column);
  }
  // Solve r * coefficients = projections from the last column to the first.
  for (std::size_t c = columns; c-- > 0;) {
    if (q[c].empty()) continue;
    double value = projections[c];
    for (std::size_t later = c + 1; later < columns; ++later) value -= r[c * columns + later] * fit.coefficients[later];
    fit.coefficients[c] = value / r[c * columns + c];
  }
  fit.squares = innerProduct(fit.residuals, fit.residuals);
  return fit;
}

}  // namespace scanmill
