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
  const std::size_t at = line.find_first_not_of(" \t");
  return at != std::string::npos && line[at] == '#';
}

// True for a blank line or a comment without indentation: such a line between two keys may belong to the second key.
bool isBetweenKeys(const std::string& line) {
  return line.find_first_not_of(" \t\r") == std::string::npos || line.front() == '#';
}

// Returns the lines of the file's effects that are not replaced, each with the comments above it. `first`: index of the
// line with the key. `end`: index of the line after its value.
std::string keptEffects(const Value& list, const std::vector<std::string>& lines, std::size_t first, std::size_t end,
                        const std::string& file, const std::string& effects) {
  const Value fitted = parseYaml(effects, file);
  std::vector<std::string> replaced;
  for (const Value& item : fitted.find("effects")->items) replaced.push_back(readNamed(item, "an effect").name);
  if (std::ranges::find(replaced, "range_noise") != replaced.end()) {
    replaced.insert(replaced.end(), {"dropout", "shell", "quantize"});
  }
  // The noise of a fitted response stands for speckle too.
  if (std::ranges::find(replaced, "intensity") != replaced.end()) replaced.emplace_back("speckle");
  std::string kept;
  std::size_t begin = first + 1;  // first line of an item, with the comments above it
  for (std::size_t i = 0; i < list.items.size(); ++i) {
    // An item ends before the comments above the next item.
    std::size_t stop = i + 1 < list.items.size() ? static_cast<std::size_t>(list.items[i + 1].where.line - 1) : end;
    const auto itemLine = static_cast<std::size_t>(list.items[i].where.line - 1);
    while (i + 1 < list.items.size() && stop > itemLine + 1 && isComment(lines[stop - 1])) --stop;
    if (stop <= itemLine) throw InputError(list.items[i].where, "two effects on one line: give each a line of its own");
    const std::string name = readNamed(list.items[i], "an effect").name;
    if (std::ranges::find(replaced, name) == replaced.end()) {
      for (std::size_t l = begin; l < stop; ++l) kept += lines[l] + "\n";
    }
    begin = stop;
  }
  return kept;
}

}  // namespace

std::string withEffects(const std::string& text, const std::string& file, const std::string& effects) {
  const Value root = parseYaml(text, file);
  expectKind(root, FileKind::Sensor);
  if (root.kind != Value::Kind::Map || root.entries.empty()) throw InputError({file}, "is not a sensor file");
  const bool flow = text.find_first_not_of(" \t\r\n") != std::string::npos && root.where.line > 0 &&
                    text[text.find_first_not_of(" \t\r\n")] == '{';
  if (flow) throw InputError(root.where, "is written as {...}: give each key a line of its own");
  std::vector<std::string> lines;
  std::istringstream reading(text);
  for (std::string line; std::getline(reading, line);) lines.push_back(line);
  std::size_t first = lines.size();
  std::size_t end = lines.size();
  for (const Value::Entry& entry : root.entries) {
    const auto line = static_cast<std::size_t>(entry.value.keyLine - 1);
    if (entry.key == "effects") {
      first = line;
    } else if (first < lines.size() && line > first) {
      end = std::min(end, line);
    }
  }
  while (end > first && isBetweenKeys(lines[end - 1])) --end;
  std::string result;
  for (std::size_t i = 0; i < first; ++i) result += lines[i] + "\n";
  const Value* own = root.find("effects");
  const bool list = own != nullptr && own->kind == Value::Kind::Sequence && !own->items.empty() &&
                    own->items.front().where.line > static_cast<int>(first) + 1;
  const std::string kept = list ? keptEffects(*own, lines, first, end, file, effects) : "";
  const std::string key = "effects:\n";
  result += kept.empty() ? effects : key + kept + effects.substr(key.size());
  for (std::size_t i = end; i < lines.size(); ++i) result += lines[i] + "\n";
  return result;
}

}  // namespace scanmill
