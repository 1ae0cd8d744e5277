#pragma once

#include <string>
#include <vector>

#include "viewer/canvas/canvas_module.h"

namespace scanmill {

// The module, loaded at the first call from the first of the program's library folders that has it. Throws Error; the
// next call tries again.
const ScanmillCanvasModule& canvasModule();

// Loads it from the first of `folders` that has it.
const ScanmillCanvasModule& loadCanvasModule(const std::vector<std::string>& folders);

}  // namespace scanmill
