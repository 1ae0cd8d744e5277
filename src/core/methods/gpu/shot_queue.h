#pragma once

// Submits the shots of many threads to a device. While some shots are being processed, others queue up; one dispatch
// then processes as many of these as it can.

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "gpu/compute.h"

namespace scanmill {

// Work: all or some rays of a shot, for whose results a thread waits. It has these members:
//
//     std::size_t rays() const
//     std::uint64_t bytes() const              // size of the largest array whose size depends on the work
//     bool canShareDispatch(const Work& other) const   // true only for works of equally many rays that can share a
//     dispatch
//
template <class Work>
class ShotQueue {
 public:
  // The works of one dispatch. `hits` gets their results, one work after the other, in the order of submission.
  struct Batch {
    explicit Batch(const ComputeDevice& device) : hits(device) {}
    ComputeReadback hits;
    std::size_t rays = 0;  // number of rays of all works
  };
  // A function that submits works to the device, and starts the copy to `batch.hits`. Called by one thread at a time.
  using Give = std::function<void(const std::vector<const Work*>& together, Batch& batch)>;

  // `most`: upper bound of the sum of bytes() of the works that share a dispatch; kMostBytesTogether bounds it, too.
  ShotQueue(const ComputeDevice& device, std::uint64_t most, Give give)
      : most_(std::min(most, kMostBytesTogether)), give_(std::move(give)) {
    for (std::size_t k = 0; k < kInFlight; ++k) free_.push_back(std::make_unique<Batch>(device));
  }

  struct Given {
    std::shared_ptr<Batch> batch;
    std::size_t from = 0;  // index of the work's first ray in the batch
  };
  // Returns after this or another thread has submitted the work. Rethrows the exception if that fails.
  Given give(const Work& work) {
    Waiting mine{work, {}, nullptr};
    std::unique_lock lock(mutex_);
    queue_.push_back(&mine);
    while (mine.given.batch == nullptr && !mine.failure) {
      if (leading_) {
        changed_.wait(lock);
      } else {
        lead(lock);
      }
    }
    if (mine.failure) std::rethrow_exception(mine.failure);
    return mine.given;
  }

 private:
  // Largest number of dispatches in flight: those whose hits are being computed or copied.
  static constexpr std::size_t kInFlight = 3;
  static constexpr std::uint64_t kMostBytesTogether = std::uint64_t{256} << 20;

  struct Waiting {
    const Work& work;
    Given given;
    std::exception_ptr failure;
  };

  // Waits until fewer than kInFlight dispatches are in flight; then submits the first waiting work with the works that
  // can share its dispatch. If that fails, submits each of them alone: a single work may fit into memory although
  // several together did not. A thread may return as soon as its work is submitted: then its Waiting no longer exists.
  void lead(std::unique_lock<std::mutex>& lock) {
    leading_ = true;
    std::shared_ptr<Batch> batch = freeBatch(lock);
    const std::vector<Waiting*> together = takeTogether();
    if (!submit(together, std::move(batch), lock)) {
      for (Waiting* waiting : together) submit({waiting}, freeBatch(lock), lock);
    }
    leading_ = false;
    changed_.notify_all();
  }

  // Returns a batch that becomes free again when its last user drops it.
  std::shared_ptr<Batch> freeBatch(std::unique_lock<std::mutex>& lock) {
    changed_.wait(lock, [&] { return !free_.empty(); });
    Batch* const batch = free_.back().release();
    free_.pop_back();
    batch->rays = 0;
    return {batch, [this](Batch* used) {
              const std::scoped_lock again(mutex_);
              free_.emplace_back(used);
              changed_.notify_all();
            }};
  }

  // Submits works, and tells their threads what became of them. If several works fail together, returns false instead.
  bool submit(const std::vector<Waiting*>& together, std::shared_ptr<Batch> batch, std::unique_lock<std::mutex>& lock) {
    std::vector<const Work*> works;
    std::vector<std::size_t> from;
    for (const Waiting* waiting : together) {
      works.push_back(&waiting->work);
      from.push_back(batch->rays);
      batch->rays += waiting->work.rays();
    }
    lock.unlock();
    std::exception_ptr failure;
    try {
      isolated([&] { give_(works, *batch); });
    } catch (...) {
      failure = std::current_exception();
      batch = nullptr;  // while the lock is free, which freeing a batch takes
    }
    lock.lock();
    if (failure && together.size() > 1) return false;
    for (std::size_t i = 0; i < together.size(); ++i) {
      together[i]->given = {batch, from[i]};
      together[i]->failure = failure;
    }
    changed_.notify_all();
    return true;
  }

  std::vector<Waiting*> takeTogether() {
    const Work& first = queue_.front()->work;
    const std::uint64_t most = std::max<std::uint64_t>(most_ / std::max<std::uint64_t>(first.bytes(), 1), 1);
    std::vector<Waiting*> together;
    std::vector<Waiting*> left;
    together.reserve(queue_.size());
    left.reserve(queue_.size());
    for (Waiting* waiting : queue_) {
      (together.size() < most && waiting->work.canShareDispatch(first) ? together : left).push_back(waiting);
    }
    queue_ = std::move(left);
    return together;
  }

  const std::uint64_t most_;
  const Give give_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::unique_ptr<Batch>> free_;  // batches that are not in flight
  std::vector<Waiting*> queue_;
  bool leading_ = false;  // true while a thread is in lead()
};

}  // namespace scanmill
