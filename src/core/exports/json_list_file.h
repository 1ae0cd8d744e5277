#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "base/file.h"

namespace scanmill {

// A file with a list of JSON, an item a line, of which those since the last flush() are in memory. It gets its name by
// commit(). All calls but add() and set() throw as AtomicFile does.
class JsonListFile {
 public:
  explicit JsonListFile(std::filesystem::path path) : file_(std::move(path)) {}

  // The text of an item without line breaks. Gives its place for set(), until the next flush().
  std::size_t add(std::string item);
  void set(std::size_t place, std::string item) { items_[place] = std::move(item); }
  void flush();
  void commit();

 private:
  AtomicFile file_;
  std::vector<std::string> items_;
};

}  // namespace scanmill
