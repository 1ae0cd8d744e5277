#pragma once

// Finds the images that assets name.

#include <filesystem>
#include <string>
#include <vector>

namespace scanmill {

// Finds the file that the asset at `asset` calls `name`; empty if there is none. A prefix model:// or file:// is
// resolved first; any name is then tried relative to the asset's folder. Next, its last component is searched for in
// the asset's folder, in the folders near it that usually contain textures, and in `folders`, first case-sensitively,
// then ignoring case. If only a file outside of the asset's folder matches, throws InputError, unless `allowOutside` is
// set.
std::filesystem::path findTexture(const std::filesystem::path& asset, const std::string& name, bool allowOutside,
                                  const std::vector<std::filesystem::path>& folders = {});

}  // namespace scanmill
