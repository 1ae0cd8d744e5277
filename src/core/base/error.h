#pragma once

// Errors are thrown where they are found and caught once, in main, which turns them into the exit code.

#include <stdexcept>
#include <string>

namespace scanmill {

// A place in a text file. Line and column count from 1; 0 means unknown.
struct Location {
  std::string file;
  int line = 0;
  int column = 0;

  // "file:line:column", "file:line" or "file", as far as the place is known; empty where there is no file.
  std::string text() const;
};

// The work failed, such as by a full disk (exit code 1). Its user can do nothing about the input.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The input or the usage is wrong, and its author can mend it (exit code 2). The message starts with the place where
// the fault is, if that is given.
class InputError : public Error {
 public:
  InputError(const Location& where, const std::string& message);
  explicit InputError(const std::string& message);
};

// Writes a warning to standard error, unless the same text has been written before. Any thread may call it.
void warn(const std::string& message);
// How many different warnings there have been so far.
std::size_t warningCount();

}  // namespace scanmill
