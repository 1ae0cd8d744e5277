#pragma once

#include <string>

#include "base/error.h"
#include "gpu/compute.h"

namespace scanmill {

// Whether this machine has OpenGL 4.3 by EGL.
inline bool hasGl() {
  try {
    ComputeDevice({"tests cannot compute", "do without it"});
    return true;
  } catch (const Error& e) {
    if (std::string(e.what()).find("no OpenGL 4.3") == std::string::npos) throw;
    return false;
  }
}

}  // namespace scanmill

#define SKIP_WITHOUT_GL() \
  if (!hasGl()) GTEST_SKIP() << "this machine has no OpenGL 4.3 by EGL"
