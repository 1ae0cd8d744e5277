#pragma once

// The files of nuScenes' tables: lists of rows that refer to each other by tokens.

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "base/file.h"
#include "dataset/json_text.h"
#include "exports/nuscenes_names.h"

namespace scanmill {

// Each table is a file with a JSON list, one row per line. The rows since the last flush() are in memory. All calls
// except add() throw the errors of AtomicFile; only commit() gives the files their final names.
class NuScenesRows {
 public:
  NuScenesRows(const ExportPlan& plan, const ExportFolder& folder) : plan_(plan), folder_(folder) {}

  // Creates the file of a table, which readers need even without rows.
  void open(const std::string& table) {
    tables_.try_emplace(table, folder_.prepareFile(std::filesystem::path(kNuScenesVersion) / (table + ".json")));
  }
  bool has(const std::string& table) const { return tables_.contains(table); }
  void add(const std::string& table, const OrderedJson& row) {
    Table& to = tables_.at(table);
    to.waiting += (to.rows++ == 0 ? "[\n" : ",\n") + scalarText(row);
  }
  void flush() {
    for (auto& [name, table] : tables_) {
      table.file.write(table.waiting);
      table.waiting.clear();
    }
  }
  void commit() {
    flush();
    for (auto& [name, table] : tables_) {
      table.file.write(table.rows == 0 ? "[]\n" : "\n]\n");
      table.file.commit();
    }
  }

  // Returns the token of a row of a table.
  std::string token(std::string_view table, std::string_view row) const { return nuScenesToken(plan_, table, row); }

 private:
  struct Table {
    explicit Table(const std::filesystem::path& path) : file(path) {}
    AtomicFile file;
    std::string waiting;
    std::size_t rows = 0;
  };

  const ExportPlan& plan_;
  const ExportFolder& folder_;
  std::map<std::string, Table> tables_;  // by name
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
