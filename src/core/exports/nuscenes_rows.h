#pragma once

// The rows of nuScenes' tables, for nuscenes_tables.cpp and nuscenes_annotations.cpp.

#include <map>
#include <string>

#include "base/file.h"
#include "dataset/json_text.h"
#include "exports/nuscenes_names.h"

namespace scanmill {

// Each table is a file with a JSON list, one row per line. The rows since the last flush() are in memory. All calls
// except add() throw the errors of AtomicFile; only commit() gives the files their final names.
class NuScenesRows {
 public:
  explicit NuScenesRows(const ExportFolder& folder) : folder_(folder) {}

  // Creates the file of a table, which readers need even without rows.
  void open(const std::string& table) {
    tables_.try_emplace(table, folder_.prepareFile(std::filesystem::path(kNuScenesVersion) / (table + ".json")));
  }
  bool has(const std::string& table) const { return tables_.contains(table); }
  // Adds a row to a table that open() has created.
  void add(const std::string& tableName, const OrderedJson& row) {
    Table& table = tables_.at(tableName);
    table.pendingText += (table.rows++ == 0 ? "[\n" : ",\n") + scalarText(row);
  }
  void flush() {
    for (auto& [name, table] : tables_) {
      table.file.write(table.pendingText);
      table.pendingText.clear();
    }
  }
  void commit() {
    flush();
    for (auto& [name, table] : tables_) {
      table.file.write(table.rows == 0 ? "[]\n" : "\n]\n");
      table.file.commit();
    }
  }

 private:
  struct Table {
    explicit Table(const std::filesystem::path& path) : file(path) {}
    AtomicFile file;
    std::string pendingText;  // text of the rows since the last flush()
    std::size_t rows = 0;
  };

  const ExportFolder& folder_;
  std::map<std::string, Table> tables_;  // tables by name
};

// Return the numbers as a JSON list. Throw an Error that begins with `what` for numbers that are not finite.
inline OrderedJson listOf(const Vec3d& v, const std::string& what) {
  return finiteList({v.x, v.y, v.z}, what);
}
inline OrderedJson listOf(const Quat& q, const std::string& what) {
  return finiteList({q.w, q.x, q.y, q.z}, what);
}

// Adds the rows of sample_annotation and instance for the objects of a sequence. Returns the number of annotations.
std::size_t addAnnotations(const ExportPlan& plan, const ReadObjects& read, std::size_t sequence, NuScenesRows& rows);

}  // namespace scanmill
