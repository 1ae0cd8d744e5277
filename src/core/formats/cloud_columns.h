#pragma once

// The names that other programs give the columns of point clouds.

#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/format_support.h"
#include "formats/cloud_file.h"
#include "scan/scan.h"

namespace scanmill {

// The names that mean the same are a row, whose first name is the column's. Names are in lower case, without
// CloudCompare's prefix `scalar_`. Unused names are columns that a scene has no use for.
const FormatSupport& cloudColumns();

// Returns the column that a name means ("label" for "scalar_Classification"); the name itself, in lower case and
// without `scalar_`, if it means no other.
std::string columnMeant(std::string_view name);

// Turns foreign columns into those columns of the table that their names mean and the scan lacks; an intensity column
// of zeros alone is replaced, too. Of several columns with one meaning the one with the column's own name is taken,
// else the first; the others stay foreign. Numbers of instances below 0 mean none: if there are any, the other numbers
// are counted from 1 on. The labels -1 and -100 become 0, or 65535 if the column has a 0, which may be a class. If a
// number does not fit the type, throws an InputError at `where` if the column has the column's own name and `where`
// names a file, else leaves the column foreign and says so in cloud.leftOut.
void adoptColumns(Cloud& cloud, const Location& where);

// Sets the positions of a scan to `exact` (m) and the cloud's origin to cloudOrigin() of the first finite one.
void setPositions(const std::vector<Vec3d>& exact, Cloud& cloud);

}  // namespace scanmill
