#include "base/stage_clock.h"

namespace scanmill {

void addSeconds(const StageSeconds& from, StageSeconds& to) {
  for (const auto& [stage, seconds] : from) to[stage] += seconds;
}

StageClock::StageClock(std::initializer_list<const char*> stages) {
  for (const char* stage : stages) seconds_[stage] = 0;
}

void StageClock::add(const std::string& stage, double seconds) {
  const std::scoped_lock lock(mutex_);
  seconds_[stage] += seconds;
}

StageSeconds StageClock::seconds() const {
  const std::scoped_lock lock(mutex_);
  return seconds_;
}

}  // namespace scanmill
