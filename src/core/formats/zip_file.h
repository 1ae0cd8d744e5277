#pragma once

// ZIP archives in memory.

#include <span>
#include <string>
#include <utility>

namespace scanmill {

// Returns the bytes of a ZIP archive of these files, each given by its name in ASCII and its bytes; deflated, in this
// order. No time is stored: the same files give the same archive. Throws Error if libarchive cannot create the archive.
std::string zipOf(std::span<const std::pair<std::string, std::string>> files);

}  // namespace scanmill
