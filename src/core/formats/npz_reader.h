#pragma once

// Reads scans from NumPy's archives (numpy.org/doc/stable/reference/generated/numpy.lib.format.html).

#include <string>
#include <string_view>

#include "scan/scan.h"

namespace scanmill {

// Reads a scan. Its positions are the array `xyz` or `points`, of shape (N, 3) or (rings, columns, 3); misses of an
// array of the second shape are NaN. A fourth and a fifth number per point are intensity and ring. Every other array
// with one number per point becomes the column of its name: `label` if its name is `labels`, `classes` or `semantic`; a
// foreign column if the table of columns lacks the name. All other arrays are left out. Throws an InputError that
// begins with `what` if the bytes are not a ZIP archive, an array is damaged, in Fortran's order or big-endian, or the
// positions are missing or not numbers.
Scan readNpz(std::string_view bytes, const std::string& what);

}  // namespace scanmill
