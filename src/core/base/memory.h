#pragma once

#include <cstdint>

namespace scanmill {

// How much memory the program may take, in bytes: that of the machine, what the control groups (cgroups v1 or v2) of
// its scheduler or container allow, or what its user allows, whichever is least.
std::uint64_t memoryLimitBytes();

// What the user allows, in bytes, as long as this lives; 0 for all.
class MemoryLimit {
 public:
  explicit MemoryLimit(std::uint64_t bytes);
  ~MemoryLimit();
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;

 private:
  std::uint64_t before_;
};

// How much of it is resident now.
std::uint64_t residentBytes();

}  // namespace scanmill
