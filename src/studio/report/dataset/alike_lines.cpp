#include "report/dataset/alike_lines.h"

#include <fmt/core.h>

#include <algorithm>
#include <set>

namespace scanmill {

namespace {

// The numbers in a line, and the texts before, between and after them.
struct Line {
  std::vector<std::string> texts, numbers;
};

Line split(const std::string& line) {
  constexpr const char* kDigits = "0123456789";
  Line parts;
  for (std::size_t at = 0; at != std::string::npos;) {
    const std::size_t digits = std::min(line.find_first_of(kDigits, at), line.size());
    parts.texts.push_back(line.substr(at, digits - at));
    if (digits == line.size()) break;
    const std::size_t end = std::min(line.find_first_not_of(kDigits, digits), line.size());
    parts.numbers.push_back(line.substr(digits, end - digits));
    at = end;
  }
  return parts;
}

bool smaller(const std::string& a, const std::string& b) {
  return a.size() != b.size() ? a.size() < b.size() : a < b;
}

// Merges lines that are equal except for their numbers into one line.
std::string joined(const std::vector<Line>& lines) {
  const Line& first = lines.front();
  std::size_t different = 0, last = 0;
  const auto differs = [&](std::size_t i) {
    return std::ranges::any_of(lines, [&](const Line& l) { return l.numbers[i] != first.numbers[i]; });
  };
  for (std::size_t i = 0; i < first.numbers.size(); ++i) {
    if (differs(i)) ++different, last = i;
  }
  const bool name =
      different == 1 && last + 1 == first.numbers.size() && first.texts.back().empty() && !first.texts[last].empty();
  std::string text;
  for (std::size_t i = 0; i < first.texts.size(); ++i) {
    text += first.texts[i];
    if (i == first.numbers.size()) break;
    if (!differs(i)) {
      text += first.numbers[i];
    } else if (name) {
      text.erase(text.find_last_not_of(" ._-#") + 1);
    } else {
      const auto [least, most] = std::minmax_element(lines.begin(), lines.end(), [&](const Line& a, const Line& b) {
        return smaller(a.numbers[i], b.numbers[i]);
      });
      text += least->numbers[i] + " to " + most->numbers[i];
    }
  }
  if (lines.size() == 1) return text;
  return name ? fmt::format("{} ({})", text, lines.size()) : fmt::format("{} ({} times)", text, lines.size());
}

}  // namespace

std::vector<std::string> alikeLines(const std::vector<std::string>& lines) {
  std::vector<std::vector<Line>> groups;
  std::set<std::string> seen;
  for (const std::string& line : lines) {
    if (!seen.insert(line).second) continue;
    Line parts = split(line);
    const auto group = std::ranges::find_if(
        groups, [&](const auto& g) { return g.front().texts == parts.texts && !parts.numbers.empty(); });
    if (group == groups.end()) {
      groups.push_back({std::move(parts)});
    } else {
      group->push_back(std::move(parts));
    }
  }
  std::vector<std::string> joinedLines;
  joinedLines.reserve(groups.size());
  for (const std::vector<Line>& group : groups) joinedLines.push_back(joined(group));
  return joinedLines;
}

}  // namespace scanmill
