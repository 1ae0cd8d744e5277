#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace scanmill {

// Buffers that are reused for later frames, so that memory use stays constant. take() returns an idle buffer, or a new
// one if none is idle; give() returns it to the pool. Safe to use from several threads.
template <class Buffers>
class BufferPool {
 public:
  [[nodiscard]] std::unique_ptr<Buffers> take() {
    const std::scoped_lock lock(mutex_);
    if (idle_.empty()) return std::make_unique<Buffers>();
    auto buffers = std::move(idle_.back());
    idle_.pop_back();
    return buffers;
  }
  void give(std::unique_ptr<Buffers> buffers) {
    const std::scoped_lock lock(mutex_);
    idle_.push_back(std::move(buffers));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<Buffers>> idle_;
};

}  // namespace scanmill
