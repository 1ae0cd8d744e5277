#pragma once

#include <atomic>

namespace scanmill {

// Installs handlers of SIGINT, SIGTERM and SIGHUP, and returns the flag that they set to end work at the next frame. A
// second signal of the same kind ends the program at once. Signals ignored at the start, as by nohup, stay ignored.
const std::atomic<bool>& stopSignal();
// Returns the number of the signal that has set the flag of stopSignal(); 0: none.
int stoppedBy();

}  // namespace scanmill
