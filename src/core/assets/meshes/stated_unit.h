#pragma once

#include <filesystem>
#include <string_view>

#include "assets/meshes/asset_data.h"

namespace scanmill {

// Warns if the head of a file whose kind has no unit states one in a comment or a name, such as "File units = inches",
// "UNITS=mm" or "unit: inch", and the caller has given none. The unit is not applied, since such texts are often wrong.
void warnOfStatedUnit(std::string_view head, const AssetOptions& options, const std::filesystem::path& file);

}  // namespace scanmill
