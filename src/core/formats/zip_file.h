#pragma once

// ZIP archives in memory.

#include <span>
#include <string>
#include <utility>

namespace scanmill {

// Returns the bytes of a ZIP archive that contains these files, compressed, in this order. Each file is a pair of its
// name in ASCII and its bytes. No time is stored, so the same files always give the same archive. Throws Error if
// libarchive cannot create the archive.
std::string zipOf(std::span<const std::pair<std::string, std::string>> files);

}  // namespace scanmill
