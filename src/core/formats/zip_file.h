#pragma once

// ZIP archives in memory.

#include <span>
#include <string>
#include <utility>

namespace scanmill {

// The bytes of an archive of these files, each of a name in ASCII and its bytes, deflated, in this order. No clock is
// written: the same files give the same archive. Throws Error where libarchive cannot make it.
std::string zipOf(std::span<const std::pair<std::string, std::string>> files);

}  // namespace scanmill
