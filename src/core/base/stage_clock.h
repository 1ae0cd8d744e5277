#pragma once

// Measures how much time each stage of some work takes. This header is installed because pipeline/run/generate.h
// includes it.
//
//   StageClock clock;
//   {
//     const StageTimer timer(clock, "trace");
//   }  // adds its time to the clock
//   const double seconds = clock.seconds().at("trace");

#include <initializer_list>
#include <map>
#include <mutex>
#include <string>

#include "base/wall_timer.h"

namespace scanmill {

// Seconds by the name of a stage. If several threads work on a stage, their seconds are added up.
using StageSeconds = std::map<std::string, double>;

// Adds the seconds of each stage in `from` to the seconds of the same stage in `to`.
void addSeconds(const StageSeconds& from, StageSeconds& to);

// Adds up the time that stages take. Several threads may use it at once.
class StageClock {
 public:
  StageClock() = default;
  // The stages appear in seconds() even if no time is added to them.
  StageClock(std::initializer_list<const char*> stages);
  void add(const std::string& stage, double seconds);
  StageSeconds seconds() const;

 private:
  mutable std::mutex mutex_;
  StageSeconds seconds_;
};

// Measures the time from its construction to its destruction and adds it to a stage of a clock. The clock must outlive
// the timer.
class [[nodiscard]] StageTimer {
 public:
  StageTimer(StageClock& clock, const char* stage) : clock_(clock), stage_(stage) {}
  ~StageTimer() { clock_.add(stage_, timer_.seconds()); }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  StageClock& clock_;
  const char* stage_;
  WallTimer timer_;
};

}  // namespace scanmill
