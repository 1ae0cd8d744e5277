#include "gpu/device.h"

#include <cstdlib>

namespace scanmill {

std::string namedDevice() {
  const char* name = std::getenv("SCANMILL_GL_DEVICE");
  return name != nullptr ? name : "";
}

}  // namespace scanmill
