#include "base/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <utility>

#include "base/stage_clock.h"
#include "base/tsan_order.h"

namespace scanmill {

namespace {

// True on a thread that runs the work of withWaiters(). The loops of that work are not isolated, so that threads that
// wait for the work can take part in them.
thread_local bool workIsShared = false;

class ShareWork {
 public:
  explicit ShareWork(bool shared) : previous_(std::exchange(workIsShared, shared)) {}
  ~ShareWork() { workIsShared = previous_; }
  ShareWork& operator=(ShareWork&&) = delete;  // neither copied nor moved

 private:
  bool previous_;
};

}  // namespace

void parallelFor(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body) {
  if (count == 0) return;
  grain = std::max<std::size_t>(grain, 1);
  if (count <= grain) {
    body(0, count);
    return;
  }
  // TBB halves a range down to half its grain size. The loop therefore counts complete grains, so that each call of
  // body() gets at least one grain.
  const std::size_t grains = (count - 1) / grain + 1;
  TaskOrder started;
  TaskOrder done;
  const TaskOrder::Wait wait(started, done);
  StageTimer* const stage = StageTimer::current();
  const auto loop = [&] {
    const tbb::blocked_range<std::size_t> all(0, grains);
    tbb::parallel_for(all, [&](const tbb::blocked_range<std::size_t>& r) SCANMILL_UNWATCHED {
      const TaskOrder::Task order(started, done);
      const StageTask task(stage);
      body(r.begin() * grain, r.end() == grains ? count : r.end() * grain);
    });
  };
  // Isolates the loop: a thread that waits for it must not start an unrelated outer task, whose buffers take memory.
  isolated(std::cref(loop));
}

void withWaiters(const std::function<void()>& work) {
  const ShareWork share(true);
  work();
}

bool hasWaiters() {
  return workIsShared;
}

void isolated(const std::function<void()>& work) {
  if (workIsShared) {
    const ShareWork isolate(false);  // loops within this work are isolated again
    work();
  } else {
    tbb::this_task_arena::isolate(work);
  }
}

ThreadLimit::ThreadLimit(int threads) {
  const int limit = threads > 0 ? threads : tbb::info::default_concurrency();
  control_ = new tbb::global_control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(limit));
}

ThreadLimit::~ThreadLimit() {
  delete static_cast<tbb::global_control*>(control_);
}

int threadCount() {
  return static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

}  // namespace scanmill
