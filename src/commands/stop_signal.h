#pragma once

#include <atomic>

namespace scanmill {

// From the first call on, SIGINT, SIGTERM and SIGHUP set the flag, for work to end at the next frame; a second one ends
// the program at once. One that is ignored from the beginning, as by nohup, stays so.
const std::atomic<bool>& stopSignal();

// The number of the signal that has set the flag; 0: none has.
int stoppedBy();

}  // namespace scanmill
