#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace scanmill {

// Appends those lines of `from` that `to` does not hold yet, in their order.
inline void appendNew(const std::vector<std::string>& from, std::vector<std::string>& to) {
  for (const std::string& line : from) {
    if (std::find(to.begin(), to.end(), line) == to.end()) to.push_back(line);
  }
}

}  // namespace scanmill
