#pragma once

namespace scanmill {

// Owns a file descriptor and closes it. `number` is negative if opening the file failed.
struct [[nodiscard]] Descriptor {
  explicit Descriptor(int opened) : number(opened) {}
  ~Descriptor();
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number;
};

}  // namespace scanmill
