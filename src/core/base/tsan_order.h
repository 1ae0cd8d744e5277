#pragma once

// Declares to the thread sanitizer how oneTBB orders its tasks. The library is not built with the sanitizer, which
// therefore cannot see that order and would report false races. In all other builds this compiles to nothing.

#ifdef __SANITIZE_THREAD__
#include <sanitizer/tsan_interface.h>
#define SCANMILL_UNWATCHED __attribute__((no_sanitize("thread")))
#else
#define SCANMILL_UNWATCHED
#endif

namespace scanmill {

// Orders the work of two threads: work before a call of give() happens before work after a call of take() on the same
// object. The function of a task is marked SCANMILL_UNWATCHED, since it reads its captures, which lie in oneTBB's
// memory, before it can call take(). The functions that the task calls are watched as usual.
class TaskOrder {
 public:
#ifdef __SANITIZE_THREAD__
  void give() {
    __tsan_release(this);
  }
  void take() {
    __tsan_acquire(this);
  }
#else
  void give() {}
  void take() {}
#endif

  // Lives while a task runs: calls from.take() at the start and to.give() at the end, also after an exception.
  class [[nodiscard]] Task {
   public:
    Task(TaskOrder& from, TaskOrder& to) : to_(to) { from.take(); }
    ~Task() { to_.give(); }
    Task& operator=(Task&&) = delete;  // neither copied nor moved

   private:
    TaskOrder& to_;
  };

  // Lives in the thread that starts tasks and waits for them: calls to.give() at the start, from.take() at the end.
  class [[nodiscard]] Wait {
   public:
    Wait(TaskOrder& to, TaskOrder& from) : from_(from) { to.give(); }
    ~Wait() { from_.take(); }
    Wait& operator=(Wait&&) = delete;  // neither copied nor moved

   private:
    TaskOrder& from_;
  };
};

}  // namespace scanmill
