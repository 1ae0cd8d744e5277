#include "exports/json_list_file.h"

#include <utility>

namespace scanmill {

std::size_t JsonListFile::add(std::string item) {
  items_.push_back(std::move(item));
  return items_.size() - 1;
}

void JsonListFile::flush() {
  std::string text;
  for (const std::string& item : items_) {
    text += file_.size() == 0 && text.empty() ? "[\n" : ",\n";
    text += item;
  }
  file_.write(text);
  items_.clear();
}

void JsonListFile::commit() {
  flush();
  file_.write(file_.size() == 0 ? "[]\n" : "\n]\n");
  file_.commit();
}

}  // namespace scanmill
