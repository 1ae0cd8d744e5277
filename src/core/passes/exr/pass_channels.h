#pragma once

// Finds the channels of an EXR file that contain a pass: see pass_exr.h for the names.

#include <array>
#include <string_view>

#include "passes/exr/exr_file.h"

namespace scanmill {

// Return the channels of a pass ("instance", "reflectance" ...); null if the file has none. Throw InputError if several
// channels could be the pass.
const ExrChannel* findPass(const ExrReader& file, std::string_view pass);
std::array<const ExrChannel*, 3> findNormal(const ExrReader& file);  // either all three or none are null

// Return the channels of a pass as the functions above do, but throw an InputError that lists the file's channels if
// the pass is absent. The type of the channels is not checked.
const ExrChannel& requirePass(const ExrReader& file, std::string_view pass);
const ExrChannel& requireDepth(const ExrReader& file);
std::array<const ExrChannel*, 3> requireNormal(const ExrReader& file);

}  // namespace scanmill
