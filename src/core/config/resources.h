#pragma once

// Finds the program's own files (pipelines, scenes, labels), and recognises the kind of a YAML file.
//
//   const std::filesystem::path street = namedResource("street", "scenes");  // .../scenes/street.yaml

#include <cstddef>
#include <filesystem>
#include <set>
#include <string>

#include "config/value.h"

namespace scanmill {

// Returns the folder with the program's own files, in pipelines/, scenes/ and labels/. This is the folder in the
// environment variable SCANMILL_RESOURCES if it is set; otherwise share/scanmill of the installation or, if the program
// is not installed, the source tree from which it was built.
std::filesystem::path resourceFolder();

// True if a name has neither a slash nor a suffix. Such a name is searched among the program's own files first.
bool isPlainName(const std::string& name);

// Returns the file that an option of the command line names: by the path of a YAML file, or by the name (without
// suffix) of a file in a subfolder of resourceFolder(), such as "semantic_kitti" in "labels". Throws an InputError that
// names existing files. For names within YAML files see resolveResource().
std::filesystem::path namedResource(const std::string& name, const std::string& subfolder);

// Returns the names, without suffix, of the YAML files in a subfolder of resourceFolder().
std::set<std::string> resourceNames(const std::string& subfolder);

// Returns the name of the file in a subfolder of resourceFolder() that is nearest to the unknown name `name`; empty if
// none is near, or if `name` is a path or has another suffix than .yaml.
std::string nearestResource(const std::string& name, const std::string& subfolder);

// Returns a file's path as datasets store it, which is the same on all machines: "scanmill:scenes/street.yaml" for one
// of the program's own files, and for other files the path relative to `folder`, the pipeline file's folder.
std::string savedPath(const std::filesystem::path& file, const std::filesystem::path& folder);
// Returns the file that savedPath() stored as `saved`. Other files than the program's own are relative to `folder`.
std::filesystem::path fileOfSavedPath(const std::string& saved, const std::filesystem::path& folder);

// Kinds of YAML files. A file's kind is recognised by keys that only this kind has, so that a message about a wrong
// file can say what the file is.
enum class FileKind { Unknown, Pipeline, Scene, Sensor, Ontology, Materials };

// Returns the kind of a file; `root` is the value of the complete file.
FileKind fileKind(const Value& root);

// Throws an InputError if the file is of another kind than expected; the message says what the file is and where it
// belongs. Accepts files of unknown kind.
void expectKind(const Value& root, FileKind expected);

// True if a file's name contains a suffix of OpenStreetMap extracts, such as ".osm" in "town.osm.bz2".
bool isMap(const std::filesystem::path& file);

// Returns the first bytes of a file, at most `count`; none if it cannot be read.
std::string firstBytes(const std::filesystem::path& file, std::size_t count);

}  // namespace scanmill
