#pragma once

// Working memory that a thread reuses from scan to scan. Allocating new memory for each scan would take a quarter of
// the time of encoding.

#include <cstddef>
#include <memory>

namespace scanmill {

template <class T>
class Scratch {
 public:
  // Returns memory for `count` undefined values. Memory that an earlier call returned becomes invalid.
  T* get(std::size_t count) {
    if (count > size_) {
      values_.reset();
      values_ = std::make_unique_for_overwrite<T[]>(count);
      size_ = count;
    }
    return values_.get();
  }

 private:
  std::unique_ptr<T[]> values_;
  std::size_t size_ = 0;
};

}  // namespace scanmill
