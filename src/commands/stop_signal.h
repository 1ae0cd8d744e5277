#pragma once

#include <atomic>

namespace scanmill {

// Returns the flag that SIGINT, SIGTERM and SIGHUP set after the first call, so that work ends at the next frame. A
// second signal of the same kind ends the program at once. Signals ignored at the start, as by nohup, stay ignored.
const std::atomic<bool>& stopSignal();

// Returns the number of the signal that has set the flag; 0: none.
int stoppedBy();

}  // namespace scanmill
