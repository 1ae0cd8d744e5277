#pragma once

#include <string>
#include <vector>

#include "images/module.h"

namespace scanmill {

// The module, loaded at the first call, from any thread, from the first of the program's library folders that has it
// (its RUNPATH, in which the build and the installation name theirs). Throws Error; the next call tries again.
const ScanmillImagesModule& imagesModule();

// Loads it from the first of `folders` that has it.
const ScanmillImagesModule& loadImagesModule(const std::vector<std::string>& folders);

}  // namespace scanmill
