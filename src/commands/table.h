#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace scanmill {

using Rows = std::vector<std::vector<std::string>>;

// Formats rows of cells in aligned columns; the first row is the heading. Columns are right-aligned if all cells below
// the heading look like numbers. All rows must have as many cells as the first.
std::string formatTable(const Rows& cells);

// Returns `part` as a percentage of `total`, such as "12.30 %"; "0.00 %" if `total` is 0.
std::string percent(std::uint64_t part, std::uint64_t total);

}  // namespace scanmill
