#include "base/error.h"

#include <fmt/core.h>

#include <cstdio>
#include <mutex>
#include <new>
#include <set>
#include <string_view>
#include <vector>

#include "base/terminal.h"

namespace scanmill {

namespace {

std::mutex warningMutex;
std::vector<const WarningReceiver*> warningReceivers;

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

std::string reasonOf(const std::exception& error) {
  const bool memory = dynamic_cast<const std::bad_alloc*>(&error) != nullptr ||
                      dynamic_cast<const std::length_error*>(&error) != nullptr;
  if (memory) return "the memory ran out";
  const std::string_view text = error.what();
  const std::size_t end = text.starts_with("[json.exception.") ? text.find("] ") : std::string_view::npos;
  return std::string(end == std::string_view::npos ? text : text.substr(end + 2));
}

void warn(const std::string& message) {
  const std::scoped_lock lock(warningMutex);
  const bool isNew = warnings().insert(message).second;
  if (!warningReceivers.empty()) return warningReceivers.back()->receive(message);
  if (!isNew) return;
  std::fflush(stdout);  // so that the warning does not stand within a line if both streams go to one file
  printError("warning: {}\n", indented(message));
}

WarningReceiver::WarningReceiver(std::function<void(const std::string&)> given) : receive(std::move(given)) {
  const std::scoped_lock lock(warningMutex);
  warningReceivers.push_back(this);
}

WarningReceiver::~WarningReceiver() {
  const std::scoped_lock lock(warningMutex);
  std::erase(warningReceivers, this);
}

std::size_t warningCount() {
  const std::scoped_lock lock(warningMutex);
  return warnings().size();
}

}  // namespace scanmill
