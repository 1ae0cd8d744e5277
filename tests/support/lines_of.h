#pragma once

#include <string>
#include <vector>

#include "scan/modelled_item.h"

namespace scanmill {

// Returns a line for each item that is modelled or left out.
inline std::vector<std::string> linesOf(const std::vector<ModelledItem>& items) {
  std::vector<std::string> lines;
  for (const ModelledItem& item : items) lines.push_back(lineOf(item));
  return lines;
}

}  // namespace scanmill
