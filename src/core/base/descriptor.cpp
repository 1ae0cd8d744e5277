#include "base/descriptor.h"

#include <unistd.h>

namespace scanmill {

Descriptor::~Descriptor() {
  if (number >= 0) ::close(number);
}

}  // namespace scanmill
