#pragma once

#include <pybind11/pybind11.h>

namespace scanmill {

// Adds the class PassRecorder to the extension module: it writes images of depth cameras as a recording of passes.
void definePassRecorder(pybind11::module_& module);

}  // namespace scanmill
