#include "pipeline/run/shard_workers.h"

#include <mutex>
#include <numeric>
#include <random>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "base/parallel.h"

namespace scanmill {
namespace {

using testing::ElementsAreArray;

// Notes what is called, and checks the order of the calls for each shard while they come.
class Notebook {
 public:
  explicit Notebook(std::vector<std::size_t> samples) : samples_(std::move(samples)), shards_(samples_.size()) {}

  ShardWork work(const std::function<void(std::size_t, std::size_t)>& making = {}) {
    return {[this](std::size_t shard) {
              const std::scoped_lock lock(mutex_);
              EXPECT_FALSE(std::exchange(shards_[shard].open, true));
              return samples_[shard];
            },
            [this, making](std::size_t shard, std::size_t sample) {
              {
                const std::scoped_lock lock(mutex_);
                EXPECT_TRUE(shards_[shard].open);
                mostAtOnce_ = std::max(mostAtOnce_, ++atOnce_);
                mostInFlight_ = std::max(mostInFlight_, ++inFlight_);
              }
              if (making) making(shard, sample);
              const std::scoped_lock lock(mutex_);
              shards_[shard].made.push_back(sample);
              --atOnce_;
            },
            [this](std::size_t shard, std::size_t sample) {
              const std::scoped_lock lock(mutex_);
              const auto& made = shards_[shard].made;
              EXPECT_NE(std::find(made.begin(), made.end(), sample), made.end()) << "what is taken was made";
              shards_[shard].taken.push_back(sample);
              --inFlight_;
            },
            [this](std::size_t shard) {
              const std::scoped_lock lock(mutex_);
              EXPECT_EQ(shards_[shard].taken.size(), samples_[shard]);
              EXPECT_FALSE(std::exchange(shards_[shard].closed, true));
            }};
  }

  void expectAllDone() const {
    for (std::size_t s = 0; s < shards_.size(); ++s) {
      std::vector<std::size_t> order(samples_[s]);
      std::iota(order.begin(), order.end(), std::size_t{0});
      EXPECT_THAT(shards_[s].taken, ElementsAreArray(order)) << "in order";
      EXPECT_EQ(shards_[s].made.size(), samples_[s]);
      EXPECT_EQ(shards_[s].closed, samples_[s] > 0);
    }
  }

  std::size_t mostAtOnce() const {
    const std::scoped_lock lock(mutex_);
    return mostAtOnce_;
  }
  std::size_t mostInFlight() const { return mostInFlight_; }
  std::size_t closed() const {
    return static_cast<std::size_t>(
        std::count_if(shards_.begin(), shards_.end(), [](const Shard& shard) { return shard.closed; }));
  }

 private:
  struct Shard {
    bool open = false;
    bool closed = false;
    std::vector<std::size_t> made, taken;
  };
  std::vector<std::size_t> samples_;
  std::vector<Shard> shards_;
  mutable std::mutex mutex_;
  std::size_t atOnce_ = 0, mostAtOnce_ = 0, inFlight_ = 0, mostInFlight_ = 0;
};

void wait(std::size_t microseconds) {
  std::this_thread::sleep_for(std::chrono::microseconds(microseconds));
}

TEST(ShardWorkers, MakesEverySampleOnceAndTakesThemInOrder) {
  std::minstd_rand random(3);
  for (const std::size_t workers : {1, 2, 8}) {
    const ThreadLimit limit(static_cast<int>(workers));
    for (const std::size_t shards : {0, 1, 3, 40}) {
      std::vector<std::size_t> samples(shards);
      for (std::size_t& count : samples) count = random() % 30;  // some have none
      Notebook notes(samples);
      workOnShards(shards, workers, nullptr,
                   notes.work([](std::size_t shard, std::size_t sample) { wait((7 * shard + 13 * sample) % 5 * 20); }));
      notes.expectAllDone();
      EXPECT_LE(notes.mostAtOnce(), workers);
    }
  }
}

// With fewer shards than threads the threads share a shard: the first sample is not made before another one is begun.
TEST(ShardWorkers, ThreadsWithoutAShardHelpTheOthers) {
  const ThreadLimit limit(4);
  Notebook notes({200});
  workOnShards(1, 4, nullptr, notes.work([&](std::size_t, std::size_t sample) {
    for (int i = 0; sample == 0 && i < 30000 && notes.mostAtOnce() < 2; ++i) wait(1000);
  }));
  notes.expectAllDone();
  EXPECT_GT(notes.mostAtOnce(), 1u);
}

// What is slow to be taken does not pile up.
TEST(ShardWorkers, SamplesInFlightAreBounded) {
  const ThreadLimit limit(4);
  Notebook notes({300, 300});
  ShardWork work = notes.work();
  const auto take = work.take;
  work.take = [&](std::size_t shard, std::size_t sample) {
    wait(200);
    take(shard, sample);
  };
  workOnShards(2, 4, nullptr, work);
  notes.expectAllDone();
  EXPECT_LE(notes.mostInFlight(), 2u * 4);
}

TEST(ShardWorkers, WhatAnyCallThrowsEndsTheWork) {
  const ThreadLimit limit(4);
  for (const int which : {0, 1, 2, 3}) {
    Notebook notes(std::vector<std::size_t>(50, 10));
    ShardWork work = notes.work([](std::size_t, std::size_t) { wait(50); });
    const auto fails = [&](int call, std::size_t shard, std::size_t sample) {
      if (call == which && shard == 20 && sample == 5) throw std::runtime_error("on purpose");
    };
    const ShardWork own = work;
    work.open = [&](std::size_t shard) {
      fails(0, shard, 5);
      return own.open(shard);
    };
    work.make = [&](std::size_t shard, std::size_t sample) {
      fails(1, shard, sample);
      own.make(shard, sample);
    };
    work.take = [&](std::size_t shard, std::size_t sample) {
      fails(2, shard, sample);
      own.take(shard, sample);
    };
    work.close = [&](std::size_t shard) {
      fails(3, shard, 5);
      own.close(shard);
    };
    EXPECT_THROW(workOnShards(50, 4, nullptr, work), std::runtime_error);
    EXPECT_LT(notes.closed(), 40u);
  }
}

TEST(ShardWorkers, EndsEarlyWhenItIsStopped) {
  const ThreadLimit limit(4);
  std::atomic<bool> stop = false;
  Notebook notes(std::vector<std::size_t>(1000, 10));
  workOnShards(1000, 4, &stop, notes.work([&](std::size_t shard, std::size_t) {
    if (shard == 7) stop = true;
    while (shard >= 50 && !stop) wait(50);
  }));
  EXPECT_LT(notes.closed(), 100u);
}

// Work that threads share out within a sample is helped by those that have none left.
TEST(ShardWorkers, MakingMaySpreadOverThreads) {
  const ThreadLimit limit(4);
  std::vector<std::atomic<int>> sums(12);
  Notebook notes({5, 7});
  workOnShards(2, 4, nullptr, notes.work([&](std::size_t shard, std::size_t sample) {
    parallelFor(1000, 10, [&](std::size_t first, std::size_t last) {
      sums[shard * 5 + sample] += static_cast<int>(last - first);
    });
  }));
  notes.expectAllDone();
  for (const auto& sum : sums) EXPECT_EQ(sum, 1000);
}

}  // namespace
}  // namespace scanmill
