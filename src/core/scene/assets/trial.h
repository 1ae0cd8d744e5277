#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace scanmill {

// Calls `work` in a child process, which may crash, hang or ask for too much memory without harm to this one. Returns
// what `work` returned or, where the child ended before that, how it ended; an empty text means success. The child's
// output is discarded. The child may use `memory` bytes more than this process does now, and `seconds` of processor
// time.
std::string tryApart(const std::function<std::string()>& work, std::uint64_t memory, unsigned seconds);

}  // namespace scanmill
