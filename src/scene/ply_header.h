#pragma once

#include <filesystem>

namespace scanmill {

// Checks the header of a PLY file, since the importer loops for ever on one that ends early and believes every count.
// Throws InputError that names the file and what is wrong: no end_header, an unknown line or type, more elements than
// the file has room for.
void checkPlyHeader(const std::filesystem::path& file);

}  // namespace scanmill
