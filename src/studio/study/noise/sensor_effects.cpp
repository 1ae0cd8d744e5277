#include <algorithm>
#include <sstream>
#include <vector>

#include "base/error.h"
#include "config/fields.h"
#include "config/file_kind.h"
#include "config/value.h"
#include "study/noise/fit_noise.h"

namespace scanmill {

namespace {

bool isComment(const std::string& line) {
  const std::size_t start = line.find_first_not_of(" \t");
  return start != std::string::npos && line[start] == '#';
}

// True for a blank line or a comment without indentation: such a line between two keys may belong to the second key.
bool isBetweenKeys(const std::string& line) {
  return line.find_first_not_of(" \t\r") == std::string::npos || line.front() == '#';
}

// Lines of a file, from `first` to before `end`.
struct LineSpan {
  std::size_t first, end;
};

std::string linesOf(const std::vector<std::string>& lines, LineSpan span) {
  std::string text;
  for (std::size_t i = span.first; i < span.end; ++i) text += lines[i] + "\n";
  return text;
}

// Returns the lines of the file's effects that are not replaced, each with the comments above it. `list`: the file's
// effects. `key`: the lines of the key `effects` and its value. `newEffects`: see withEffects().
std::string keptEffects(const Value& list, const std::vector<std::string>& lines, LineSpan key,
                        const std::string& newEffects) {
  std::vector<std::string> replaced;
  for (const Value& item : parseYaml(newEffects, list.where.file).find("effects")->items) {
    replaced.push_back(readNamed(item, "an effect").name);
  }
  const auto isReplaced = [&](std::string_view name) { return std::ranges::find(replaced, name) != replaced.end(); };
  if (isReplaced("range_noise")) replaced.insert(replaced.end(), {"dropout", "shell", "quantize"});
  // The noise of a fitted response stands for speckle too.
  if (isReplaced("intensity")) replaced.emplace_back("speckle");
  std::string kept;
  LineSpan item{key.first + 1, 0};  // an item with the comments above it
  for (std::size_t i = 0; i < list.items.size(); ++i, item.first = item.end) {
    const auto nameLine = static_cast<std::size_t>(list.items[i].where.line - 1);
    item.end = key.end;
    if (i + 1 < list.items.size()) {
      // The item ends before the comments above the next item.
      item.end = static_cast<std::size_t>(list.items[i + 1].where.line - 1);
      while (item.end > nameLine + 1 && isComment(lines[item.end - 1])) --item.end;
    }
    if (item.end <= nameLine) {
      throw InputError(list.items[i].where, "two effects on one line: give each a line of its own");
    }
    if (!isReplaced(readNamed(list.items[i], "an effect").name)) kept += linesOf(lines, item);
  }
  return kept;
}

}  // namespace

std::string withEffects(const std::string& text, const std::string& file, const std::string& effects) {
  const Value root = parseYaml(text, file);
  expectKind(root, FileKind::Sensor);
  if (root.kind != Value::Kind::Map || root.entries.empty()) throw InputError({file}, "is not a sensor file");
  const std::size_t start = text.find_first_not_of(" \t\r\n");
  if (start != std::string::npos && root.where.line > 0 && text[start] == '{') {
    throw InputError(root.where, "is written as {...}: give each key a line of its own");
  }
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  // The lines of the key `effects` and its value, which end at the next key; at the file's end if the key is absent.
  LineSpan key{lines.size(), lines.size()};
  for (const Value::Entry& entry : root.entries) {
    const auto line = static_cast<std::size_t>(entry.value.keyLine - 1);
    if (entry.key == "effects") {
      key.first = line;
    } else if (key.first < lines.size() && line > key.first) {
      key.end = std::min(key.end, line);
    }
  }
  while (key.end > key.first && isBetweenKeys(lines[key.end - 1])) --key.end;
  const Value* const list = root.find("effects");
  const bool isBlockList = list != nullptr && list->kind == Value::Kind::Sequence && !list->items.empty() &&
                           list->items.front().where.line > static_cast<int>(key.first) + 1;
  const std::string kept = isBlockList ? keptEffects(*list, lines, key, effects) : "";
  const std::string keyLine = "effects:\n";
  return linesOf(lines, {0, key.first}) + (kept.empty() ? effects : keyLine + kept + effects.substr(keyLine.size())) +
         linesOf(lines, {key.end, lines.size()});
}

}  // namespace scanmill
