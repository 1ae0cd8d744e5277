#pragma once

// Reads scans from NumPy's archives (numpy.org/doc/stable/reference/generated/numpy.lib.format.html).

#include <string>
#include <string_view>

#include "scan/scan.h"

namespace scanmill {

// The positions are the array `xyz` or `points`, of shape (N, 3) or (rings, columns, 3), the latter with misses as NaN;
// further numbers of a point, as in (N, 4), are its intensity and its ring. An array of the same shape without the last
// dimension is the column of its name; those that the table of columns does not have are kept as foreign columns, and
// `labels`, `classes` and `semantic` are taken for `label`. All else is left out. Throws an InputError that begins with
// `what`: no ZIP archive, an array that is damaged, in Fortran's order, big-endian or of no number, or no positions.
Scan readNpz(std::string_view bytes, const std::string& what);

}  // namespace scanmill
