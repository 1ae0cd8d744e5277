#pragma once

// The files of nuScenes' tables: lists of rows that refer to each other by tokens.

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/file.h"
#include "dataset/json_text.h"
#include "exports/nuscenes_names.h"

namespace scanmill {

// A file with a JSON list, one item per line. Items that were added since the last flush() are in memory. The file gets
// its final name in commit(). All calls except add() throw the errors of AtomicFile.
class JsonListFile {
 public:
  explicit JsonListFile(const std::filesystem::path& path) : file_(path) {}

  // Adds the JSON text of an item, without line breaks.
  void add(std::string item) { items_.push_back(std::move(item)); }

  void flush() {
    std::string text;
    for (const std::string& item : items_) {
      text += file_.size() == 0 && text.empty() ? "[\n" : ",\n";
      text += item;
    }
    file_.write(text);
    items_.clear();
  }

  void commit() {
    flush();
    file_.write(file_.size() == 0 ? "[]\n" : "\n]\n");
    file_.commit();
  }

 private:
  AtomicFile file_;
  std::vector<std::string> items_;
};

class NuScenesRows {
 public:
  NuScenesRows(const ExportPlan& plan, const ExportFolder& folder) : plan_(plan), folder_(folder) {}

  // Creates the file of a table. add() needs it, and readers need it even without rows.
  void open(const std::string& table) {
    files_.try_emplace(table, folder_.prepareFile(std::filesystem::path(kNuScenesVersion) / (table + ".json")));
  }
  bool has(const std::string& table) const { return files_.contains(table); }
  void add(const std::string& table, const OrderedJson& row) { files_.at(table).add(scalarText(row)); }
  // Writes the rows added so far.
  void flush() {
    for (auto& [table, file] : files_) file.flush();
  }
  // Completes the files.
  void commit() {
    for (auto& [table, file] : files_) file.commit();
  }

  // Returns the token of a row of a table.
  std::string token(std::string_view table, std::string_view row) const { return nuScenesToken(plan_, table, row); }

 private:
  const ExportPlan& plan_;
  const ExportFolder& folder_;
  std::map<std::string, JsonListFile> files_;
};

inline OrderedJson listOf(const Vec3d& v, const std::string& what) {
  return finiteList({v.x, v.y, v.z}, what);
}

inline OrderedJson listOf(const Quat& q, const std::string& what) {
  return finiteList({q.w, q.x, q.y, q.z}, what);
}

// Adds the rows of sample_annotation and instance for the objects of a sequence. Returns the number of annotations.
std::size_t addAnnotations(const ExportPlan& plan, const ReadObjects& read, std::size_t sequence, NuScenesRows& rows);

}  // namespace scanmill
