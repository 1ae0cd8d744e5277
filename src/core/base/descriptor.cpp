#include "base/descriptor.h"

#include <unistd.h>

namespace scanmill {

void Descriptor::close() {
  if (open()) ::close(number);
  number = -1;
}

}  // namespace scanmill
