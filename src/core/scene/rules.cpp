#include "scene/rules.h"

#include <fmt/format.h>

#include <map>
#include <regex>

#include "config/fields.h"

namespace scanmill {
namespace {

// std::regex recurses over the text: longer names could exhaust the stack.
constexpr std::size_t kLongestName = 4096;

bool isRegex(const std::string& pattern) {
  return pattern.size() > 2 && pattern.front() == '/' && pattern.back() == '/';
}

// Compiling costs far more than matching, and each part of an asset meets the same few patterns.
const std::regex& compiled(const std::string& pattern, const Location& where) {
  thread_local std::map<std::string, std::regex> cache;
  const auto known = cache.find(pattern);
  if (known != cache.end()) return known->second;
  try {
    return cache.emplace(pattern, std::regex(pattern.substr(1, pattern.size() - 2))).first->second;
  } catch (const std::regex_error& e) {
    throw InputError(where, fmt::format("bad regular expression {}: {}", pattern, e.what()));
  }
}

// Matches `c` against the set that starts at pattern[at] == '[', and moves `at` behind it. A '[' that is never closed
// stands for itself.
bool matchesSet(std::string_view pattern, std::size_t& at, char c) {
  std::size_t i = at + 1;
  const bool negated = i < pattern.size() && (pattern[i] == '!' || pattern[i] == '^');
  if (negated) ++i;
  const std::size_t close = pattern.find(']', i + 1);
  if (close == std::string_view::npos) {
    ++at;
    return c == '[';
  }
  bool found = false;
  while (i < close) {
    if (i + 2 < close && pattern[i + 1] == '-') {
      found = found || (pattern[i] <= c && c <= pattern[i + 2]);
      i += 3;
    } else {
      found = found || pattern[i] == c;
      ++i;
    }
  }
  at = close + 1;
  return found != negated;
}

// On a mismatch only the latest '*' takes one more character: linear in memory, at worst quadratic in time.
bool matchesGlob(std::string_view pattern, std::string_view text) {
  constexpr std::size_t kNone = std::string_view::npos;
  std::size_t p = 0;
  std::size_t t = 0;
  std::size_t star = kNone;
  std::size_t starText = 0;
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      starText = t;
      continue;
    }
    std::size_t next = p;
    bool fits = false;
    if (p < pattern.size()) {
      if (pattern[p] == '[') {
        fits = matchesSet(pattern, next, text[t]);
      } else {
        fits = pattern[p] == '?' || pattern[p] == text[t];
        next = p + 1;
      }
    }
    if (fits) {
      p = next;
      ++t;
    } else if (star != kNone) {
      p = star + 1;
      t = ++starText;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

std::string readPattern(Fields& match, std::string_view key) {
  const Value* value = match.find(key);
  if (!value) return {};
  std::string pattern = readText(*value, key);
  if (pattern.empty()) {
    throw InputError(value->where, fmt::format("the pattern of '{}' is empty; leave it out, or write \"*\"", key));
  }
  if (isRegex(pattern)) compiled(pattern, value->where);
  return pattern;
}

Rule readRule(const Value& value) {
  Fields f(value, "rule");
  Rule rule;
  rule.where = value.where;
  const Value& match = f.require("match");
  if (match.kind == Value::Kind::Scalar) {
    if (match.text != "any") {
      throw InputError(match.where, fmt::format("match must be 'any' or a map of patterns such as {{node: \"tree*\"}}, "
                                                "found '{}'",
                                                match.text));
    }
  } else {
    Fields m(match, "match");
    rule.node = readPattern(m, "node");
    rule.material = readPattern(m, "material");
    rule.texture = readPattern(m, "texture");
    rule.file = readPattern(m, "file");
    m.finish();
    if (rule.node.empty() && rule.material.empty() && rule.texture.empty() && rule.file.empty()) {
      throw InputError(match.where, "match names no pattern: give node, material, texture or file, or write 'any'");
    }
  }
  rule.className = f.text("class", "");
  rule.materialName = f.text("material", "");
  f.finish();
  if (rule.className.empty() && rule.materialName.empty()) {
    throw InputError(value.where, "the rule sets neither class nor material");
  }
  return rule;
}

bool fits(const Rule& rule, const Names& names) {
  const auto holds = [&](const std::string& pattern, std::string_view text) {
    return pattern.empty() || matches(pattern, text, rule.where);
  };
  return holds(rule.node, names.node) && holds(rule.material, names.material) && holds(rule.texture, names.texture) &&
         holds(rule.file, names.file);
}

}  // namespace

std::vector<Rule> readRules(const Value& value) {
  if (value.kind == Value::Kind::Null) return {};
  if (value.kind != Value::Kind::Sequence) throw InputError(value.where, "rules must be a list of rules");
  std::vector<Rule> rules;
  rules.reserve(value.items.size());
  for (const Value& item : value.items) rules.push_back(readRule(item));
  return rules;
}

bool matches(const std::string& pattern, std::string_view text, const Location& where) {
  if (!isRegex(pattern)) return matchesGlob(pattern, text);
  if (text.size() > kLongestName) {
    throw InputError(where, fmt::format("a name of {} characters is too long for a regular expression (at most {}); "
                                        "use a glob",
                                        text.size(), kLongestName));
  }
  try {
    return std::regex_search(text.begin(), text.end(), compiled(pattern, where));
  } catch (const std::regex_error& e) {
    throw InputError(where, fmt::format("regular expression {} fails on '{}': {}", pattern, text, e.what()));
  }
}

Verdict matchRules(const std::vector<Rule>& rules, const Names& names) {
  Verdict verdict;
  for (const Rule& rule : rules) {
    const bool wanted =
        (!verdict.className && !rule.className.empty()) || (!verdict.material && !rule.materialName.empty());
    if (!wanted || !fits(rule, names)) continue;
    if (!verdict.className && !rule.className.empty()) verdict.className = &rule;
    if (!verdict.material && !rule.materialName.empty()) verdict.material = &rule;
    if (verdict.className && verdict.material) break;
  }
  return verdict;
}

}  // namespace scanmill
