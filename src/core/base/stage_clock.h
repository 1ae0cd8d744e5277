#pragma once

// Measures wall-clock time, and how much CPU time each stage of some work takes. This header is installed because
// pipeline/run/generate.h includes it.
//
//   StageClock clock;
//   {
//     const StageTimer timer(clock, "trace");
//   }  // adds its time to the clock
//   const double seconds = clock.seconds().at("trace");

#include <atomic>
#include <chrono>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <mutex>
#include <string>

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

// Seconds by the name of a stage. If several threads work on a stage, their seconds are added up.
using StageSeconds = std::map<std::string, double>;

// Adds the seconds of each stage in `from` to the seconds of the same stage in `to`.
void addSeconds(const StageSeconds& from, StageSeconds& to);

// Adds up the time that stages take. Several threads may use it at once.
class StageClock {
 public:
  StageClock() = default;
  // Makes `stages` appear in seconds() even if no time is added to them.
  StageClock(std::initializer_list<const char*> stages);
  void add(const std::string& stage, double seconds);
  StageSeconds seconds() const;

 private:
  mutable std::mutex mutex_;
  StageSeconds seconds_;
};

// Return the CPU time (s) that the calling thread or all threads of the process have taken so far.
double threadSeconds();
double processSeconds();

// Adds the time between its construction and its destruction to a stage of a clock, which must outlive the timer. The
// time is the CPU time of the thread that constructs and destroys the timer, and of the tasks that
// parallelFor() runs for this thread on other threads meanwhile. Time in which the thread waits does not count.
class [[nodiscard]] StageTimer {
 public:
  enum class Kind {
    Cpu,
    Wall,  // wall-clock time, for stages in which the thread waits for a graphics card or for another process
  };

  StageTimer(StageClock& clock, const char* stage, Kind kind = Kind::Cpu);
  ~StageTimer();
  StageTimer& operator=(StageTimer&&) = delete;  // neither copied nor moved

  // Returns the innermost timer of the calling thread; null: there is none.
  static StageTimer* current();

 private:
  friend class StageTask;

  StageClock& clock_;
  const char* stage_;
  Kind kind_;
  StageTimer* outer_;
  WallTimer wall_;
  double start_;                                // s, threadSeconds() at construction
  std::atomic<std::int64_t> otherThreads_ = 0;  // ns, CPU time of tasks on other threads
};

// Adds the CPU time of the calling thread between construction and destruction to a timer of another thread, for
// which the calling thread runs a task. Does nothing if the timer is null or is the calling thread's own.
class [[nodiscard]] StageTask {
 public:
  explicit StageTask(StageTimer* timer);
  ~StageTask();
  StageTask& operator=(StageTask&&) = delete;  // neither copied nor moved

 private:
  StageTimer* timer_;  // null: the task runs on the timer's own thread, or there is no timer
  // The calling thread's innermost timer when the task began; it does not count the time of the task.
  StageTimer* previous_;
  double start_ = 0;
};

}  // namespace scanmill
