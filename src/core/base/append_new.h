#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace scanmill {

// Appends the lines of `from` that are not yet in `to`, in their order.
inline void appendNew(const std::vector<std::string>& from, std::vector<std::string>& to) {
  for (const std::string& line : from) {
    if (std::find(to.begin(), to.end(), line) == to.end()) to.push_back(line);
  }
}

}  // namespace scanmill
