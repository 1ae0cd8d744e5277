#pragma once

// Which channel of an EXR file holds which pass: see pass_exr.h for the names.

#include <array>
#include <string_view>

#include "passes/exr/exr_file.h"

namespace scanmill {

// "instance", "reflectance" ...; null: the file has none. Throws InputError where several could be meant.
const ExrChannel* findPass(const ExrReader& file, std::string_view pass);
const ExrChannel* findDepth(const ExrReader& file);
std::array<const ExrChannel*, 3> findNormal(const ExrReader& file);  // all or none

// findPass(), or an InputError that says what the file has. Any of the types will do.
const ExrChannel& requirePass(const ExrReader& file, std::string_view pass);
const ExrChannel& requireDepth(const ExrReader& file);
std::array<const ExrChannel*, 3> requireNormal(const ExrReader& file);

}  // namespace scanmill
