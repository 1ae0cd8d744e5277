#pragma once

// Runs work on untrusted files in a separate process.

#include <cstdint>
#include <functional>
#include <string>

#include "base/error.h"

namespace scanmill {

// Thrown if a child process ended before its work was done, because it crashed or exceeded its limit of time or memory.
// The message states the reason ("it takes more than 300 s").
class ChildEnded : public Error {
 public:
  using Error::Error;
};

// Calls `work` in a child process, and returns the bytes that `work` returned. The child may crash, hang or request too
// much memory without harm to this process. The child's output is discarded. The child may use `memory` bytes more than
// this process uses now, and `seconds` of CPU time. Throws ChildEnded, or an Error with the message of an exception
// thrown by `work`.
std::string inChildProcess(const std::function<std::string()>& work, std::uint64_t memory, unsigned seconds);

}  // namespace scanmill
