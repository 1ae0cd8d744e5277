#pragma once

// Work on files of strangers in a process of its own.

#include <cstdint>
#include <functional>
#include <string>

#include "base/error.h"

namespace scanmill {

// The child process ended before its work: it crashed, or wanted more time or memory than it may have. The message says
// which ("it takes more than 300 s").
class ChildEnded : public Error {
 public:
  using Error::Error;
};

// Calls `work` in a child process, which may crash, hang or ask for too much memory without harm to this one, and
// returns the bytes that it returned. The child's output is discarded. It may use `memory` bytes more than this process
// does now, and `seconds` of processor time. Throws ChildEnded, or an Error with the message of what `work` threw.
std::string inChildProcess(const std::function<std::string()>& work, std::uint64_t memory, unsigned seconds);

}  // namespace scanmill
