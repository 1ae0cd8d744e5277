#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "base/file.h"

namespace scanmill {

// A file with a JSON list, one item per line. Items added since the last flush() are in memory. The file gets its final
// name by commit(). All calls except add() and set() throw as AtomicFile does.
class JsonListFile {
 public:
  explicit JsonListFile(std::filesystem::path path) : file_(std::move(path)) {}

  // Adds the text of an item, without line breaks. Returns its place for set(), which is valid until the next flush().
  std::size_t add(std::string item);
  void set(std::size_t place, std::string item) { items_[place] = std::move(item); }
  void flush();
  void commit();

 private:
  AtomicFile file_;
  std::vector<std::string> items_;
};

}  // namespace scanmill
