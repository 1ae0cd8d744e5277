#include "base/stage_clock.h"

#include <cmath>
#include <ctime>
#include <utility>

namespace scanmill {

namespace {

thread_local StageTimer* innermostTimer = nullptr;

double secondsOfClock(clockid_t clock) {
  timespec now{};
  ::clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

double threadSeconds() {
  return secondsOfClock(CLOCK_THREAD_CPUTIME_ID);
}

double processSeconds() {
  return secondsOfClock(CLOCK_PROCESS_CPUTIME_ID);
}

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

StageTimer::StageTimer(StageClock& clock, const char* stage, Kind kind)
    : clock_(clock), stage_(stage), kind_(kind), outer_(std::exchange(innermostTimer, this)), start_(threadSeconds()) {}

StageTimer::~StageTimer() {
  const std::int64_t otherThreads = otherThreads_;
  innermostTimer = outer_;
  if (outer_ != nullptr) outer_->otherThreads_ += otherThreads;
  clock_.add(stage_, kind_ == Kind::Wall ? wall_.seconds()
                                         : threadSeconds() - start_ + 1e-9 * static_cast<double>(otherThreads));
}

StageTimer* StageTimer::current() {
  return innermostTimer;
}

StageTask::StageTask(StageTimer* timer) : timer_(timer == innermostTimer ? nullptr : timer), previous_(innermostTimer) {
  if (timer_ == nullptr) return;
  innermostTimer = timer_;
  start_ = threadSeconds();
}

StageTask::~StageTask() {
  if (timer_ == nullptr) return;
  const std::int64_t taken = std::llround((threadSeconds() - start_) * 1e9);
  innermostTimer = previous_;
  timer_->otherThreads_ += taken;
  if (previous_ != nullptr) previous_->otherThreads_ -= taken;
}

}  // namespace scanmill
