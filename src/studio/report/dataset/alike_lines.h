#pragma once

#include <string>
#include <vector>

namespace scanmill {

// Merges lines that are equal except for their numbers into one line, at the position of the first. For instance, the
// names "Bauble.001" to "Bauble.050" become "Bauble (50)", and "277 objects" and "294 objects" become "277 to 294
// objects (2 times)". Repetitions of a line are removed first and not counted.
std::vector<std::string> alikeLines(const std::vector<std::string>& lines);

}  // namespace scanmill
