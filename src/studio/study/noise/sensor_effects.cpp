#include "study/noise/sensor_effects.h"

#include <algorithm>
#include <vector>

#include "base/error.h"
#include "config/file_kind.h"
#include "config/value.h"

namespace scanmill {

namespace {

std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    lines.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return lines;
}

// A blank line, or a comment that is not indented: what stands between two keys and may belong to the next.
bool standsBetween(const std::string& line) {
  return line.find_first_not_of(" \t\r") == std::string::npos || line.front() == '#';
}

}  // namespace

std::string withEffects(const std::string& text, const std::string& file, const std::string& effects) {
  const Value root = parseYaml(text, file);
  expectKind(root, FileKind::Sensor);
  if (root.kind != Value::Kind::Map || root.entries.empty()) throw InputError({file}, "is no sensor file");
  const bool flow = text.find_first_not_of(" \t\r\n") != std::string::npos && root.where.line > 0 &&
                    text[text.find_first_not_of(" \t\r\n")] == '{';
  if (flow) throw InputError(root.where, "is written as {...}: give each key a line of its own");
  const std::vector<std::string> lines = linesOf(text);
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
  while (end > first && standsBetween(lines[end - 1])) --end;
  std::string result;
  for (std::size_t i = 0; i < first; ++i) result += lines[i] + "\n";
  result += effects;
  for (std::size_t i = end; i < lines.size(); ++i) result += lines[i] + "\n";
  return result;
}

}  // namespace scanmill
