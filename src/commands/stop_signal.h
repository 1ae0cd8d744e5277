#pragma once

#include <atomic>

namespace scanmill {

// Returns the flag that SIGINT, SIGTERM and SIGHUP set after the first call, so that work ends at the next frame. A
// second signal ends the program at once. A signal that the program inherits as ignored, as under nohup, stays ignored.
const std::atomic<bool>& stopSignal();

// Returns the number of the signal that has set the flag; 0: none.
int stoppedBy();

}  // namespace scanmill
