#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace scanmill {

// Does `work` in a child process that may crash, hang or ask for too much memory without harm to this one; its output
// is discarded. Returns what `work` returned, or how the child ended. An empty text means success. The child may use
// `memory` bytes more than this process does now, and `seconds` of processor time.
std::string tryApart(const std::function<std::string()>& work, std::uint64_t memory, unsigned seconds);

}  // namespace scanmill
