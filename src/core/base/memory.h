#pragma once

#include <cstdint>

namespace scanmill {

// Returns how much memory (bytes) the program may take: the least of the machine's memory, what the control groups
// (cgroups v1 or v2) of its scheduler or container allow, and what its user allows.
std::uint64_t memoryLimitBytes();

// Sets how many bytes the user allows for as long as the object lives; 0: no limit.
class MemoryLimit {
 public:
  explicit MemoryLimit(std::uint64_t bytes);
  ~MemoryLimit();
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;

 private:
  std::uint64_t before_;
};

// Returns how many bytes of the program's memory are resident now.
std::uint64_t residentBytes();

}  // namespace scanmill
