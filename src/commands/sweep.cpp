#include "commands/sweep.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "base/error.h"
#include "config/value.h"
#include "pipeline/read/effects.h"

namespace scanmill {

namespace {

constexpr std::size_t kMostSets = 1000;

// Returns the text as a part of a folder's name, at most 40 characters: each run of characters that some file systems
// do not allow becomes '-' or, at an end of the text, is removed. Returns "none" if no character remains.
std::string plainName(const std::string& text) {
  constexpr std::size_t kLongest = 40;
  std::string name;
  for (const char c : text) {
    const bool isValid =
        std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '+' || c == '-' || c == '_';
    if (isValid) {
      name += c;
    } else if (!name.empty() && name.back() != '-') {
      name += '-';
    }
  }
  while (!name.empty() && name.back() == '-') name.pop_back();
  return name.empty() ? "none" : name.substr(0, kLongest);
}

// Returns the last name in a dotted key, with any list indices after this name: "preset" for "sensors.0.preset",
// "effects.2" for "effects.2".
std::string shortKey(const std::string& key) {
  const std::size_t dot = key.rfind('.');
  if (dot == std::string::npos) return key;
  const std::string lastName = key.substr(dot + 1);
  const bool isIndex = lastName.find_first_not_of("0123456789") == std::string::npos;
  return isIndex ? shortKey(key.substr(0, dot)) + "." + lastName : lastName;
}

struct Sweep {
  std::string key;
  std::vector<std::string> values;  // values as YAML texts without line breaks
};

Sweep parseSweep(const std::string& text) {
  const std::size_t equals = text.find('=');
  const auto fail = [&](const std::string& why) {
    throw InputError(fmt::format(
        "--sweep must be KEY=[A, B, ...], such as 'sensors.0.preset=[os1_128, hdl_64e]', not '{}'{}", text, why));
  };
  if (equals == 0 || equals == std::string::npos) fail("");
  Sweep sweep{text.substr(0, equals), {}};
  const Value list = parseYaml(text.substr(equals + 1), "--sweep " + sweep.key);
  if (list.kind != Value::Kind::Sequence) fail(": the value is not a list");
  if (list.items.empty()) fail(": the list is empty");
  for (const Value& value : list.items) {
    sweep.values.push_back(value.kind == Value::Kind::Null ? "null" : flowText(value));
  }
  return sweep;
}

}  // namespace

std::vector<SweepSet> sweepSets(const std::vector<std::string>& sweeps) {
  std::vector<Sweep> parsed;
  for (const std::string& text : sweeps) parsed.push_back(parseSweep(text));
  std::vector<SweepSet> sets{{}};  // combinations of the values of all sweeps so far; at first an empty one
  std::set<std::string> keys;
  for (const Sweep& sweep : parsed) {
    if (!keys.insert(sweep.key).second) throw InputError(fmt::format("--sweep {}: the key is given twice", sweep.key));
    if (sets.size() * sweep.values.size() > kMostSets) {
      throw InputError(fmt::format("--sweep: more than {} combinations", kMostSets));
    }
    const std::string brief = shortKey(sweep.key);
    const bool unique = std::ranges::count_if(parsed, [&](const Sweep& s) { return shortKey(s.key) == brief; }) == 1;
    std::vector<SweepSet> extendedSets;
    for (const SweepSet& set : sets) {
      for (const std::string& value : sweep.values) {
        SweepSet& extended = extendedSets.emplace_back(set);
        if (!extended.folder.empty()) extended.folder += ',';
        extended.folder += plainName(unique ? brief : sweep.key) + "=" + plainName(value);
        extended.overrides.push_back(sweep.key + "=" + value);
      }
    }
    sets = std::move(extendedSets);
  }
  std::set<std::string> folders;  // names so far; a number is appended to a name that would occur again
  for (SweepSet& set : sets) {
    std::string folder = set.folder;
    for (int number = 2; !folders.insert(folder).second; ++number) folder = fmt::format("{}_{}", set.folder, number);
    set.folder = folder;
  }
  return sets;
}

std::string corruptionSweep() {
  std::string values = "null";
  for (const std::string& name : corruptionNames()) {
    for (const std::string& severity : severities()) values += fmt::format(", {{{}: {}}}", name, severity);
  }
  return fmt::format("corruption=[{}]", values);
}

}  // namespace scanmill
