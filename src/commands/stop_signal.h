#pragma once

#include <atomic>

namespace scanmill {

// Returns a flag that, from the first call on, SIGINT, SIGTERM and SIGHUP set, so that work ends at the next frame; a
// second signal ends the program at once. A signal that is ignored from the start, as under nohup, stays ignored.
const std::atomic<bool>& stopSignal();

// Returns the number of the signal that has set the flag; 0: none.
int stoppedBy();

}  // namespace scanmill
