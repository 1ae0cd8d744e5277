#pragma once

// Where the time of some work goes, stage by stage.

#include <initializer_list>
#include <map>
#include <mutex>
#include <string>

#include "base/wall_timer.h"

namespace scanmill {

// Seconds by the name of a stage. Where several threads work on a stage, the seconds of each of them count.
using StageSeconds = std::map<std::string, double>;

void addSeconds(const StageSeconds& from, StageSeconds& to);

// Adds up what stages take. Safe to use from several threads at once.
class StageClock {
 public:
  StageClock() = default;
  // Stages that are told with zero seconds even where nothing is added to them.
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
