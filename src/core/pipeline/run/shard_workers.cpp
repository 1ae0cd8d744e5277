#include "pipeline/run/shard_workers.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <list>
#include <memory>
#include <mutex>
#include <set>

#include "base/tsan_order.h"

namespace scanmill {

namespace {

constexpr std::size_t kMostInFlight = 2;  // samples per worker that are being made or wait to be taken

// A shard that is being made, perhaps by several threads.
struct SharedShard {
  std::size_t index = 0;
  std::size_t samples = 0;          // number of samples to make
  std::size_t started = 0;          // number of samples that threads have started to make
  std::size_t taken = 0;            // number of samples that are taken
  std::set<std::size_t> made = {};  // samples that are made but not taken yet
  bool beingTaken = false;          // true while a thread takes samples of this shard
};

class ShardWorkers {
 public:
  ShardWorkers(std::size_t shards, std::size_t workers, const std::atomic<bool>* stop, const ShardWork& work)
      : shards_(shards), workers_(workers), stop_(stop), work_(work) {}

  void run() {
    TaskOrder started;
    TaskOrder done;
    {
      const TaskOrder::Wait wait(started, done);
      // parallelFor() would isolate its tasks. With tbb::parallel_for(), threads without work help with the inner loops
      // of other threads.
      tbb::parallel_for(
          tbb::blocked_range<std::size_t>(0, workers_, 1),
          [&](const tbb::blocked_range<std::size_t>&) SCANMILL_UNWATCHED {
            const TaskOrder::Task task(started, done);
            worker();
          },
          tbb::simple_partitioner());
    }
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  using Lock = std::unique_lock<std::mutex>;

  // Works until no sample is left to start, or until the work ends early. The mutex is locked except during callbacks.
  void worker() {
    Lock lock(mutex_);
    try {
      std::shared_ptr<SharedShard> ownShard;
      while (!ended()) {
        if (ownShard != nullptr && ownShard->started == ownShard->samples) ownShard = nullptr;
        if (ownShard == nullptr && next_ < shards_) {
          ownShard = open(lock);
          continue;
        }
        const std::shared_ptr<SharedShard> shard = ownShard != nullptr ? ownShard : mostUnstarted();
        if (shard == nullptr) return;
        if (inFlight_ < kMostInFlight * workers_) {
          makeNext(*shard, lock);
        } else {
          changed_.wait(lock);
        }
      }
    } catch (...) {
      if (!lock.owns_lock()) lock.lock();
      if (!failure_) failure_ = std::current_exception();
    }
    changed_.notify_all();
  }

  bool ended() const { return failure_ != nullptr || (stop_ != nullptr && *stop_); }

  // Opens the next shard; returns null if it has no sample to make.
  std::shared_ptr<SharedShard> open(Lock& lock) {
    const std::size_t shard = next_++;
    lock.unlock();
    const std::size_t samples = work_.open(shard);
    lock.lock();
    if (samples == 0) return nullptr;
    return open_.emplace_back(std::make_shared<SharedShard>(SharedShard{.index = shard, .samples = samples}));
  }

  // Returns the open shard with the most samples that no thread has started; null if all samples are started.
  std::shared_ptr<SharedShard> mostUnstarted() const {
    const auto unstarted = [](const std::shared_ptr<SharedShard>& shard) { return shard->samples - shard->started; };
    const auto most = std::ranges::max_element(open_, {}, unstarted);
    return most == open_.end() || unstarted(*most) == 0 ? nullptr : *most;
  }

  // Makes the next sample of a shard, then calls takeMade() unless another thread is executing it for this shard.
  void makeNext(SharedShard& shard, Lock& lock) {
    const std::size_t sample = shard.started++;
    ++inFlight_;
    lock.unlock();
    work_.make(shard.index, sample);
    lock.lock();
    shard.made.insert(sample);
    if (!shard.beingTaken) takeMade(shard, lock);
  }

  // Calls take() for the made samples that are next in order, and close() after the shard's last sample.
  void takeMade(SharedShard& shard, Lock& lock) {
    shard.beingTaken = true;
    while (shard.made.erase(shard.taken) > 0) {
      lock.unlock();
      work_.take(shard.index, shard.taken);
      lock.lock();
      ++shard.taken;
      --inFlight_;
      changed_.notify_all();
    }
    shard.beingTaken = false;
    if (shard.taken < shard.samples) return;
    open_.remove_if([&](const auto& other) { return other.get() == &shard; });
    lock.unlock();
    work_.close(shard.index);
    lock.lock();
  }

  std::size_t shards_;
  std::size_t workers_;
  const std::atomic<bool>* stop_;
  const ShardWork& work_;
  std::mutex mutex_;
  std::condition_variable changed_;  // signals that a sample was taken, or that the work ends early
  std::size_t next_ = 0;             // index of the next shard to open
  std::list<std::shared_ptr<SharedShard>> open_;
  std::size_t inFlight_ = 0;    // number of samples that are started but not taken yet
  std::exception_ptr failure_;  // the first exception of any call; null: none
};

}  // namespace

void workOnShards(std::size_t shards, std::size_t workers, const std::atomic<bool>* stop, const ShardWork& work) {
  ShardWorkers(shards, std::max<std::size_t>(workers, 1), stop, work).run();
}

}  // namespace scanmill
