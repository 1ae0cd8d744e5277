#pragma once

#include <cstdint>

namespace scanmill {

// How much memory the program may take, in bytes: that of the machine, or what the control groups (cgroups v1 or v2) of
// its scheduler or container allow, whichever is less.
std::uint64_t memoryLimitBytes();

// How much of it is resident now.
std::uint64_t residentBytes();

}  // namespace scanmill
