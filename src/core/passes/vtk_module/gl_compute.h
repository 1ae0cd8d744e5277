#pragma once

// Compute shaders on an OpenGL context of our own, without VTK.

#include "passes/vtk/vtk_module.h"

namespace scanmill {

extern const ScanmillComputeFunctions kComputeFunctions;

}  // namespace scanmill
