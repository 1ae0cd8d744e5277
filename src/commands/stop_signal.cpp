#include "commands/stop_signal.h"

#include <csignal>

namespace scanmill {

namespace {

std::atomic<bool> stopRequested = false;
static_assert(std::atomic<bool>::is_always_lock_free);  // or a signal handler may not touch it

}  // namespace

const std::atomic<bool>& stopSignal() {
  for (const int s : {SIGINT, SIGTERM}) {
    std::signal(s, [](int number) {
      stopRequested = true;
      std::signal(number, SIG_DFL);
    });
  }
  return stopRequested;
}

}  // namespace scanmill
