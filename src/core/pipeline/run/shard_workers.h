#pragma once

// Distributes the work on shards over all threads.

#include <atomic>
#include <cstddef>
#include <functional>

namespace scanmill {

// Callbacks that do the work on a shard; they may be called from any thread. For each shard, the calls are: open()
// once; make() for each sample, in any order and several at a time; take() for each sample that is made, in order and
// one at a time; close() once.
struct ShardWork {
  // Returns the number of samples to make; 0: no further calls for this shard.
  std::function<std::size_t(std::size_t shard)> open;
  std::function<void(std::size_t shard, std::size_t sample)> make;
  std::function<void(std::size_t shard, std::size_t sample)> take;
  std::function<void(std::size_t shard)> close;
};

// Makes the shards 0 to shards - 1 with at most `workers` threads, each of which works on a separate shard. Threads
// that find no further shard make samples of unfinished shards, and then help other threads with their parallelFor().
// At any time, at most two samples per worker are being made or wait to be taken. Ends early once `*stop` is true
// (`stop` may be null) or a callback throws; rethrows the callback's exception.
void workOnShards(std::size_t shards, std::size_t workers, const std::atomic<bool>* stop, const ShardWork& work);

}  // namespace scanmill
