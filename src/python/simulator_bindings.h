#pragma once

#include <pybind11/pybind11.h>

namespace scanmill {

// Adds the class Simulator (python/simulator.h) to the extension module.
void defineSimulator(pybind11::module_& module);

}  // namespace scanmill
