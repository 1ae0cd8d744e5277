#pragma once

#include <filesystem>

namespace scanmill {

// Checks that a PLY file holds what its header announces, since the importer loops for ever on a header that ends
// early, believes every count, and makes up what was cut off. Throws InputError that names the file and what is wrong.
void checkPly(const std::filesystem::path& file);

}  // namespace scanmill
