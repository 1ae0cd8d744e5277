#pragma once

// Working memory that a thread keeps from one scan to the next. New memory from the system for each scan would cost a
// quarter of the time of encoding.

#include <cstddef>
#include <memory>

namespace scanmill {

template <class T>
class Scratch {
 public:
  // Returns room for `count` undefined values. The memory that an earlier call returned may no longer be used.
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
