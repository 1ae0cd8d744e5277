#pragma once

#include <memory>
#include <string>

#include "base/error.h"
#include "passes/renderer.h"

namespace scanmill {

// Null where this machine has no OpenGL 4.3 by EGL.
inline std::unique_ptr<PassRenderer> vtkRendererOf(const Scene& scene) {
  try {
    return makeVtkRenderer(scene);
  } catch (const Error& e) {
    if (std::string(e.what()).find("no OpenGL 4.3") == std::string::npos) throw;
    return nullptr;
  }
}

inline bool hasGl() {
  const Scene empty;
  return vtkRendererOf(empty) != nullptr;
}

}  // namespace scanmill

#define SKIP_WITHOUT_GL() \
  if (!hasGl()) GTEST_SKIP() << "this machine has no OpenGL 4.3 by EGL"
