#pragma once

// Parallel loops over all cores that the program may use (option --threads).

#include <cstddef>
#include <functional>

namespace scanmill {

// Calls body(first, last) for disjoint ranges [first, last) that together cover [0, count). Each is at least `grain`
// long, but for the last. Returns when all calls have returned. How the work is split differs from run to run: what
// body() does for an index must not depend on its range, and it may write only to what belongs to its range.
void parallelFor(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body);

// Does work in which a library runs loops of oneTBB. Meanwhile this thread starts no unrelated work, which might wait
// for what it holds; in parallelFor() neither.
void isolated(const std::function<void()>& work);

// Does work within tbb::collaborative_call_once(): the threads that wait for it help with its loops of parallelFor(),
// and with nothing else.
void withWaiters(const std::function<void()>& work);
// True on a thread within withWaiters(). What it then does by tbb::collaborative_call_once() would be done by it alone:
// the loops in there are kept from those who wait for the work as a whole.
bool hasWaiters();

// Limits how many threads all parallel work takes, as long as the object lives; 0 means one for each core.
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  void* control_;
};

// How many threads parallel work may use now.
int threadCount();

}  // namespace scanmill
