#pragma once

// Errors are thrown where they are found and caught once, in main.

#include <stdexcept>
#include <string>

namespace scanmill {

// A place in a text file; line and column count from 1, 0 where unknown.
struct Location {
  std::string file;
  int line = 0;
  int column = 0;

  // "file:line:column", as far as known; empty for an empty location.
  std::string text() const;
};

// The work failed (exit code 1): a full disk, a failed verification.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The input or the usage is wrong (exit code 2): its author can mend it. The message starts with the place.
class InputError : public Error {
 public:
  InputError(const Location& where, const std::string& message);
  explicit InputError(const std::string& message);
};

// A warning goes to standard error once per distinct text; warnings() counts them for summaries.
void warn(const std::string& message);
std::size_t warningCount();

}  // namespace scanmill
