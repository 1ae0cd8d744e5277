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
#include "draft/model.h"

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
  return std::all_of(parts.begin(), parts.end(),
                     [&](const GuessedPart& k) { return k.shows == wanted || !matchesPart(patterns, k); });
}

// Returns the simplest patterns that match the part and no part with another concept; empty patterns if there are none.
// Tries first to match all nodes of a model in a world, then names whose words state the part's concept.
Patterns patternsFor(const GuessedPart& known, const std::vector<GuessedPart>& parts,
                     const std::vector<Concept>& concepts) {
  std::vector<std::vector<std::size_t>> choices;
  for (const bool telling : {true, false}) {
    for (std::size_t k = 0; k < kKeys.size(); ++k) {
      const bool tells = conceptOf(concepts, nameOf(known, k)) == known.shows;
      if (tells == telling) choices.push_back({k});
    }
  }
  choices.insert(choices.end(), {{0, 1}, {0, 2}, {1, 2}, {0, 1, 2}});
  // The name of a node in a world file consists of the model's name, a slash and the node's own name.
  const std::string& node = known.node;
  for (std::size_t slash = node.find('/'); slash != std::string::npos; slash = node.find('/', slash + 1)) {
    Patterns all{withoutDigits(node.substr(0, slash)) + "/*", "", ""};
    if (isConsistent(all, parts, known.shows)) return all;
  }
  for (const std::vector<std::size_t>& keys : choices) {
    for (const bool general : {true, false}) {
      Patterns patterns;
      bool named = true;
      for (const std::size_t k : keys) {
        const std::string name = nameOf(known, k);
        patterns[k] = general ? withoutDigits(name) : literal(name);
        named = named && !name.empty() && patterns[k] != "*";
      }
      if (named && isConsistent(patterns, parts, known.shows)) return patterns;
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

// Returns the part of a rule that assigns class and material for a concept. `measured`: the file has measured
// reflectances, so no material is assigned, which would replace them.
std::string givesOf(const Concept& c, const Ontology& ontology, bool measured) {
  if (c.kind == ConceptKind::Drop) return "drop: true";
  return fmt::format("class: {}{}", nameValue(classFor(c, ontology)),
                     c.material.empty() || measured ? "" : ", material: " + nameValue(c.material));
}

class Writer {
 public:
  Writer(const GuessedFile& model, const std::vector<Concept>& concepts, const Ontology& ontology)
      : model_(model), concepts_(concepts), ontology_(ontology) {}

  void writeClasses(std::string& yaml) const {
    const std::vector<GuessedPart>& parts = model_.parts;
    const Concept* const file = model_.fileConcept;
    const Box& box = model_.box;
    const auto isAll = [&](const Concept* c) {
      return std::all_of(parts.begin(), parts.end(), [&](const GuessedPart& k) { return k.shows == c; });
    };
    const Concept* const only = parts.empty() ? nullptr : parts.front().shows;
    if (only != nullptr && only->kind != ConceptKind::Drop && isAll(only)) {
      writeRest(*only, model_.byFolder() > 0 ? "   # by the name of the folder" : "", yaml);
      return;
    }
    // Numbers of triangles: by pattern for each concept and key; by patterns of several keys, with their concept; and
    // names (node, material and texture) for parts whose own names state no concept.
    std::map<std::pair<const Concept*, std::size_t>, std::map<std::string, std::uint64_t>> single;
    std::map<Patterns, std::pair<const Concept*, std::uint64_t>> several;
    std::map<std::array<std::string, 3>, std::uint64_t> unknown;
    bool someLeft = false;  // some parts are matched by none of the rules
    for (const GuessedPart& k : parts) {
      if (k.shows == nullptr || k.shows == file) someLeft = true;
      if (k.shows == nullptr || (k.byFolder && k.shows == file))
        unknown[{k.node, k.material, k.texture}] += k.triangles;
      if (k.shows == nullptr) continue;
      if (k.shows == file) continue;  // parts with the file's own concept need no rule: writeRest() writes their class
      const Patterns patterns = patternsFor(k, parts, concepts_);
      const auto keys = std::count_if(patterns.begin(), patterns.end(), [](const auto& p) { return !p.empty(); });
      if (keys == 1) {
        const auto key = std::find_if(patterns.begin(), patterns.end(), [](const auto& p) { return !p.empty(); });
        single[{k.shows, static_cast<std::size_t>(key - patterns.begin())}][*key] += k.triangles;
      } else if (keys > 1) {
        auto& [c, triangles] = several[patterns];
        c = k.shows;
        triangles += k.triangles;
      } else {
        someLeft = true;
      }
    }
    std::set<std::string> nodes;
    for (const GuessedPart& k : parts) nodes.insert(k.node);
    const Vec3d size = box.high - box.low;
    if (nodes.size() > 2 && (model_.frame.severalObjects || std::max(size.x, size.y) > 30))
      yaml += "    instances: node   # or part, if one thing has several nodes, such as the walls of a building\n";
    if (!single.empty() || !several.empty()) yaml += "    rules:\n";
    for (const auto& [patterns, rule] : several) {
      std::vector<std::string> keys;
      for (std::size_t k = 0; k < patterns.size(); ++k) {
        if (!patterns[k].empty()) keys.push_back(fmt::format("{}: {}", kKeys[k], quotedValue(patterns[k])));
      }
      writeRule(fmt::format("{}", fmt::join(keys, ", ")), *rule.first, rule.second, yaml);
    }
    for (const auto& [key, patterns] : single) writeAlternatives(kKeys[key.second], *key.first, patterns, yaml);
    if (someLeft && file != nullptr && file->kind != ConceptKind::Drop && !classFor(*file, ontology_).empty()) {
      writeRest(*file,
                "   # for all triangles without a rule: by the name of the " +
                    std::string(model_.conceptByFolder ? "folder" : "file"),
                yaml);
    }
    writeUnknown(std::move(unknown), yaml);
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
    yaml += fmt::format("      - {{match: {{{}}}, {}}}   # {} triangles\n", match,
                        givesOf(c, ontology_, model_.measured), grouped(triangles));
  }

  void writeRest(const Concept& c, std::string_view comment, std::string& yaml) const {
    yaml += fmt::format("    class: {}{}\n", nameValue(classFor(c, ontology_)), comment);
    if (!c.material.empty() && !model_.measured) yaml += fmt::format("    material: {}\n", nameValue(c.material));
  }

  // Lists the names of parts whose own names state no concept, with their triangles. If there are many, parts that
  // differ only in the node's name share a line.
  static void writeUnknown(std::map<std::array<std::string, 3>, std::uint64_t> unknown, std::string& yaml) {
    constexpr std::size_t kMost = 20;
    if (unknown.empty()) return;
    if (unknown.size() > kMost) {
      std::map<std::array<std::string, 3>, std::uint64_t> merged;
      for (const auto& [names, triangles] : unknown) {
        merged[{names[1].empty() && names[2].empty() ? names[0] : "", names[1], names[2]}] += triangles;
      }
      unknown = std::move(merged);
    }
    std::vector<std::pair<std::array<std::string, 3>, std::uint64_t>> sorted(unknown.begin(), unknown.end());
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
  Writer(model, concepts, ontology).writeClasses(yaml);
  return yaml;
}

}  // namespace scanmill::draft
