#pragma once

// Parallel loops over all cores that the program may use (--threads).

#include <cstddef>
#include <functional>

namespace scanmill {

// Calls body(first, last) for disjoint ranges that cover [0, count), each at least `grain` long but for the last.
// The split is not deterministic: bodies must write only to their own range.
void parallelFor(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body);

// Limits the threads of all parallel work while it lives; 0 means all cores.
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
