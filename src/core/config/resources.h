#pragma once

// The program's own files: pipelines, scenes, labels.
//
//   const std::filesystem::path street = namedResource("street", "scenes");  // .../scenes/street.yaml

#include <filesystem>
#include <string>

namespace scanmill {

// Returns the folder that holds the program's own files, in pipelines/, scenes/ and labels/: the folder that the
// environment variable SCANMILL_RESOURCES names; without that variable the folder share/scanmill of the installation;
// in a program that is not installed, the source tree that it was built from.
std::filesystem::path resourceFolder();

// True if a name has neither a slash nor a suffix: it then means one of the program's own files before any other.
bool isPlainName(const std::string& name);

// Returns the file that an option of the command line names: by the path of a YAML file, or by the name (without
// suffix) of a file in a subfolder of resourceFolder(), such as "semantic_kitti" in "labels". Throws an InputError that
// names existing files. For names within YAML files see resolveResource().
std::filesystem::path namedResource(const std::string& name, const std::string& subfolder);

// Returns the name of the program's file in a subfolder whose name is nearest to a wrong one; empty if none is near,
// or if the wrong name is a path or has another suffix than .yaml.
std::string nearestResource(const std::string& name, const std::string& subfolder);

// Returns a file's path as datasets store it, which is the same on all machines: "scanmill:scenes/street.yaml" for one
// of the program's own files, and for other files the path from `folder`, the folder of the pipeline file.
std::string savedPath(const std::filesystem::path& file, const std::filesystem::path& folder);
// Returns the file that savedPath() names.
std::filesystem::path fileOfSavedPath(const std::string& saved, const std::filesystem::path& folder);

}  // namespace scanmill
