#pragma once

#include <filesystem>

namespace scanmill {

// The folder that holds pipelines/, scenes/ and labels/: SCANMILL_RESOURCES where set, else the installed share folder
// beside the program, else the source tree it was built from.
std::filesystem::path resourceFolder();

}  // namespace scanmill
