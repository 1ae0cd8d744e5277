#pragma once

// Measures where the time of some work goes, stage by stage.

#include <initializer_list>
#include <map>
#include <mutex>
#include <string>

#include "base/wall_timer.h"

namespace scanmill {

// Seconds by the name of a stage. Where several threads work on a stage, the seconds of each of them count.
using StageSeconds = std::map<std::string, double>;

// Adds the seconds of `from` to those of the same stages in `to`.
void addSeconds(const StageSeconds& from, StageSeconds& to);

// Adds up the time that stages take. Several threads may use it at once.
class StageClock {
 public:
  StageClock() = default;
  // Stages that seconds() lists even where no time is added to them.
  StageClock(std::initializer_list<const char*> stages);
  void add(const std::string& stage, double seconds);
  StageSeconds seconds() const;

 private:
  mutable std::mutex mutex_;
  StageSeconds seconds_;
};

// Adds the time from its construction to its destruction to a stage of a clock, which must outlive it.
class StageTimer {
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
