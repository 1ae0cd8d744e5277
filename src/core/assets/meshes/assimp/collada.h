#pragma once

// What the assimp library does not report of a COLLADA file (.dae; COLLADA 1.4.1 and 1.5).

#include <filesystem>
#include <set>
#include <string>

#include "base/format_support.h"

namespace scanmill {

const FormatSupport& colladaFormat();

struct ColladaFacts {
  char up = 'y';                 // axis of `up_axis`
  double unit = 0;               // metres per unit; 0: not stated
  std::set<std::string> hidden;  // ids of nodes with `visibility` 0, which Maya and 3ds Max write
  LeftOut leftOut;
};

// Finds the facts in the file's text, without checking the file. They remain unknown in a compressed file (.zae).
ColladaFacts colladaFacts(const std::filesystem::path& file);

}  // namespace scanmill
