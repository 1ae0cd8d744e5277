#pragma once

#include <filesystem>

namespace scanmill {

// Checks that a PLY file holds what its header announces. Without this, the importer would loop for ever on a header
// that ends early, believe every count, and invent what was cut off. Throws an InputError that names the file and what
// is wrong.
void checkPly(const std::filesystem::path& file);

}  // namespace scanmill
