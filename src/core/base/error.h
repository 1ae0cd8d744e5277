#pragma once

// Errors are thrown where they are found. main() turns the errors that nothing else catches into the exit code.
//
//   throw InputError({"scene.yaml", 12, 3}, "unknown class '{}'", "raod");  // scene.yaml:12:3: unknown class 'raod'
//
// A message with further arguments is a format string of fmt; without arguments it is printed as it is.

#include <fmt/core.h>

#include <exception>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>

namespace scanmill {

// A place in a text file. Line and column count from 1; 0 means unknown.
struct Location {
  std::string file;
  int line = 0;
  int column = 0;

  // Returns "file:line:column", "file:line" or "file", as far as the members are known; empty if `file` is empty.
  std::string text() const;
};

// Thrown if the work fails, for example because the disk is full (exit code 1). Changing the input does not help.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  template <class First, class... Rest>
  explicit Error(fmt::format_string<First, Rest...> format, First&& first, Rest&&... rest)
      : Error(fmt::format(format, std::forward<First>(first), std::forward<Rest>(rest)...)) {}
};

// Thrown if the input or the usage is wrong, which the user can correct (exit code 2). The message starts with the file
// and line of the fault if they are known.
class InputError : public Error {
 public:
  InputError(const Location& where, const std::string& message);
  template <class First, class... Rest>
  InputError(const Location& where, fmt::format_string<First, Rest...> format, First&& first, Rest&&... rest)
      : InputError(where, fmt::format(format, std::forward<First>(first), std::forward<Rest>(rest)...)) {}
  explicit InputError(const std::string& message);
};

// Returns an exception's message in words for a user: without the prefix "[json.exception.type_error.302] " of the JSON
// library; "the memory ran out" for std::bad_alloc and std::length_error, whose messages are names of C++.
[[nodiscard]] std::string reasonOf(const std::exception& error);

// Writes a warning to standard error, unless the same text has been written before. Any thread may call it.
void warn(const std::string& message);
template <class First, class... Rest>
void warn(fmt::format_string<First, Rest...> format, First&& first, Rest&&... rest) {
  warn(fmt::format(format, std::forward<First>(first), std::forward<Rest>(rest)...));
}
// Receives all warnings, in place of standard error, for as long as it lives; of several, the one that was made last.
// `receive` is called on any thread, one call at a time, also for texts that have been written before.
class [[nodiscard]] WarningReceiver {
 public:
  explicit WarningReceiver(std::function<void(const std::string&)> receive);
  ~WarningReceiver();
  WarningReceiver& operator=(WarningReceiver&&) = delete;  // neither copied nor moved

  const std::function<void(const std::string&)> receive;
};
// Returns how many different warnings there have been so far.
std::size_t warningCount();

}  // namespace scanmill
