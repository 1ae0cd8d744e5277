#pragma once

// Functions that add a class to the extension module.

#include <pybind11/pybind11.h>

namespace scanmill {

// PassRecorder writes images of depth cameras as a recording of passes.
void definePassRecorder(pybind11::module_& module);

// Simulator: see python/simulator.h.
void defineSimulator(pybind11::module_& module);

}  // namespace scanmill
