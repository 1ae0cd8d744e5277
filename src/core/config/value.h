#pragma once

// A YAML document as a checked, immutable tree whose every node knows its place in the file.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace scanmill {

struct Value {
  enum class Kind { Null, Scalar, Sequence, Map };
  struct Entry;

  Kind kind = Kind::Null;
  Location where;
  std::string text;            // Scalar: as written, variables expanded
  bool quoted = false;         // Scalar: "..." or '...', hence a string whatever it looks like
  std::vector<Value> items;    // Sequence
  std::vector<Entry> entries;  // Map, in the file's order, keys unique
  int keyLine = 0;             // where the key stands, for a map's entry; 0 where --set made it
  int keyColumn = 0;
  std::string folder;  // where its relative paths start, of what --set made; else empty: the folder of where.file

  const Value* find(std::string_view key) const;     // Map: null where absent
  const Value& valueOf(std::string_view key) const;  // Map: one of kind Null where absent
};

struct Value::Entry {
  std::string key;
  Value value;
};

// Parses one document; `file` names it in places. `${NAME}` in scalars is replaced by the environment variable; one
// that is not set is an error that names it. `${NAME:-fallback}` gives a fallback for a variable that is not set or
// empty; `$$` is a dollar. Refuses duplicate keys, cyclic and exploding aliases, a depth over 64 and more than a
// million nodes. Throws InputError with file:line:column.
Value parseYaml(std::string_view text, const std::string& file);
// Does the same with a file.
Value readYaml(const std::filesystem::path& path);

// Applies an override "dotted.path.0.key=value", as given by --set; items of lists are named by their index from 0, and
// the value is parsed as YAML; null takes an item out of its list. Keys of maps that are missing are made: whoever
// reads the map refuses those that it does not know, with a suggestion. Relative paths in the value start in the folder
// of the file that `root` was read from, as those beside them do. Throws InputError for a path that does not fit the
// document.
void setValue(Value& root, std::string_view assignment);

}  // namespace scanmill
