#include "base/error.h"

#include <fmt/core.h>

#include <cstdio>
#include <mutex>
#include <set>

#include "base/terminal.h"

namespace scanmill {

namespace {

std::mutex warningMutex;

std::set<std::string>& warnings() {
  static std::set<std::string> seen;
  return seen;
}

}  // namespace

std::string Location::text() const {
  if (file.empty()) return {};
  if (line == 0) return file;
  return column == 0 ? fmt::format("{}:{}", file, line) : fmt::format("{}:{}:{}", file, line, column);
}

InputError::InputError(const Location& where, const std::string& message)
    : Error(where.file.empty() ? message : where.text() + ": " + message) {}

InputError::InputError(const std::string& message) : Error(message) {}

void warn(const std::string& message) {
  const std::scoped_lock lock(warningMutex);
  if (warnings().insert(message).second) printError("warning: {}\n", indented(message));
}

std::size_t warningCount() {
  const std::scoped_lock lock(warningMutex);
  return warnings().size();
}

}  // namespace scanmill
