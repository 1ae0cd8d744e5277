#pragma once

// Handing work from thread to thread, for the eyes of the thread sanitizer: oneTBB orders its tasks by means that the
// sanitizer does not see, since the library is not built for it. Nothing in other builds.

#ifdef __SANITIZE_THREAD__
#include <sanitizer/tsan_interface.h>
#define SCANMILL_UNWATCHED __attribute__((no_sanitize("thread")))
#else
#define SCANMILL_UNWATCHED
#endif

namespace scanmill {

// What a thread did before it gives is done for every thread that then takes from the same object. A task's function
// is UNWATCHED: what it captured is in oneTBB's memory, and read before it can take. What it calls is watched.
class Handover {
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

  // A task: takes, and gives at its end, an exception included.
  class Turn {
   public:
    Turn(Handover& from, Handover& to) : to_(to) { from.take(); }
    ~Turn() { to_.give(); }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

   private:
    Handover& to_;
  };

  // The thread that waits for the tasks: gives, and takes at its end.
  class Wait {
   public:
    Wait(Handover& to, Handover& from) : from_(from) { to.give(); }
    ~Wait() { from_.take(); }
    Wait(const Wait&) = delete;
    Wait& operator=(const Wait&) = delete;

   private:
    Handover& from_;
  };
};

}  // namespace scanmill
