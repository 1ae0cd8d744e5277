#include "commands/stop_signal.h"

#include <csignal>

namespace scanmill {

namespace {

std::atomic<bool> stopRequested = false;
std::atomic<int> signalNumber = 0;
static_assert(std::atomic<bool>::is_always_lock_free);  // otherwise a signal handler may not access it
static_assert(std::atomic<int>::is_always_lock_free);

void requestStop(int number) {
  signalNumber = number;
  stopRequested = true;
  std::signal(number, SIG_DFL);
}

}  // namespace

const std::atomic<bool>& stopSignal() {
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    if (std::signal(number, requestStop) == SIG_IGN) std::signal(number, SIG_IGN);
  }
  return stopRequested;
}

int stoppedBy() {
  return signalNumber;
}

}  // namespace scanmill
