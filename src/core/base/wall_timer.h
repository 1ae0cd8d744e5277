#pragma once

// Measures wall-clock time. This header is installed because base/stage_clock.h includes it.
//
//   const WallTimer timer;
//   const double seconds = timer.seconds();

#include <chrono>

namespace scanmill {

// Measures the wall-clock time since its construction.
class WallTimer {
 public:
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// Calls work() and returns how long it takes (s of wall-clock time).
double secondsOf(const auto& work) {
  const WallTimer timer;
  work();
  return timer.seconds();
}

}  // namespace scanmill
