#pragma once

// A YAML document as a checked tree in which every node knows its place in the file. This header is installed because
// sensors/sensor.h includes it.
//
//   Value pipeline = readYaml("pipelines/quickstart.yaml");
//   setValue(pipeline, "seed=7");
//   const std::string seed = pipeline.valueOf("seed").text;  // "7"

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
  std::string text;            // Scalar: the text without quotes, with variables expanded
  bool quoted = false;         // Scalar: true if quoted, a block or !!str; such text is never read as a number
  std::vector<Value> items;    // Sequence: its items
  std::vector<Entry> entries;  // Map: its entries in the file's order; keys are unique
  int keyLine = 0;             // line of the key, for a map's entry; 0 if the entry comes from --set
  int keyColumn = 0;
  // Folder in which relative paths start, if --set made the value; empty: the folder of where.file.
  std::string folder;

  const Value* find(std::string_view key) const;     // Map: the value of a key; null if absent
  const Value& valueOf(std::string_view key) const;  // Map: the value of a key; a value of kind Null if absent
  // Sequence: the value of a key in the first item that has the key; null if no item has it
  const Value* findInItems(std::string_view key) const;
};

struct Value::Entry {
  std::string key;
  Value value;
};

// Returns a value of the kind Scalar, with the text `text`.
inline Value scalarValue(std::string text, const Location& where = {}) {
  Value value;
  value.kind = Value::Kind::Scalar;
  value.where = where;
  value.text = std::move(text);
  return value;
}
// Return values of the kinds Sequence and Map.
inline Value sequenceValue(std::vector<Value> items = {}, const Location& where = {}) {
  Value value;
  value.kind = Value::Kind::Sequence;
  value.where = where;
  value.items = std::move(items);
  return value;
}
inline Value mapValue(std::vector<Value::Entry> entries = {}, const Location& where = {}) {
  Value value;
  value.kind = Value::Kind::Map;
  value.where = where;
  value.entries = std::move(entries);
  return value;
}

// Parses one document; `file` is its name in messages. In scalars, `${NAME}` is replaced by the environment variable
// (an error names a variable that is not set), `${NAME:-fallback}` has a fallback for a variable that is not set or
// empty, and `$$` is a dollar. Refuses duplicate keys, cyclic and exploding aliases, a depth over 64 and more than a
// million nodes. Throws InputError with file:line:column.
Value parseYaml(std::string_view text, const std::string& file);
// Reads a file and parses it as parseYaml() does.
Value readYaml(const std::filesystem::path& path);

// Applies an override "dotted.path.0.key=value", as given by --set. Items of lists are named by their index from 0; a
// path that ends in + adds an item. The value is parsed as YAML; null removes an item from its list. Missing keys of
// maps are created without a check: the reader of the map refuses unknown keys later. Relative paths in the value start
// in the folder of the file that `root` was read from. Throws InputError for a dotted path that does not fit the
// document.
void setValue(Value& root, std::string_view assignment);

// Returns a value as YAML on one line, such as "{resolution: 512}"; a value of the kind Null gives "{}".
std::string flowText(const Value& value);

// Returns a text as a YAML scalar in double quotes, on one line, from which parseYaml() reads the same text. Invisible
// characters are escaped. The text must not contain NUL. Throws InputError for a text that is not UTF-8.
std::string quotedValue(std::string_view text);

}  // namespace scanmill
