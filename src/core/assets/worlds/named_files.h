#pragma once

// Finds the models and meshes that world descriptions name, and collects those that are missing, so that one message
// names all of them.

#include <filesystem>
#include <string>
#include <vector>

#include "assets/worlds/xml.h"
#include "base/error.h"
#include "base/format_support.h"

namespace scanmill {

// Thrown for a file that another one names and that is missing.
class MissingFileError : public InputError {
 public:
  MissingFileError(const Location& at, const std::string& uri, const std::string& message)
      : InputError(at, message), name(uri), where(at) {}

  std::string name;  // as the other file names it
  Location where;
};

// Adds the names of missing files to `leftOut` if `leaveOut`. Otherwise throws an InputError with the message about the
// first one, and the name and place of each other one, if there are any.
void tellMissing(const std::vector<MissingFileError>& missing, bool leaveOut, LeftOut& leftOut);

// Returns the file or folder that the element `from` of `file` calls `uri`: model://NAME/..., package://NAME/... (see
// assets/meshes/references.h), file://... or a path relative to the file. Throws MissingFileError at `from` if
// nothing is found.
std::filesystem::path findModel(const XmlNode& from, const std::filesystem::path& file, const std::string& uri);

}  // namespace scanmill
