#pragma once

// Recognises files whose name has an ending that does not fit their content.

#include <filesystem>
#include <string>

namespace scanmill {

// Returns what the first bytes of a file look like, such as "a PNG image", for the message about a file that cannot be
// read as its ending says; empty if the bytes fit the ending, or are not recognised. `kind` is the file's extension in
// lower case.
std::string otherContent(const std::filesystem::path& file, const std::string& kind);

}  // namespace scanmill
