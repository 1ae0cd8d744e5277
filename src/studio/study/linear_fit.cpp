#include "study/linear_fit.h"

#include <cmath>

namespace scanmill {

// The implementation applies the Gram-Schmidt process twice to each column. This is enough to make columns orthogonal
// up to rounding errors (Giraud, Langou, Rozloznik, "The loss of orthogonality in the Gram-Schmidt orthogonalization
// process", 2005).
LinearFit fitLinear(std::span<const double> design, std::size_t columns, std::span<const double> values) {
  // A column is skipped if less than this fraction of its length is independent of earlier columns.
  constexpr double kDependent = 1e-9;
  const std::size_t rows = values.size();
  // design = q r, where the columns of q are orthonormal and r is an upper triangular matrix, row by row.
  std::vector<double> q(rows * columns);  // column by column
  std::vector<double> r(columns * columns, 0.0);
  std::vector<double> projection(columns, 0.0);
  std::vector<bool> used(columns, false);
  LinearFit fit;
  fit.residuals.assign(values.begin(), values.end());
  fit.leverages.assign(rows, 0.0);
  fit.coefficients.assign(columns, 0.0);

  const auto column = [&](std::size_t c) { return q.data() + c * rows; };
  const auto product = [&](const double* a, const double* b) {
    double sum = 0;
    for (std::size_t i = 0; i < rows; ++i) sum += a[i] * b[i];
    return sum;
  };
  for (std::size_t c = 0; c < columns; ++c) {
    double* const current = column(c);
    for (std::size_t i = 0; i < rows; ++i) current[i] = design[i * columns + c];
    const double length = std::sqrt(product(current, current));
    for (int pass = 0; pass < 2; ++pass) {
      for (std::size_t other = 0; other < c; ++other) {
        if (!used[other]) continue;
        const double* const axis = column(other);
        const double part = product(axis, current);
        r[other * columns + c] += part;
        for (std::size_t i = 0; i < rows; ++i) current[i] -= part * axis[i];
      }
    }
    const double independent = std::sqrt(product(current, current));
    if (!(independent > kDependent * length) || fit.rank == rows) continue;
    used[c] = true;
    ++fit.rank;
    r[c * columns + c] = independent;
    for (std::size_t i = 0; i < rows; ++i) current[i] /= independent;
    projection[c] = product(current, fit.residuals.data());
    for (std::size_t i = 0; i < rows; ++i) {
      fit.residuals[i] -= projection[c] * current[i];
      fit.leverages[i] += current[i] * current[i];
    }
  }
  for (std::size_t c = columns; c-- > 0;) {
    if (!used[c]) continue;
    double value = projection[c];
    for (std::size_t next = c + 1; next < columns; ++next) value -= r[c * columns + next] * fit.coefficients[next];
    fit.coefficients[c] = value / r[c * columns + c];
  }
  fit.squares = product(fit.residuals.data(), fit.residuals.data());
  return fit;
}

}  // namespace scanmill
