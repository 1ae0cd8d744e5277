#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <set>
#include <utility>

#include "base/short_text.h"
#include "base/terminal.h"
#include "config/value.h"
#include "draft/draft.h"

namespace scanmill::draft {
namespace {

// Returns the name of the ontology's class for a concept; empty if the ontology has none.
std::string classFor(const Concept& what, const Ontology& ontology) {
  const SemanticClass* const known = classOf(what, ontology);
  return known == nullptr ? std::string() : known->name;
}

// Returns a glob pattern that matches only this name, with special characters escaped. A slash at its start could begin
// a regular expression. YAML has no NUL, which any one character stands for.
std::string literal(const std::string& name) {
  std::string out;
  for (const char c : inUtf8(name)) {
    const bool special = std::string_view("*?[{,}").find(c) != std::string_view::npos || (c == '/' && out.empty());
    out += special ? fmt::format("[{}]", c) : std::string(1, c == '\0' ? '?' : c);
  }
  return out;
}

// Returns a glob pattern for the name in which a star replaces each sequence of digits.
std::string withoutDigits(const std::string& name) {
  std::string out;
  for (const char c : literal(name)) {
    if (std::isdigit(static_cast<unsigned char>(c)) == 0) {
      out += c;
    } else if (!out.ends_with('*')) {
      out += '*';
    }
  }
  return out;
}

constexpr std::array<const char*, 3> kKeys{"node", "material", "texture"};

std::string nameOf(const GuessedPart& part, std::size_t key) {
  return key == 0 ? part.node : key == 1 ? part.material : std::string(textureName(part.texture));
}

// Glob patterns for the keys node, material and texture of a rule; an empty pattern matches any name.
using Patterns = std::array<std::string, 3>;

bool matchesPart(const Patterns& patterns, const GuessedPart& part) {
  for (std::size_t k = 0; k < patterns.size(); ++k) {
    if (!patterns[k].empty() && !matches(patterns[k], nameOf(part, k), {})) return false;
  }
  return true;
}

// True if all parts that the patterns match have the concept `wanted`.
bool isConsistent(const Patterns& patterns, const std::vector<GuessedPart>& parts, const Concept* wanted) {
  return std::ranges::all_of(parts, [&](const auto& k) { return k.shows == wanted || !matchesPart(patterns, k); });
}

// Returns a pattern for all nodes of the model in a world to which the part belongs; empty patterns if nodes of the
// model show several concepts. The name of a node in a world file consists of the model's name, a slash and the node's
// name.
Patterns modelPattern(const GuessedPart& part, const std::vector<GuessedPart>& parts) {
  for (std::size_t slash = part.node.find('/'); slash != std::string::npos; slash = part.node.find('/', slash + 1)) {
    const Patterns all{withoutDigits(part.node.substr(0, slash)) + "/*", "", ""};
    if (isConsistent(all, parts, part.shows)) return all;
  }
  return {};
}

// Returns the simplest patterns that match the part and no part with another concept; empty patterns if there are none.
// Tries all nodes of a model in a world first, then names whose words state the part's concept, then other names, then
// several names together.
Patterns patternsFor(const GuessedPart& part, const std::vector<GuessedPart>& parts,
                     const std::vector<Concept>& concepts) {
  if (const Patterns all = modelPattern(part, parts); !all[0].empty()) return all;
  std::vector<std::vector<std::size_t>> keysToTry;  // indices in kKeys
  for (const bool stating : {true, false}) {
    for (std::size_t k = 0; k < kKeys.size(); ++k) {
      const bool states = conceptOf(concepts, nameOf(part, k)) == part.shows;
      if (states == stating) keysToTry.push_back({k});
    }
  }
  keysToTry.insert(keysToTry.end(), {{0, 1}, {0, 2}, {1, 2}, {0, 1, 2}});
  for (const std::vector<std::size_t>& keys : keysToTry) {
    for (const auto patternOf : {withoutDigits, literal}) {
      Patterns patterns;
      bool named = true;
      for (const std::size_t k : keys) {
        const std::string name = nameOf(part, k);
        patterns[k] = patternOf(name);
        named = named && !name.empty() && patterns[k] != "*";
      }
      if (named && isConsistent(patterns, parts, part.shows)) return patterns;
    }
  }
  return {};
}

// Returns the name of a class or material as a value of YAML, without quotes where it needs none.
std::string nameValue(const std::string& name) {
  Value value;
  value.kind = Value::Kind::Scalar;
  value.text = name;
  return flowText(value);
}

using PartNames = std::array<std::string, 3>;  // names of node, material and texture

// The rules that give the parts of a file their classes, with numbers of triangles.
struct DraftedRules {
  // Rules with one pattern: by concept and key (index in kKeys), the patterns.
  std::map<std::pair<const Concept*, std::size_t>, std::map<std::string, std::uint64_t>> single;
  // Rules with patterns of several keys, and their concept.
  std::map<Patterns, std::pair<const Concept*, std::uint64_t>> several;
  std::map<PartNames, std::uint64_t> unknown;  // parts whose own names state no concept
  bool complete = true;                        // false: no rule matches some of the parts
};

// Writes the classes of one file.
class ClassWriter {
 public:
  ClassWriter(const GuessedFile& model, const std::vector<Concept>& concepts, const Ontology& ontology)
      : model_(model), concepts_(concepts), ontology_(ontology) {}

  void write(std::string& yaml) const {
    if (const Concept* const only = onlyConcept()) {
      writeClassOfRest(*only, model_.byFolder() > 0 ? "   # by the name of the folder" : "", yaml);
      return;
    }
    const DraftedRules rules = draftRules();
    writeInstances(yaml);
    if (!rules.single.empty() || !rules.several.empty()) yaml += "    rules:\n";
    for (const auto& [patterns, rule] : rules.several) {
      std::vector<std::string> keys;
      for (std::size_t k = 0; k < patterns.size(); ++k) {
        if (!patterns[k].empty()) keys.push_back(fmt::format("{}: {}", kKeys[k], quotedValue(patterns[k])));
      }
      writeRule(fmt::format("{}", fmt::join(keys, ", ")), *rule.first, rule.second, yaml);
    }
    for (const auto& [key, patterns] : rules.single) writeAlternatives(kKeys[key.second], *key.first, patterns, yaml);
    const Concept* const file = model_.fileConcept;
    if (!rules.complete && file != nullptr && file->kind != ConceptKind::Drop && !classFor(*file, ontology_).empty()) {
      writeClassOfRest(*file,
                       fmt::format("   # for all triangles without a rule: by the name of the {}",
                                   model_.conceptByFolder ? "folder" : "file"),
                       yaml);
    }
    writeUnknown(rules.unknown, yaml);
  }

 private:
  // Returns the concept that all parts have, unless they are to be dropped; null if their concepts differ.
  const Concept* onlyConcept() const {
    const std::vector<GuessedPart>& parts = model_.parts;
    const Concept* const only = parts.empty() ? nullptr : parts.front().shows;
    const bool all = std::ranges::all_of(parts, [&](const GuessedPart& part) { return part.shows == only; });
    return all && only != nullptr && only->kind != ConceptKind::Drop ? only : nullptr;
  }

  DraftedRules draftRules() const {
    DraftedRules rules;
    const Concept* const file = model_.fileConcept;
    for (const GuessedPart& part : model_.parts) {
      const bool asFile = part.shows == file;  // needs no rule: writeClassOfRest() writes the class of the file
      if (part.shows == nullptr || (part.byFolder && asFile)) {
        rules.unknown[{part.node, part.material, part.texture}] += part.triangles;
      }
      if (part.shows == nullptr || asFile) {
        rules.complete = false;
        continue;
      }
      const Patterns patterns = patternsFor(part, model_.parts, concepts_);
      const auto given = [](const std::string& pattern) { return !pattern.empty(); };
      const auto keys = std::ranges::count_if(patterns, given);
      if (keys == 0) rules.complete = false;
      if (keys == 1) {
        const auto pattern = std::ranges::find_if(patterns, given);
        rules.single[{part.shows, static_cast<std::size_t>(pattern - patterns.begin())}][*pattern] += part.triangles;
      } else if (keys > 1) {
        auto& [shows, triangles] = rules.several[patterns];
        shows = part.shows;
        triangles += part.triangles;
      }
    }
    return rules;
  }

  // Makes each node an instance if the file probably contains several objects.
  void writeInstances(std::string& yaml) const {
    constexpr double kPlace = 30;  // width (m) above which a file of several nodes counts as a place
    std::set<std::string> nodes;
    for (const GuessedPart& part : model_.parts) nodes.insert(part.node);
    const Vec3d size = model_.box.high - model_.box.low;
    if (nodes.size() > 2 && (model_.frame.severalObjects || std::max(size.x, size.y) > kPlace))
      yaml += "    instances: node   # or part, if one thing has several nodes, such as the walls of a building\n";
  }

  // Writes rules with up to kMost alternative names each.
  void writeAlternatives(const char* key, const Concept& c, const std::map<std::string, std::uint64_t>& patterns,
                         std::string& yaml) const {
    constexpr std::size_t kMost = 8;
    std::vector<std::string> names;
    std::uint64_t triangles = 0;
    const auto flush = [&] {
      if (names.empty()) return;
      const std::string pattern = names.size() == 1 ? names[0] : fmt::format("{{{}}}", fmt::join(names, ","));
      writeRule(fmt::format("{}: {}", key, quotedValue(pattern)), c, triangles, yaml);
      names.clear();
      triangles = 0;
    };
    for (const auto& [pattern, count] : patterns) {
      names.push_back(pattern);
      triangles += count;
      if (names.size() == kMost) flush();
    }
    flush();
  }

  void writeRule(const std::string& match, const Concept& c, std::uint64_t triangles, std::string& yaml) const {
    std::string gives = "drop: true";
    if (c.kind != ConceptKind::Drop) gives = "class: " + nameValue(classFor(c, ontology_));
    if (c.kind != ConceptKind::Drop && !c.material.empty() && !model_.measured) {
      gives += ", material: " + nameValue(c.material);
    }
    yaml += fmt::format("      - {{match: {{{}}}, {}}}   # {} triangles\n", match, gives, grouped(triangles));
  }

  void writeClassOfRest(const Concept& c, std::string_view comment, std::string& yaml) const {
    yaml += fmt::format("    class: {}{}\n", nameValue(classFor(c, ontology_)), comment);
    if (!c.material.empty() && !model_.measured) yaml += fmt::format("    material: {}\n", nameValue(c.material));
  }

  // Lists the names of parts whose own names state no concept, with their triangles. If there are many, parts that
  // differ only in the node's name share a line.
  static void writeUnknown(std::map<PartNames, std::uint64_t> unknown, std::string& yaml) {
    constexpr std::size_t kMost = 20;
    if (unknown.empty()) return;
    if (unknown.size() > kMost) {
      std::map<PartNames, std::uint64_t> merged;
      for (const auto& [names, triangles] : unknown) {
        merged[{names[1].empty() && names[2].empty() ? names[0] : "", names[1], names[2]}] += triangles;
      }
      unknown = std::move(merged);
    }
    std::vector<std::pair<PartNames, std::uint64_t>> sorted(unknown.begin(), unknown.end());
    std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
    yaml +=
        "    # No word shows the classes of these; rules by `color`, `box`, `height` and `size` may separate them "
        "(docs/keys.md):\n";
    for (std::size_t i = 0; i < std::min(sorted.size(), kMost); ++i) {
      std::vector<std::string> names;
      for (std::size_t k = 0; k < kKeys.size(); ++k) {
        if (!sorted[i].first[k].empty())
          names.push_back(fmt::format("{} {}", kKeys[k], quotedValue(inUtf8(sorted[i].first[k]))));
      }
      yaml +=
          fmt::format("    #   {}: {} triangles\n",
                      names.empty() ? "no name" : fmt::format("{}", fmt::join(names, ", ")), grouped(sorted[i].second));
    }
    if (sorted.size() > kMost) yaml += fmt::format("    #   and {} more\n", sorted.size() - kMost);
  }

  const GuessedFile& model_;
  const std::vector<Concept>& concepts_;
  const Ontology& ontology_;
};

}  // namespace

// Names that programs give to anything, though some ontologies have such a class.
constexpr std::array<std::string_view, 2> kDefaultNames{"box", "object"};

std::vector<Concept> conceptsFor(const std::vector<Concept>& concepts, const Ontology& ontology) {
  std::vector<Concept> found;
  for (const Concept& c : concepts) {
    if (c.classes.empty() || classOf(c, ontology) != nullptr) found.push_back(c);
  }
  for (const SemanticClass& named : ontology.classes) {
    const std::string word = foldedName(named.name);
    const bool isDefault = std::find(kDefaultNames.begin(), kDefaultNames.end(), word) != kDefaultNames.end();
    if (named.id == 0 || named.movingOf || word.empty() || isDefault) continue;
    const auto hasWord = [&](const Concept& c) {
      return std::find(c.words.begin(), c.words.end(), word) != c.words.end();
    };
    const auto other = std::find_if(found.begin(), found.end(), hasWord);
    Concept own{named.name, {named.name}, {}, ConceptKind::Whole, {}, {}, {word}};
    if (other != found.end()) {
      if (classOf(*other, ontology) == &named || other->classes.empty()) continue;
      own = *other;
      own.name = named.name;
      own.classes = {named.name};
      own.words = {word};
      for (Concept& c : found) std::erase(c.words, word);
    }
    found.push_back(own);
  }
  return found;
}

std::string objectYaml(const GuessedFile& model, const std::vector<Concept>& concepts, const Ontology& ontology,
                       const std::filesystem::path& folder, const DraftOptions& options) {
  // The path through symbolic links, since textures may be beside a link. If a link in `folder` makes that path another
  // file's, the path without links.
  std::error_code error;
  const std::filesystem::path from = std::filesystem::absolute(folder.empty() ? "." : folder).lexically_normal();
  std::filesystem::path name = std::filesystem::absolute(model.file).lexically_normal().lexically_proximate(from);
  if (std::filesystem::exists(from, error) && !std::filesystem::equivalent(from / name, model.file, error)) {
    name = std::filesystem::proximate(model.file, from, error);
    if (error) name = model.file;
  }
  const std::string path = quotedValue(name.string());
  std::string yaml = fmt::format("  - name: {}\n    file: {}\n", quotedValue(model.name), path);
  if (options.allowOutside) yaml += "    allow_outside: true\n";
  if (options.leaveOutMissing) yaml += "    missing: leave_out\n";
  const FrameGuess& frame = model.frame;
  if (frame.statedUnit && frame.doubtfulUnit) {
    yaml += fmt::format("    # doubtful, though the file or its format states the unit: {}\n", oneLine(frame.whyUnit));
  } else if (frame.unit != 1 || !frame.whyUnit.empty()) {
    yaml += fmt::format("    unit: {:g}   # {}{}\n", frame.unit, frame.doubtfulUnit ? "doubtful: " : "",
                        oneLine(frame.whyUnit));
  }
  if (!frame.whyUp.empty()) {
    yaml += fmt::format("    up: {}   # {}{}\n", frame.up, frame.doubtfulUp ? "doubtful: " : "", oneLine(frame.whyUp));
  }
  if (model.numbered) {
    yaml +=
        "    # points: {labels: NAME}   # the points have labels: name the ontology of their numbers (`scanmill list "
        "ontologies`)\n";
  }
  ClassWriter(model, concepts, ontology).write(yaml);
  return yaml;
}

}  // namespace scanmill::draft
