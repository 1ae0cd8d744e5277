#pragma once

#include <cstddef>
#include <thread>
#include <vector>

namespace scanmill {

// Calls work(i) for each i below `count`, each call on a thread of its own, and returns when all calls have returned.
template <class Work>
void onThreads(std::size_t count, const Work& work) {
  std::vector<std::jthread> threads;
  threads.reserve(count);
  for (std::size_t i = 0; i < count; ++i) threads.emplace_back([&work, i] { work(i); });
}

}  // namespace scanmill
