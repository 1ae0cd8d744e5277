#pragma once

// ZIP archives in memory.

#include <span>
#include <string>
#include <utility>

namespace scanmill {

// The bytes of an archive of these files, each of a name and its bytes, in this order. Bytes are deflated where that
// makes them fewer. All files are dated 1980-01-01, the earliest day that the format knows, so that the same files give
// the same archive. Names are UTF-8, with '/' between folders. Throws Error for a name of more than 65535 bytes and
// where there is no memory to deflate with.
std::string zipOf(std::span<const std::pair<std::string, std::string>> files);

}  // namespace scanmill
