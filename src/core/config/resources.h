#pragma once

#include <filesystem>

namespace scanmill {

// The folder that holds the program's own files, in pipelines/, scenes/ and labels/. It is what the environment
// variable SCANMILL_RESOURCES names; without that, the installed folder share/scanmill beside the program's; without
// that, the source tree that the program was built from.
std::filesystem::path resourceFolder();

}  // namespace scanmill
