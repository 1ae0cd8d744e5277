#pragma once

#include <string>
#include <vector>

namespace scanmill {

// Lines that differ in nothing but their numbers become one, in the place of the first: the names "Bauble.001" to
// "Bauble.050" are "Bauble (50)", and "277 objects" and "294 objects" are "277 to 294 objects (2 times)". Lines that
// are equal stay once.
std::vector<std::string> alikeLines(const std::vector<std::string>& lines);

}  // namespace scanmill
