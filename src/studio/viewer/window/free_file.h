#pragma once

#include <filesystem>
#include <string>

namespace scanmill {

// `name`_000`suffix` in the current folder, or the next number that is free. Throws Error.
std::filesystem::path freeFile(const std::string& name, const std::string& suffix);

}  // namespace scanmill
