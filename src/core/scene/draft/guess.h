#pragma once

// Guesses what an asset is, by its names and its shape.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "scene/assets/asset.h"
#include "scene/draft/words.h"

namespace scanmill::draft {

// What each part of an asset is, in the order of the parts; null where no word tells. The glass of a car is the car's,
// and a file or folder tells where node, material and texture do not.
std::vector<const Concept*> guessParts(const std::vector<Concept>& concepts, const Asset& asset);

// What the file's own name or its folders' say; null where they say nothing.
const Concept* conceptOfFile(const std::vector<Concept>& concepts, const std::filesystem::path& file);

struct FrameGuess {
  char up = 'z';
  std::string whyUp;  // in words; empty where the file or its kind says it
  double unit = 1;    // m
  std::string whyUnit;
};

// `asset` was read with the unit 1 and no axis asked for.
FrameGuess guessFrame(const Asset& asset, const std::vector<const Concept*>& parts);

}  // namespace scanmill::draft
