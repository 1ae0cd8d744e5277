#include "base/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/collaborative_call_once.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>

#include "base/error.h"

namespace scanmill {
namespace {

class ParallelFor : public ::testing::TestWithParam<int> {};

TEST_P(ParallelFor, CoversEachIndexOnce) {
  const ThreadLimit limit(GetParam());
  for (const std::size_t count : {0u, 1u, 7u, 1000u, 100'003u}) {
    for (const std::size_t grain : {0u, 1u, 16u, 1000u, 1'000'000u}) {
      std::vector<std::atomic<int>> visits(count);
      parallelFor(count, grain, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) ++visits[i];
      });
      for (const std::atomic<int>& n : visits) ASSERT_EQ(n, 1);
    }
  }
}

TEST_P(ParallelFor, RangesHoldAtLeastAGrain) {
  const ThreadLimit limit(GetParam());
  constexpr std::size_t kCount = 10'001;
  constexpr std::size_t kGrain = 64;
  std::mutex mutex;
  std::vector<std::pair<std::size_t, std::size_t>> ranges;
  parallelFor(kCount, kGrain, [&](std::size_t first, std::size_t last) {
    const std::scoped_lock lock(mutex);
    ranges.emplace_back(first, last);
  });
  for (const auto& [first, last] : ranges) {
    EXPECT_LT(first, last);
    EXPECT_TRUE(last - first >= kGrain || last == kCount) << first << " " << last;
  }
}

TEST_P(ParallelFor, Nests) {
  const ThreadLimit limit(GetParam());
  std::atomic<std::size_t> sum{0};
  parallelFor(50, 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      parallelFor(100, 3, [&](std::size_t from, std::size_t to) { sum += to - from; });
    }
  });
  EXPECT_EQ(sum, 5000u);
}

TEST_P(ParallelFor, HandsErrorsOn) {
  const ThreadLimit limit(GetParam());
  const auto fails = [](std::size_t first, std::size_t last) {
    if (first <= 500 && 500 < last) throw InputError("beam 500 is odd");
  };
  EXPECT_THROW(parallelFor(1000, 1, fails), InputError);
}

INSTANTIATE_TEST_SUITE_P(Threads, ParallelFor, ::testing::Values(1, 2, 8));

// Of two threads that want the same thing, one makes it; the other, which waits for it, takes parts of its loops. There
// is no third thread that could.
TEST(WithWaiters, WhoeverWaitsHelps) {
  const ThreadLimit limit(2);
  tbb::collaborative_once_flag once;
  std::mutex mutex;
  std::set<std::thread::id> helpers;
  std::atomic<int> here{0};
  tbb::parallel_for(
      tbb::blocked_range<int>(0, 2, 1),
      [&](const tbb::blocked_range<int>&) {
        ++here;
        const auto late = std::chrono::steady_clock::now() + std::chrono::seconds(5);
        while (here < 2 && std::chrono::steady_clock::now() < late) std::this_thread::yield();
        tbb::collaborative_call_once(once, [&] {
          withWaiters([&] {
            for (int loop = 0; loop < 2; ++loop) {
              parallelFor(100, 1, [&](std::size_t, std::size_t) {
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
                const std::scoped_lock lock(mutex);
                helpers.insert(std::this_thread::get_id());
              });
            }
          });
        });
      },
      tbb::simple_partitioner());
  EXPECT_EQ(here, 2);
  EXPECT_EQ(helpers.size(), 2u);
}

// Work in work does its loops where the waiters are.
TEST(WithWaiters, AreKnownWhileTheWorkIsDone) {
  EXPECT_FALSE(hasWaiters());
  withWaiters([] {
    EXPECT_TRUE(hasWaiters());
    withWaiters([] { EXPECT_TRUE(hasWaiters()); });
    EXPECT_TRUE(hasWaiters());
    parallelFor(64, 1, [](std::size_t, std::size_t) { EXPECT_FALSE(hasWaiters()) << "its own loops are isolated"; });
    EXPECT_TRUE(hasWaiters());
  });
  EXPECT_FALSE(hasWaiters());
}

TEST(ThreadLimit, HoldsWhileItLives) {
  const int before = threadCount();
  {
    const ThreadLimit one(1);
    EXPECT_EQ(threadCount(), 1);
    std::atomic<int> inside{0};
    std::atomic<int> most{0};
    parallelFor(2000, 1, [&](std::size_t, std::size_t) {
      const int now = ++inside;
      int seen = most;
      while (now > seen && !most.compare_exchange_weak(seen, now)) {
      }
      --inside;
    });
    EXPECT_EQ(most, 1);
  }
  EXPECT_EQ(threadCount(), before);
  EXPECT_GE(before, 1);
}

}  // namespace
}  // namespace scanmill
