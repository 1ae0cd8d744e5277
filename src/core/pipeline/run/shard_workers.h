#pragma once

// Distributes the work on shards over all threads.

#include <atomic>
#include <cstddef>
#include <functional>

namespace scanmill {

// The work on shards. Each call may come from any thread. For one shard the calls are: open() once, make() for each of
// its samples, in any order and several at a time, take() for each sample that is made, in order and one at a time, and
// close() once.
struct ShardWork {
  // Returns the number of samples to make; if it is 0, nothing more is called for the shard.
  std::function<std::size_t(std::size_t shard)> open;
  std::function<void(std::size_t shard, std::size_t sample)> make;
  std::function<void(std::size_t shard, std::size_t sample)> take;
  std::function<void(std::size_t shard)> close;
};

// Does the work of the shards 0 to shards - 1 with at most `workers` threads, each on a shard of its own. Threads that
// find no further shard make samples of unfinished shards, and then help other threads with their parallelFor(). At any
// time at most two samples per worker are being made or wait to be taken. Ends early once `stop` (may be null) is set
// or a call throws, and rethrows that exception.
void workOnShards(std::size_t shards, std::size_t workers, const std::atomic<bool>* stop, const ShardWork& work);

}  // namespace scanmill
