#pragma once

#include <filesystem>
#include <string>

namespace scanmill {

// The folder that holds the program's own files, in pipelines/, scenes/ and labels/. It is what the environment
// variable SCANMILL_RESOURCES names; without that, the installed folder share/scanmill beside the program's; without
// that, the source tree that the program was built from.
std::filesystem::path resourceFolder();

// What an option of the command line names: a YAML file, or one of a subfolder of resourceFolder() without its suffix,
// such as "semantic_kitti" of "labels". Throws InputError, with names that there are. See resolveResource() for files
// that are named in files.
std::filesystem::path namedResource(const std::string& name, const std::string& subfolder);

}  // namespace scanmill
