#pragma once

// Parallel loops over all cores that the program may use (option --threads).

#include <cstddef>
#include <functional>

namespace scanmill {

// Calls body(first, last) for disjoint ranges [first, last) that together cover [0, count). Each range has at least
// `grain` indices, except the last. Returns when all calls have returned. The ranges differ from run to run: body()
// must compute the same for an index in every range, and may write only to what belongs to its range.
void parallelFor(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body);

// Calls body(index) for each index in [0, count), by parallelFor().
template <class Body>
void parallelForEach(std::size_t count, std::size_t grain, const Body& body) {
  parallelFor(count, grain, [&](std::size_t first, std::size_t last) {
    for (std::size_t index = first; index < last; ++index) body(index);
  });
}

// Calls work(), in which a library runs loops of oneTBB. While this thread waits for such a loop, it starts no
// unrelated task, which could wait for a lock that this thread holds. parallelFor() needs no such call. Within
// withWaiters(), threads that wait take part in these loops, too.
void isolated(const std::function<void()>& work);

// Calls work(). To be called within a call of tbb::collaborative_call_once(): threads that wait for that call then take
// part in the parallelFor() loops of work(), and in no other tasks.
void withWaiters(const std::function<void()>& work);
// True on a thread within withWaiters(). A nested tbb::collaborative_call_once() on this thread must run without help:
// threads that wait for the outer call cannot take part in loops of the nested call.
bool hasWaiters();

// Limits how many threads all parallel work uses, for as long as the object lives; 0 means one for each core.
class [[nodiscard]] ThreadLimit {
 public:
  explicit ThreadLimit(int threads);
  ~ThreadLimit();
  ThreadLimit& operator=(ThreadLimit&&) = delete;  // neither copied nor moved

 private:
  void* control_;
};

// Returns how many threads parallel work may use now.
int threadCount();

}  // namespace scanmill
