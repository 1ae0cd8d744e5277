#pragma once

// Working memory that a thread keeps from one scan to the next. To ask the system for new memory for each scan would
// cost a quarter of the time that it takes to encode one.

#include <cstddef>
#include <memory>

namespace scanmill {

template <class T>
class Scratch {
 public:
  // Returns room for `count` values, which are undefined. What an earlier call returned may no longer be used.
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
