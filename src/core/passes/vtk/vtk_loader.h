#pragma once

#include <string>
#include <vector>

#include "passes/vtk/vtk_module.h"

namespace scanmill {

// The module, loaded at the first call, from any thread, from the first of the program's library folders that has it.
// Throws Error; the next call tries again.
const ScanmillVtkModule& vtkModule();

// Loads it from the first of `folders` that has it.
const ScanmillVtkModule& loadVtkModule(const std::vector<std::string>& folders);

}  // namespace scanmill
