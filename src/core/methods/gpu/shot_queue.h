#pragma once

// Submits the shots of many threads to a device. While some shots are being processed, further shots queue up; the next
// dispatch then processes as many of the waiting shots as it can.

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
//     std::uint64_t bytes() const                      // size of the largest array whose size depends on the work
//     bool canShareDispatch(const Work& other) const   // true only if both have equally many rays
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
  using Dispatch = std::function<void(const std::vector<const Work*>& together, Batch& batch)>;

  // Works share a dispatch only if the sum of their bytes() is at most `mostBytes` and at most kMostBytesTogether.
  ShotQueue(const ComputeDevice& device, std::uint64_t mostBytes, Dispatch dispatch)
      : mostBytes_(std::min(mostBytes, kMostBytesTogether)), dispatch_(std::move(dispatch)) {
    for (std::size_t k = 0; k < kMostInFlight; ++k) free_.push_back(std::make_unique<Batch>(device));
  }

  struct Submitted {
    std::shared_ptr<Batch> batch;
    std::size_t firstRay = 0;  // index in the batch of the work's first ray
  };
  // Waits until this or another thread has submitted the work, and returns its batch. Rethrows errors of submitting.
  Submitted submit(const Work& work) {
    Waiting waiting{work, {}, nullptr};
    std::unique_lock lock(mutex_);
    queue_.push_back(&waiting);
    while (waiting.submitted.batch == nullptr && !waiting.failure) {
      if (dispatching_) {
        changed_.wait(lock);
      } else {
        dispatchNext(lock);
      }
    }
    if (waiting.failure) std::rethrow_exception(waiting.failure);
    return waiting.submitted;
  }

 private:
  // Largest number of dispatches in flight. A dispatch is in flight while its hits are being computed or copied.
  static constexpr std::size_t kMostInFlight = 3;
  static constexpr std::uint64_t kMostBytesTogether = std::uint64_t{256} << 20;

  // A work whose thread waits in submit(). `submitted.batch` or `failure` is set when the wait ends.
  struct Waiting {
    const Work& work;
    Submitted submitted;
    std::exception_ptr failure;
  };

  // Waits until fewer than kMostInFlight dispatches are in flight; then submits the first waiting work with the works
  // that can share its dispatch. If that fails, submits each of these works alone, because a single work may fit into
  // memory. A thread may return from submit() as soon as its work is submitted: its Waiting then no longer exists.
  void dispatchNext(std::unique_lock<std::mutex>& lock) {
    dispatching_ = true;
    std::shared_ptr<Batch> batch = freeBatch(lock);
    const std::vector<Waiting*> together = takeTogether();
    if (!dispatch(together, std::move(batch), lock)) {
      for (Waiting* waiting : together) dispatch({waiting}, freeBatch(lock), lock);
    }
    dispatching_ = false;
    changed_.notify_all();
  }

  // Waits for a free batch and returns it. The batch becomes free again when the last copy of the pointer is destroyed.
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

  // Submits works in one dispatch, sets the batch or the failure in each Waiting, and returns true. If submitting fails
  // and there are several works, changes no Waiting and returns false.
  bool dispatch(const std::vector<Waiting*>& together, std::shared_ptr<Batch> batch,
                std::unique_lock<std::mutex>& lock) {
    std::vector<const Work*> works;
    std::vector<std::size_t> firstRays;
    for (const Waiting* waiting : together) {
      works.push_back(&waiting->work);
      firstRays.push_back(batch->rays);
      batch->rays += waiting->work.rays();
    }
    lock.unlock();
    std::exception_ptr failure;
    try {
      isolated([&] { dispatch_(works, *batch); });
    } catch (...) {
      failure = std::current_exception();
      batch = nullptr;  // before locking: the batch's deleter locks mutex_
    }
    lock.lock();
    if (failure && together.size() > 1) return false;
    for (std::size_t i = 0; i < together.size(); ++i) {
      together[i]->submitted = {batch, firstRays[i]};
      together[i]->failure = failure;
    }
    changed_.notify_all();
    return true;
  }

  // Removes the first waiting work, and the works that share its dispatch, from the queue.
  std::vector<Waiting*> takeTogether() {
    const Work& first = queue_.front()->work;
    const std::uint64_t mostWorks = std::max<std::uint64_t>(mostBytes_ / std::max<std::uint64_t>(first.bytes(), 1), 1);
    std::vector<Waiting*> together;
    std::erase_if(queue_, [&](Waiting* waiting) {
      const bool joins = together.size() < mostWorks && waiting->work.canShareDispatch(first);
      if (joins) together.push_back(waiting);
      return joins;
    });
    return together;
  }

  const std::uint64_t mostBytes_;
  const Dispatch dispatch_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::unique_ptr<Batch>> free_;  // batches that are not in flight
  std::vector<Waiting*> queue_;
  bool dispatching_ = false;  // true while a thread is in dispatchNext()
};

}  // namespace scanmill
