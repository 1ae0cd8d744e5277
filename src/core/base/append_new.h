#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace scanmill {

// Appends the lines of `added` that `lines` does not have yet, in their order.
inline void appendNew(const std::vector<std::string>& added, std::vector<std::string>& lines) {
  for (const std::string& line : added) {
    if (std::ranges::find(lines, line) == lines.end()) lines.push_back(line);
  }
}

}  // namespace scanmill
