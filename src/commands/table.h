#pragma once

#include <string>
#include <vector>

namespace scanmill {

// Rows of cells in aligned columns, the first row a heading. Columns whose cells all look like numbers are
// right-aligned.
std::string formatTable(const std::vector<std::vector<std::string>>& rows);

// "12.3 %"
std::string percent(double part, double whole);

}  // namespace scanmill
