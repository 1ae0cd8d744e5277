// Finds the known word that an unknown word probably means.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>

#include "config/fields.h"
#include "config/text.h"

namespace scanmill {

namespace {

// Returns the word in lower case, with "-" and " " replaced by "_": nearest() ignores these differences.
std::string folded(std::string_view word) {
  std::string plain = lowerCase(word);
  std::replace_if(
      plain.begin(), plain.end(), [](char c) { return c == '-' || c == ' '; }, '_');
  return plain;
}

// Returns how many insertions, deletions, replacements and swaps of neighbours lead from a to b (optimal string
// alignment).
std::size_t editDistance(std::string_view a, std::string_view b) {
  // Rows of the table of distances between the first i letters of a and the first j letters of b.
  std::vector<std::size_t> beforeLast(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], beforeLast[j - 2] + 1);
    }
    std::swap(beforeLast, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

// True if one of the words begins with the other, such as `yaw` and `yaw_deg`, and both have at least three letters.
bool isPrefix(std::string_view a, std::string_view b) {
  return std::min(a.size(), b.size()) >= 3 && (a.starts_with(b) || b.starts_with(a));
}

// Returns the unit at the end of a name, such as "deg" of "yaw_deg"; empty if there is none.
std::string_view unitOf(std::string_view name) {
  static constexpr std::array<std::string_view, 9> kUnits{"s", "ms", "us", "ns", "m", "mm", "deg", "rad", "hz"};
  const std::size_t line = name.rfind('_');
  const std::string_view end = line == std::string_view::npos ? "" : name.substr(line + 1);
  return std::ranges::find(kUnits, end) == kUnits.end() ? "" : end;
}

}  // namespace

std::string nearest(std::string_view word, const std::vector<std::string>& names) {
  constexpr std::size_t kLongestWord = 100;
  if (word.empty() || word.size() > kLongestWord) return {};
  const std::string foldedWord = folded(word);
  std::string best;
  std::size_t leastCost = 0;
  for (const std::string& name : names) {
    const std::string foldedName = folded(name);
    const std::size_t distance = editDistance(foldedWord, foldedName);
    const std::size_t longest = std::max(foldedWord.size(), foldedName.size());
    const bool hasPrefix = isPrefix(foldedWord, foldedName);
    // A name is near if a third of the letters differ, or fewer; at least one letter must be the same.
    if ((distance > std::max<std::size_t>(1, longest / 3) && !hasPrefix) || distance == longest) continue;
    // If two names are at the same distance, the name that begins the word, or begins with it, counts as nearer.
    const std::size_t cost = 2 * distance - (distance > 0 && hasPrefix ? 1 : 0);
    if (best.empty() || cost < leastCost) {
      best = name;
      leastCost = cost;
    }
  }
  return best;
}

std::string suggestion(std::string_view word, const std::vector<std::string>& names) {
  if (names.empty()) return {};
  const std::string name = nearest(word, names);
  const std::string_view unit = unitOf(name), wordUnit = unitOf(word);
  if (unit != wordUnit && !unit.empty() && !wordUnit.empty()) {
    return fmt::format(" (did you mean '{}'? Its unit is {}, not {})", name, unit, wordUnit);
  }
  if (!name.empty()) return fmt::format(" (did you mean '{}'?)", name);
  return fmt::format(" (known: {})", fmt::join(names, ", "));
}

}  // namespace scanmill
