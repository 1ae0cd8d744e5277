#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cctype>
#include <span>

#include "base/short_text.h"
#include "base/terminal.h"
#include "config/text.h"
#include "config/value.h"
#include "draft/draft.h"

namespace scanmill::draft {
namespace {

// Returns the name of the ontology's class for a concept; empty if the ontology has none.
std::string classFor(const Concept& what, const Ontology& ontology) {
  const SemanticClass* const found = classOf(what, ontology);
  return found == nullptr ? std::string() : found->name;
}

// Returns a glob pattern that matches only this name, with special characters escaped. A first slash is escaped, since
// it could begin a regular expression. NUL, which YAML does not have, becomes "?", which matches any character.
std::string literalPattern(const std::string& name) {
  std::string pattern;
  for (const char c : inUtf8(name)) {
    const bool special = std::string_view("*?[{,}").find(c) != std::string_view::npos || (c == '/' && pattern.empty());
    pattern += special ? fmt::format("[{}]", c) : std::string(1, c == '\0' ? '?' : c);
  }
  return pattern;
}

// Returns a glob pattern for the name in which a star replaces each sequence of digits.
std::string patternWithoutDigits(const std::string& name) {
  std::string pattern;
  for (const char c : literalPattern(name)) {
    if (std::isdigit(static_cast<unsigned char>(c)) == 0) {
      pattern += c;
    } else if (!pattern.ends_with('*')) {
      pattern += '*';
    }
  }
  return pattern;
}

// The keys of a rule that match names of parts. Patterns and names below are in this order.
constexpr std::array<const char*, 3> kKeys{"node", "material", "texture"};

// Returns the part's name for kKeys[key].
std::string nameOf(const GuessedPart& part, std::size_t key) {
  return key == 0 ? part.node : key == 1 ? part.material : std::string(textureName(part.texture));
}

// Glob patterns for kKeys; an empty pattern matches any name.
using Patterns = std::array<std::string, 3>;

bool matchesPart(const Patterns& patterns, const GuessedPart& part) {
  for (std::size_t k = 0; k < patterns.size(); ++k) {
    if (!patterns[k].empty() && !matches(patterns[k], nameOf(part, k), {})) return false;
  }
  return true;
}

// True if all parts that the patterns match show the concept `shown`.
bool matchOnly(const Patterns& patterns, const std::vector<GuessedPart>& parts, const Concept* shown) {
  return std::ranges::all_of(parts,
                             [&](const auto& part) { return part.shows == shown || !matchesPart(patterns, part); });
}

// For a part of a world file, finds the outermost model that contains the part and shows only one concept. Returns
// patterns that match all nodes of this model; empty patterns if there is none. A node's name in a world file consists
// of the names of the model and of the models in it, each followed by a slash, and the node's own name.
Patterns modelPatterns(const GuessedPart& part, const std::vector<GuessedPart>& parts) {
  for (std::size_t slash = part.node.find('/'); slash != std::string::npos; slash = part.node.find('/', slash + 1)) {
    Patterns patterns{patternWithoutDigits(part.node.substr(0, slash)) + "/*", "", ""};
    if (matchOnly(patterns, parts, part.shows)) return patterns;
  }
  return {};
}

// Returns the simplest patterns that match the part and no part with another concept; empty patterns if there are none.
// Tries modelPatterns() first, then the name (node, material or texture) whose words state the part's concept, then the
// other names, then combinations of names.
Patterns patternsFor(const GuessedPart& part, const std::vector<GuessedPart>& parts,
                     const std::vector<Concept>& concepts) {
  if (Patterns patterns = modelPatterns(part, parts); !patterns[0].empty()) return patterns;
  std::vector<std::vector<std::size_t>> keysToTry{{0}, {1}, {2}};  // indices in kKeys
  std::stable_partition(keysToTry.begin(), keysToTry.end(), [&](const std::vector<std::size_t>& keys) {
    return conceptOf(concepts, nameOf(part, keys.front())) == part.shows;
  });
  keysToTry.insert(keysToTry.end(), {{0, 1}, {0, 2}, {1, 2}, {0, 1, 2}});
  for (const std::vector<std::size_t>& keys : keysToTry) {
    for (const auto patternOf : {patternWithoutDigits, literalPattern}) {
      Patterns patterns;
      for (const std::size_t k : keys) patterns[k] = patternOf(nameOf(part, k));
      // An empty name, or a name of digits alone, would give a pattern that matches any name.
      const bool restricts =
          std::ranges::all_of(keys, [&](std::size_t k) { return !patterns[k].empty() && patterns[k] != "*"; });
      if (restricts && matchOnly(patterns, parts, part.shows)) return patterns;
    }
  }
  return {};
}

// Returns the name of a class or material as a value of YAML, quoted only if YAML requires it.
std::string nameValue(const std::string& name) {
  return flowText(scalarValue(name));
}

using PartNames = std::array<std::string, 3>;  // names of a part, in the order of kKeys

// The rules that give the parts of a file their classes, with numbers of triangles.
struct DraftedRules {
  // Rules for one key: for each concept and key (index in kKeys), patterns with their numbers of triangles.
  std::map<std::pair<const Concept*, std::size_t>, std::map<std::string, std::uint64_t>> single;
  // Rules for several keys: for each combination of patterns, the concept and the number of triangles.
  std::map<Patterns, std::pair<const Concept*, std::uint64_t>> several;
  std::map<PartNames, std::uint64_t> unknown;  // triangles of parts whose names state no concept
  bool complete = true;                        // false: no rule matches some of the parts
};

// Writes the classes of one file as keys of an object in YAML. The write functions append to `yaml_`.
class ClassWriter {
 public:
  ClassWriter(const GuessedFile& model, const std::vector<Concept>& concepts, const Ontology& ontology)
      : model_(model), concepts_(concepts), ontology_(ontology) {}

  // Returns the class of all parts or, if they have several, rules and the class of parts without a rule.
  std::string write() {
    if (const Concept* const only = onlyConcept()) {
      writeClassOfRest(*only, model_.byFolder() > 0 ? "   # by the name of the folder" : "");
      return yaml_;
    }
    const DraftedRules rules = draftRules();
    writeInstances();
    if (!rules.single.empty() || !rules.several.empty()) yaml_ += "    rules:\n";
    for (const auto& [patterns, rule] : rules.several) {
      std::vector<std::string> keys;
      for (std::size_t k = 0; k < patterns.size(); ++k) {
        if (!patterns[k].empty()) keys.push_back(fmt::format("{}: {}", kKeys[k], quotedValue(patterns[k])));
      }
      writeRule(fmt::format("{}", fmt::join(keys, ", ")), *rule.first, rule.second);
    }
    for (const auto& [key, patterns] : rules.single) writeAlternatives(kKeys[key.second], *key.first, patterns);
    const Concept* const file = model_.fileConcept.shown;
    if (!rules.complete && file != nullptr && file->kind != ConceptKind::Drop && !classFor(*file, ontology_).empty()) {
      writeClassOfRest(*file, fmt::format("   # for all triangles without a rule: by the name of the {}",
                                          model_.fileConcept.byFolder ? "folder" : "file"));
    }
    writeUnknown(rules.unknown);
    return yaml_;
  }

 private:
  // Returns the concept that all parts have; null if there is none, or if its kind is Drop.
  const Concept* onlyConcept() const {
    const std::vector<GuessedPart>& parts = model_.parts;
    const Concept* const shown = parts.empty() ? nullptr : parts.front().shows;
    const bool isOnly = std::ranges::all_of(parts, [&](const GuessedPart& part) { return part.shows == shown; });
    return isOnly && shown != nullptr && shown->kind != ConceptKind::Drop ? shown : nullptr;
  }

  // Returns rules for the parts whose concept differs from the file's.
  DraftedRules draftRules() const {
    DraftedRules rules;
    const Concept* const file = model_.fileConcept.shown;
    for (const GuessedPart& part : model_.parts) {
      const bool needsNoRule = part.shows == file;  // writeClassOfRest() writes the class of the file
      if (part.shows == nullptr || (part.byFolder && needsNoRule)) {
        rules.unknown[{part.node, part.material, part.texture}] += part.triangles;
      }
      if (part.shows == nullptr || needsNoRule) {
        rules.complete = false;
        continue;
      }
      const Patterns patterns = patternsFor(part, model_.parts, concepts_);
      const auto isUsed = [](const std::string& pattern) { return !pattern.empty(); };
      const auto usedKeys = std::ranges::count_if(patterns, isUsed);
      if (usedKeys == 0) rules.complete = false;
      if (usedKeys == 1) {
        const auto pattern = std::ranges::find_if(patterns, isUsed);
        rules.single[{part.shows, static_cast<std::size_t>(pattern - patterns.begin())}][*pattern] += part.triangles;
      } else if (usedKeys > 1) {
        auto& [shows, triangles] = rules.several[patterns];
        shows = part.shows;
        triangles += part.triangles;
      }
    }
    return rules;
  }

  // Makes each node an instance if the file probably contains several objects.
  void writeInstances() {
    constexpr double kPlaceWidth = 30;  // width (m) above which a file of several nodes counts as a place
    std::set<std::string> nodes;
    for (const GuessedPart& part : model_.parts) nodes.insert(part.node);
    const Vec3d size = model_.box.high - model_.box.low;
    if (nodes.size() > 2 && (model_.frame.severalObjects || std::max(size.x, size.y) > kPlaceWidth))
      yaml_ += "    instances: node   # or part, if one thing has several nodes, such as the walls of a building\n";
  }

  // Writes rules with up to kMost alternative patterns each, such as "{wall*,door*}".
  void writeAlternatives(const char* key, const Concept& c, const std::map<std::string, std::uint64_t>& patterns) {
    constexpr std::size_t kMost = 8;
    for (auto next = patterns.begin(); next != patterns.end();) {
      std::vector<std::string> alternatives;
      std::uint64_t triangles = 0;
      for (; next != patterns.end() && alternatives.size() < kMost; ++next) {
        alternatives.push_back(next->first);
        triangles += next->second;
      }
      const std::string pattern =
          alternatives.size() == 1 ? alternatives[0] : fmt::format("{{{}}}", fmt::join(alternatives, ","));
      writeRule(fmt::format("{}: {}", key, quotedValue(pattern)), c, triangles);
    }
  }

  // Appends one rule. `conditions`: the keys of `match` with their patterns.
  void writeRule(const std::string& conditions, const Concept& c, std::uint64_t triangles) {
    std::string result = "drop: true";
    if (c.kind != ConceptKind::Drop) result = "class: " + nameValue(classFor(c, ontology_));
    if (c.kind != ConceptKind::Drop && !c.material.empty() && !model_.measured) {
      result += ", material: " + nameValue(c.material);
    }
    yaml_ += fmt::format("      - {{match: {{{}}}, {}}}   # {} triangles\n", conditions, result, grouped(triangles));
  }

  void writeClassOfRest(const Concept& c, std::string_view comment) {
    yaml_ += fmt::format("    class: {}{}\n", nameValue(classFor(c, ontology_)), comment);
    if (!c.material.empty() && !model_.measured) yaml_ += fmt::format("    material: {}\n", nameValue(c.material));
  }

  // Lists the parts whose own names state no concept, with their numbers of triangles. If there are many, parts that
  // differ only in the node's name share a line.
  void writeUnknown(std::map<PartNames, std::uint64_t> unknown) {
    constexpr std::size_t kMost = 20;
    if (unknown.empty()) return;
    if (unknown.size() > kMost) {
      std::map<PartNames, std::uint64_t> merged;
      for (const auto& [names, triangles] : unknown) {
        const auto& [node, material, texture] = names;
        merged[{material.empty() && texture.empty() ? node : "", material, texture}] += triangles;
      }
      unknown = std::move(merged);
    }
    std::vector<std::pair<PartNames, std::uint64_t>> sorted(unknown.begin(), unknown.end());
    std::ranges::stable_sort(sorted, std::greater<>(), [](const auto& part) { return part.second; });
    yaml_ +=
        "    # No word shows the classes of these; rules by `color`, `box`, `height` and `size` may separate them "
        "(docs/keys.md):\n";
    for (const auto& [names, triangles] : std::span(sorted).first(std::min(sorted.size(), kMost))) {
      std::vector<std::string> texts;
      for (std::size_t k = 0; k < kKeys.size(); ++k) {
        if (!names[k].empty()) texts.push_back(fmt::format("{} {}", kKeys[k], quotedValue(inUtf8(names[k]))));
      }
      yaml_ += fmt::format("    #   {}: {} triangles\n",
                           texts.empty() ? "no name" : fmt::format("{}", fmt::join(texts, ", ")), grouped(triangles));
    }
    if (sorted.size() > kMost) yaml_ += fmt::format("    #   and {} more\n", sorted.size() - kMost);
  }

  const GuessedFile& model_;
  const std::vector<Concept>& concepts_;
  const Ontology& ontology_;
  std::string yaml_;
};

// Returns the path of a file relative to `folder`, which need not exist. Symbolic links in the file's path are kept,
// since textures may be beside a link. If a link in `folder` makes this path lead to another file, links are resolved.
std::filesystem::path relativePath(const std::filesystem::path& file, const std::filesystem::path& folder) {
  std::error_code error;
  const std::filesystem::path base = std::filesystem::absolute(folder.empty() ? "." : folder).lexically_normal();
  std::filesystem::path path = std::filesystem::absolute(file).lexically_normal().lexically_proximate(base);
  if (std::filesystem::exists(base, error) && !std::filesystem::equivalent(base / path, file, error)) {
    path = std::filesystem::proximate(file, base, error);
    if (error) path = file;
  }
  return path;
}

}  // namespace

std::vector<Concept> conceptsFor(const std::vector<Concept>& concepts, const Ontology& ontology) {
  // Default names of objects in modelling programs. They say nothing about the class, even if a class has such a name.
  static constexpr std::array<std::string_view, 2> kDefaultNames{"box", "object"};
  std::vector<Concept> usable;
  std::ranges::copy_if(concepts, std::back_inserter(usable),
                       [&](const Concept& c) { return c.classes.empty() || classOf(c, ontology) != nullptr; });
  for (const SemanticClass& semanticClass : ontology.classes) {
    const std::string word = foldedName(semanticClass.name);
    const bool isDefault = std::ranges::find(kDefaultNames, word) != kDefaultNames.end();
    if (semanticClass.id == 0 || semanticClass.movingOf || word.empty() || isDefault) continue;
    const auto withWord = std::ranges::find_if(
        usable, [&](const Concept& c) { return std::ranges::find(c.words, word) != c.words.end(); });
    Concept added;
    if (withWord != usable.end()) {
      if (classOf(*withWord, ontology) == &semanticClass || withWord->classes.empty()) continue;
      added = *withWord;  // keeps the kind, the material and the size
      for (Concept& c : usable) std::erase(c.words, word);
    }
    added.name = semanticClass.name;
    added.classes = {semanticClass.name};
    added.words = {word};
    usable.push_back(added);
  }
  return usable;
}

std::string objectYaml(const GuessedFile& model, const std::vector<Concept>& concepts, const Ontology& ontology,
                       const std::filesystem::path& folder, const DraftOptions& options) {
  std::string yaml = fmt::format("  - name: {}\n    file: {}\n", quotedValue(model.name),
                                 quotedValue(relativePath(model.file, folder).string()));
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
  const std::string kind = lowerCase(model.file.extension().string());
  if (const SemanticClass* const ego = kind == ".urdf" ? ontology.find("ego_vehicle") : nullptr) {
    return yaml + fmt::format(
                      "    class: {}   # as the `vehicle` of a pipeline; another class if it stands in a scene\n"
                      "    material: painted_metal\n",
                      nameValue(ego->name));
  }
  return yaml + ClassWriter(model, concepts, ontology).write();
}

}  // namespace scanmill::draft
