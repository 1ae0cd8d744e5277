#include "config/value.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <system_error>

#include "base/file.h"
#include "base/terminal.h"
#include "config/text.h"

namespace scanmill {

namespace {

constexpr std::size_t kMaxPathLength = 64;

std::vector<std::string> split(std::string_view path) {
  std::vector<std::string> parts;
  for (;;) {
    const std::size_t dot = path.find('.');
    parts.emplace_back(path.substr(0, dot));
    if (dot == std::string_view::npos) return parts;
    path.remove_prefix(dot + 1);
  }
}

// Converts a part of a dotted path to an index of `list`; throws InputError if this fails. `parent`: name of `list`.
std::size_t readIndex(const std::string& part, const Value& list, const std::string& parent, const Location& where) {
  std::size_t index = 0;
  const char* end = part.data() + part.size();
  const auto [stop, error] = std::from_chars(part.data(), end, index);
  if (error == std::errc::invalid_argument || stop != end) {
    throw InputError(where, "{} is a list: {} must be the number of an item, from 0, or + for a new one", parent,
                     quotedForMessage(part));
  }
  if (error == std::errc() && index < list.items.size()) return index;
  throw InputError(where, list.items.empty()
                              ? fmt::format("{} is an empty list", parent)
                              : fmt::format("item {} of {} is out of range: the list has items 0 to {}, and "
                                            "+ adds one",
                                            part, parent, list.items.size() - 1));
}

// Returns the value of a key in a map or list; adds the key to a map that does not have it. An empty `parent` becomes a
// map; a scalar `parent` is refused. `parentName`: name of `parent` in messages.
Value& childOf(Value& parent, const std::string& key, const std::string& parentName, const Location& where) {
  if (parent.kind == Value::Kind::Scalar) {
    throw InputError(where, "{} is a single value and has no {}: set it to a map, such as {{key: value}}", parentName,
                     quotedForMessage(key));
  }
  if (parent.kind == Value::Kind::Sequence) return parent.items[readIndex(key, parent, parentName, where)];
  parent.kind = Value::Kind::Map;
  const auto found = std::ranges::find(parent.entries, key, &Value::Entry::key);
  if (found != parent.entries.end()) return found->value;
  parent.entries.push_back({key, Value{}});
  parent.entries.back().value.where = where;
  return parent.entries.back().value;
}

void setFolder(Value& value, const std::string& folder) {
  value.folder = folder;
  for (Value& item : value.items) setFolder(item, folder);
  for (Value::Entry& entry : value.entries) setFolder(entry.value, folder);
}

// True if a YAML scalar never needs quotes: not within {...} or [...], not after the "=" of --set, and not in a word
// that is quoted for a shell.
bool staysPlain(const std::string& text) {
  const auto isWord = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.'; };
  const auto isAllowed = [&](char c) {
    return isWord(c) || std::string_view("-+/% ").find(c) != std::string_view::npos;
  };
  const std::size_t first = text.starts_with('-') || text.starts_with('+') ? 1 : 0;  // index after a sign
  return text.size() > first && (isWord(text[first]) || text[first] == '/') && text.back() != ' ' &&
         std::ranges::all_of(text, isAllowed);
}

// Returns the text in double quotes, with escapes for invisible characters.
std::string doubleQuoted(std::string_view text) {
  std::string quoted = "\"";
  for (std::size_t i = 0; i < text.size();) {
    const auto [code, bytes] = utf8At(text, i);
    if (isUnseenControl(code)) {
      quoted += fmt::format("\\u{:04x}", static_cast<unsigned>(code));
    } else {
      if (code == '"' || code == '\\') quoted += '\\';
      quoted += text.substr(i, bytes);
    }
    i += bytes;
  }
  return quoted + '"';
}

// Doubles each dollar, since a single dollar begins a variable in values (but not in keys).
std::string doubledDollars(std::string_view text) {
  std::string doubled;
  for (const char c : text) doubled += c == '$' ? std::string("$$") : std::string(1, c);
  return doubled;
}

// Returns the text of a value that lies within a list or map.
std::string innerText(const Value& value) {
  return value.kind == Value::Kind::Null ? "null" : flowText(value);
}

}  // namespace

const Value* Value::find(std::string_view key) const {
  const auto found = std::ranges::find(entries, key, &Entry::key);
  return found == entries.end() ? nullptr : &found->value;
}

const Value& Value::valueOf(std::string_view key) const {
  static const Value null;
  const Value* const found = find(key);
  return found == nullptr ? null : *found;
}

const Value* Value::findInItems(std::string_view key) const {
  for (const Value& item : items) {
    if (const Value* const found = item.find(key)) return found;
  }
  return nullptr;
}

Value readYaml(const std::filesystem::path& path) {
  std::error_code unknown;
  const std::uintmax_t size = std::filesystem::file_size(path, unknown);
  if (!unknown && size > kMaxYamlBytes) {
    throw InputError({path.string()}, "has {} bytes, but a YAML file may have at most {}", size, kMaxYamlBytes);
  }
  return parseYaml(readFile(path), path.string());
}

void setValue(Value& root, std::string_view assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string_view::npos) {
    throw InputError({fmt::format("--set {}", assignment)},
                     "has no value: write key=value or key.key.0.key=value, such as --set seed=7");
  }
  const std::string_view path = assignment.substr(0, equals);
  const Location where{fmt::format("--set {}", path)};
  std::vector<std::string> keys = split(path);
  if (std::ranges::find(keys, "") != keys.end()) {
    throw InputError(where, "has an empty key: write key=value or key.key.0.key=value, such as --set seed=7");
  }
  if (keys.size() > kMaxPathLength) throw InputError(where, "has more than {} keys", kMaxPathLength);

  Value value = parseYaml(assignment.substr(equals + 1), where.file);
  // For a single value, messages name the key of --set instead of a line and column.
  if (value.kind == Value::Kind::Null || value.kind == Value::Kind::Scalar) value.where = where;
  const std::string folder = std::filesystem::path(root.where.file).parent_path().string();
  setFolder(value, folder.empty() ? "." : folder);

  // Find the list or map that contains the last key; missing maps are created.
  const std::string lastKey = keys.back();
  keys.pop_back();
  Value* parent = &root;
  std::string parentName = "the file";  // for messages
  std::string prefix;                   // dotted path of `parent`
  for (const std::string& key : keys) {
    parent = &childOf(*parent, key, parentName, where);
    prefix += (prefix.empty() ? "" : ".") + key;
    parentName = quotedForMessage(prefix);
  }
  if (parent->kind == Value::Kind::Sequence && lastKey == "+") return parent->items.push_back(std::move(value));
  if (parent->kind == Value::Kind::Sequence && value.kind == Value::Kind::Null) {
    const std::size_t index = readIndex(lastKey, *parent, parentName, where);
    parent->items.erase(parent->items.begin() + static_cast<std::ptrdiff_t>(index));
    return;
  }
  childOf(*parent, lastKey, parentName, where) = std::move(value);
}

std::string flowText(const Value& value) {
  std::string text;
  switch (value.kind) {
    case Value::Kind::Null:
      return "{}";
    case Value::Kind::Scalar:
      return value.quoted || !staysPlain(value.text) ? doubleQuoted(doubledDollars(value.text)) : value.text;
    case Value::Kind::Sequence:
      for (const Value& item : value.items) text += (text.empty() ? "" : ", ") + innerText(item);
      return "[" + text + "]";
    case Value::Kind::Map:
      for (const Value::Entry& e : value.entries) {
        text += fmt::format("{}{}: {}", text.empty() ? "" : ", ", staysPlain(e.key) ? e.key : doubleQuoted(e.key),
                            innerText(e.value));
      }
      return "{" + text + "}";
  }
  return text;
}

std::string quotedValue(std::string_view text) {
  if (!isUtf8(text)) throw InputError({std::string(text)}, "is not UTF-8, and YAML cannot state it: rename it");
  return doubleQuoted(doubledDollars(text));
}

}  // namespace scanmill
