#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "base/file.h"

namespace scanmill {

// A file with a JSON list, one item per line. Items that were added since the last flush() are in memory. The file gets
// its final name in commit(). All calls except add() and set() throw the errors of AtomicFile.
class JsonListFile {
 public:
  explicit JsonListFile(std::filesystem::path path) : file_(std::move(path)) {}

  // Adds the JSON text of an item, without line breaks. Returns the item's index for set(), which is valid until the
  // next flush().
  std::size_t add(std::string item);
  void set(std::size_t place, std::string item) { items_[place] = std::move(item); }
  void flush();
  void commit();

 private:
  AtomicFile file_;
  std::vector<std::string> items_;
};

}  // namespace scanmill
