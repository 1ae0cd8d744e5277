#pragma once

#include <utility>

namespace scanmill {

// Owns a file descriptor and closes it. `number` is negative if opening the file failed, and after close().
struct [[nodiscard]] Descriptor {
  explicit Descriptor(int opened = -1) : number(opened) {}
  ~Descriptor() { close(); }
  Descriptor(Descriptor&& other) noexcept : number(std::exchange(other.number, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number, other.number);
    return *this;
  }
  bool open() const { return number >= 0; }
  void close();
  int number;
};

}  // namespace scanmill
