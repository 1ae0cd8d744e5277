#pragma once

// Collects the files that a world names and that are missing, so that one message names all of them.

#include <string>
#include <vector>

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

class MissingFiles {
 public:
  void add(const MissingFileError& error);
  // Adds the names to `leftOut` if `leaveOut`. Otherwise throws an InputError with the message about the first missing
  // file, and the name and place of each other one.
  void noteOrThrow(bool leaveOut, LeftOut& leftOut) const;

 private:
  std::vector<MissingFileError> errors_;
};

}  // namespace scanmill
