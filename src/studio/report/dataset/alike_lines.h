#pragma once

#include <string>
#include <vector>

namespace scanmill {

// Merges lines that differ only in their numbers into one, at the position of the first: the names "Bauble.001" to
// "Bauble.050" become "Bauble (50)", and "277 objects" and "294 objects" become "277 to 294 objects (2 times)". Equal
// lines are kept once.
std::vector<std::string> alikeLines(const std::vector<std::string>& lines);

}  // namespace scanmill
