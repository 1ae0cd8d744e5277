#pragma once

#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace scanmill {

// An allocator with which resize() leaves new elements uninitialised: write them before reading them. Large arrays are
// then first touched by the threads that fill them, not by one thread that fills them with zeros.
template <class T>
struct RawAllocator : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = RawAllocator<U>;
  };
  using std::allocator<T>::allocator;

  template <class U>
  void construct(U* place) noexcept {
    ::new (static_cast<void*>(place)) U;
  }
  template <class U, class... Arguments>
  void construct(U* place, Arguments&&... arguments) {
    ::new (static_cast<void*>(place)) U(std::forward<Arguments>(arguments)...);
  }
};

template <class T>
using RawVector = std::vector<T, RawAllocator<T>>;

}  // namespace scanmill
