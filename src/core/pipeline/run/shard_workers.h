#pragma once

// Shards on all threads.

#include <atomic>
#include <cstddef>
#include <functional>

namespace scanmill {

// What is done for a shard. Every call comes from any thread; those of one shard come in this order: open() once,
// make() for each of its samples, in any order and several at a time, take() for each of them, in order and one at a
// time, and close() once.
struct ShardWork {
  // How many samples there are to make; 0: none, then nothing more is called for it.
  std::function<std::size_t(std::size_t shard)> open;
  std::function<void(std::size_t shard, std::size_t sample)> make;
  std::function<void(std::size_t shard, std::size_t sample)> take;
  std::function<void(std::size_t shard)> close;
};

// Does the work of the shards 0 to shards - 1, each by a thread of its own, at most `workers` threads. Threads that
// find no shard any more make samples of those that are not done, and then help whoever shares out his work by
// parallelFor(). No more samples are being made, or wait to be taken, than two for each worker. Ends early once `stop`
// (or null) is set or a call throws, and throws what that did.
void workOnShards(std::size_t shards, std::size_t workers, const std::atomic<bool>* stop, const ShardWork& work);

}  // namespace scanmill
