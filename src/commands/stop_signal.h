#pragma once

#include <atomic>

namespace scanmill {

// From the first call on, SIGINT and SIGTERM set the flag, for work to end at the next frame; a second one ends the
// program at once.
const std::atomic<bool>& stopSignal();

}  // namespace scanmill
