#pragma once

// Working memory that a thread keeps from one scan to the next: fresh pages for every scan cost a quarter of the time
// of encoding it.

#include <cstddef>
#include <memory>

namespace scanmill {

template <class T>
class Scratch {
 public:
  // Room for `count` values, contents undefined; what an earlier call gave is lost.
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
