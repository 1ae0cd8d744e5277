#pragma once

#include <cstring>
#include <string>
#include <vector>

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

// A copy of a buffer's first values.
template <class T>
std::vector<T> copyOf(ComputeReadback& readback, const ComputeBuffer& buffer, std::size_t count) {
  readback.start(buffer, count * sizeof(T));
  std::vector<T> values(count);
  std::memcpy(values.data(), readback.wait().data(), count * sizeof(T));
  return values;
}

template <class T>
std::vector<T> copyOf(const ComputeDevice& device, const ComputeBuffer& buffer, std::size_t count) {
  ComputeReadback readback(device);
  return copyOf<T>(readback, buffer, count);
}

}  // namespace scanmill

#define SKIP_WITHOUT_GL() \
  if (!hasGl()) GTEST_SKIP() << "this machine has no OpenGL 4.3 by EGL"
