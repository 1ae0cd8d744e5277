#pragma once

#include <cstdint>

namespace scanmill {

// Returns how much memory (bytes) the program may use: the smallest of the machine's memory, the limits of the
// program's control groups (cgroups v1 or v2, set by a scheduler or container), the limit of its address space (ulimit
// -v) and the user's limit.
std::uint64_t memoryLimitBytes();

// Sets the user's limit of memory (bytes; 0: no limit) for as long as the object lives.
class [[nodiscard]] MemoryLimit {
 public:
  explicit MemoryLimit(std::uint64_t bytes);
  ~MemoryLimit();
  MemoryLimit& operator=(MemoryLimit&&) = delete;  // neither copied nor moved

 private:
  std::uint64_t previous_;
};

// Returns how many bytes of the program's memory are resident now.
std::uint64_t residentBytes();

// Returns true if more than half of memoryLimitBytes() is resident.
bool memoryIsScarce();

// Returns freed memory to the system if memory is scarce. Otherwise the allocator retains freed memory, because new
// pages cost more than reused ones: for a town, returning memory took a quarter of the set-up time.
void returnFreedMemoryIfScarce();

}  // namespace scanmill
