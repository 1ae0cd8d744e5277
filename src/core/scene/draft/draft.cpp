#include "scene/draft/draft.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

#include "base/grouped.h"
#include "scene/assets/asset_parts.h"
#include "scene/surveys/cloud_asset.h"

namespace scanmill::draft {
namespace {

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (static_cast<unsigned char>(c) < 32) {
      out += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
      continue;
    }
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

// A glob that matches the name alone.
std::string literal(const std::string& name) {
  std::string out;
  for (const char c : name) {
    out += std::string_view("*?[{").find(c) == std::string_view::npos ? std::string(1, c) : fmt::format("[{}]", c);
  }
  return out;
}

// The same with a star for each run of digits.
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

// A part, and what is guessed of it.
struct Known {
  const AssetPart* part;
  const Concept* concept_;
  std::uint64_t triangles;
};

constexpr std::array<const char*, 3> kKeys{"node", "material", "texture"};

std::string nameOf(const AssetPart& part, std::size_t key) {
  return key == 0 ? part.node : key == 1 ? part.material : std::string(textureName(part.texture));
}

// Patterns by the keys node, material, texture; empty: any.
using Patterns = std::array<std::string, 3>;

bool matchesPart(const Patterns& patterns, const AssetPart& part) {
  for (std::size_t k = 0; k < patterns.size(); ++k) {
    if (!patterns[k].empty() && !matches(patterns[k], nameOf(part, k), {})) return false;
  }
  return true;
}

// Whether all parts that match are of one concept.
bool isConsistent(const Patterns& patterns, const std::vector<Known>& parts, const Concept* wanted) {
  return std::all_of(parts.begin(), parts.end(),
                     [&](const Known& k) { return k.concept_ == wanted || !matchesPart(patterns, *k.part); });
}

// The plainest patterns that no part of another concept matches; none where there are none. First comes all of a model
// of a world, then names that say what it is.
Patterns patternsFor(const Known& known, const std::vector<Known>& parts, const std::vector<Concept>& concepts) {
  std::vector<std::vector<std::size_t>> choices;
  for (const bool telling : {true, false}) {
    for (std::size_t k = 0; k < kKeys.size(); ++k) {
      const bool tells = conceptOf(concepts, nameOf(*known.part, k)) == known.concept_;
      if (tells == telling) choices.push_back({k});
    }
  }
  choices.insert(choices.end(), {{0, 1}, {0, 2}, {1, 2}, {0, 1, 2}});
  // All of a model in a world, whose nodes have its name before a slash.
  const std::string& node = known.part->node;
  for (std::size_t slash = node.find('/'); slash != std::string::npos; slash = node.find('/', slash + 1)) {
    Patterns all{withoutDigits(node.substr(0, slash)) + "/*", "", ""};
    if (isConsistent(all, parts, known.concept_)) return all;
  }
  for (const std::vector<std::size_t>& keys : choices) {
    for (const bool general : {true, false}) {
      Patterns patterns;
      bool named = true;
      for (const std::size_t k : keys) {
        const std::string name = nameOf(*known.part, k);
        patterns[k] = general ? withoutDigits(name) : literal(name);
        named = named && !name.empty() && patterns[k] != "*";
      }
      if (named && isConsistent(patterns, parts, known.concept_)) return patterns;
    }
  }
  return {};
}

std::string classFor(const Concept& c, const Ontology& ontology) {
  for (const std::string& wanted : c.classes) {
    for (const SemanticClass& known : ontology.classes) {
      const bool alias = std::find(known.aliases.begin(), known.aliases.end(), wanted) != known.aliases.end();
      if (known.name == wanted || alias) return known.name;
    }
  }
  return {};
}

// `measured`: what the file reflects was measured, and stays.
std::string givesOf(const Concept& c, const Ontology& ontology, bool measured) {
  if (c.kind == ConceptKind::Drop) return "drop: true";
  return fmt::format("class: {}{}", classFor(c, ontology),
                     c.material.empty() || measured ? "" : ", material: " + c.material);
}

class Writer {
 public:
  // Concepts that the ontology has no class for mean nothing: in rooms, "office.glb" is no building.
  Writer(const std::vector<Concept>& concepts, const Ontology& ontology, const std::filesystem::path& folder)
      : ontology_(ontology), folder_(folder) {
    for (const Concept& c : concepts) {
      if (c.classes.empty() || !classFor(c, ontology).empty()) concepts_.push_back(c);
    }
  }

  // The lines of an object, but for its place.
  DraftedFile write(const std::filesystem::path& file, std::string& yaml, Box& box) {
    AssetOptions options;
    options.textures = false;
    const Asset asset = readAsset(file, options);
    DraftedFile drafted{file, {}};
    const Concept* const whole = conceptOfFile(concepts_, file);
    measured_ = std::any_of(asset.parts.begin(), asset.parts.end(),
                            [](const AssetPart& part) { return part.texture == kPointIntensity; });
    std::vector<const Concept*> guesses = guessParts(concepts_, asset);
    for (const Concept*& c : guesses) {
      if (c != nullptr && c->classes.empty() && c->kind != ConceptKind::Drop) c = nullptr;  // of what fills the file
    }
    std::vector<Known> parts;
    std::size_t next = 0;
    const auto add = [&](const AssetPart& part) {
      parts.push_back({&part, guesses[next++], part.triangles.size()});
      drafted.triangles += part.triangles.size();
      if (parts.back().concept_ != nullptr) drafted.guessed += part.triangles.size();
      if (parts.back().concept_ != nullptr && parts.back().concept_ == whole) drafted.byFile += part.triangles.size();
    };
    for (const AssetPart& part : asset.parts) add(part);
    for (const InstancedParts& instanced : asset.instanced) {
      for (const AssetPart& part : instanced.parts) add(part);
    }
    drafted.frame = guessFrame(asset, guesses);
    box = placed(asset, drafted.frame);

    std::error_code error;
    std::filesystem::path name = std::filesystem::proximate(file, folder_.empty() ? "." : folder_, error);
    if (error) name = file;
    const bool inFolder = file.filename() == "model.sdf" && !file.parent_path().filename().empty();
    const std::string called = (inFolder ? file.parent_path().filename() : file.stem()).string();
    yaml += fmt::format("  - name: {}\n    file: {}\n", quoted(called), quoted(name.string()));
    if (drafted.frame.unit != 1 || !drafted.frame.whyUnit.empty()) {
      yaml += fmt::format("    unit: {:g}   # {}\n", drafted.frame.unit, drafted.frame.whyUnit);
    }
    if (!drafted.frame.whyUp.empty()) {
      yaml += fmt::format("    up: {}   # {}\n", drafted.frame.up, drafted.frame.whyUp);
    }
    writeClasses(parts, whole, box, yaml);
    return drafted;
  }

 private:
  // The asset's box when it is read with the unit and axis that are guessed.
  static Box placed(const Asset& asset, const FrameGuess& frame) {
    const Box own = boundsOf(asset);
    if (own.empty() || frame.up == asset.up) return {own.low * frame.unit, own.high * frame.unit};
    // From z-up, as it was read, to y-up: (x, y, z) becomes (x, -z, y).
    return {Vec3d{own.low.x, -own.high.z, own.low.y} * frame.unit,
            Vec3d{own.high.x, -own.low.z, own.high.y} * frame.unit};
  }

  void writeClasses(const std::vector<Known>& parts, const Concept* file, const Box& box, std::string& yaml) const {
    const auto isAll = [&](const Concept* c) {
      return std::all_of(parts.begin(), parts.end(), [&](const Known& k) { return k.concept_ == c; });
    };
    const Concept* const only = parts.empty() ? nullptr : parts.front().concept_;
    if (only != nullptr && only->kind != ConceptKind::Drop && isAll(only)) {
      writeRest(*only, "", yaml);
      return;
    }
    std::map<std::pair<const Concept*, std::size_t>, std::map<std::string, std::uint64_t>> single;  // by their one key
    std::map<Patterns, std::pair<const Concept*, std::uint64_t>> several;
    std::map<std::string, std::uint64_t> unknown;
    for (const Known& k : parts) {
      if (k.concept_ == nullptr) {
        unknown[fmt::format("node {}, material {}, texture {}", quoted(k.part->node), quoted(k.part->material),
                            quoted(k.part->texture))] += k.triangles;
        continue;
      }
      if (k.concept_ == file) continue;  // what the rules leave
      const Patterns patterns = patternsFor(k, parts, concepts_);
      const auto keys = std::count_if(patterns.begin(), patterns.end(), [](const auto& p) { return !p.empty(); });
      if (keys == 1) {
        const auto key = std::find_if(patterns.begin(), patterns.end(), [](const auto& p) { return !p.empty(); });
        single[{k.concept_, static_cast<std::size_t>(key - patterns.begin())}][*key] += k.triangles;
      } else if (keys > 1) {
        auto& [c, triangles] = several[patterns];
        c = k.concept_;
        triangles += k.triangles;
      }
    }
    std::set<std::string> nodes;
    for (const Known& k : parts) nodes.insert(k.part->node);
    const Vec3d size = box.high - box.low;
    if (nodes.size() > 2 && std::max(size.x, size.y) > 30) yaml += "    instances: node\n";
    if (!single.empty() || !several.empty()) yaml += "    rules:\n";
    for (const auto& [patterns, rule] : several) {
      std::vector<std::string> keys;
      for (std::size_t k = 0; k < patterns.size(); ++k) {
        if (!patterns[k].empty()) keys.push_back(fmt::format("{}: {}", kKeys[k], quoted(patterns[k])));
      }
      writeRule(fmt::format("{}", fmt::join(keys, ", ")), *rule.first, rule.second, yaml);
    }
    for (const auto& [key, patterns] : single) writeAlternatives(kKeys[key.second], *key.first, patterns, yaml);
    if (file != nullptr && file->kind != ConceptKind::Drop && !classFor(*file, ontology_).empty()) {
      writeRest(*file, "   # of whatever no rule gives one: by the name of the file or its folder", yaml);
    }
    writeUnknown(unknown, yaml);
  }

  // Some names to a rule.
  void writeAlternatives(const char* key, const Concept& c, const std::map<std::string, std::uint64_t>& patterns,
                         std::string& yaml) const {
    constexpr std::size_t kMost = 8;
    std::vector<std::string> names;
    std::uint64_t triangles = 0;
    const auto flush = [&] {
      if (names.empty()) return;
      const std::string pattern = names.size() == 1 ? names[0] : fmt::format("{{{}}}", fmt::join(names, ","));
      writeRule(fmt::format("{}: {}", key, quoted(pattern)), c, triangles, yaml);
      names.clear();
      triangles = 0;
    };
    for (const auto& [pattern, count] : patterns) {
      if (pattern.find(',') != std::string::npos || pattern.find('}') != std::string::npos) {
        writeRule(fmt::format("{}: {}", key, quoted(pattern)), c, count, yaml);
        continue;
      }
      names.push_back(pattern);
      triangles += count;
      if (names.size() == kMost) flush();
    }
    flush();
  }

  void writeRule(const std::string& match, const Concept& c, std::uint64_t triangles, std::string& yaml) const {
    yaml += fmt::format("      - {{match: {{{}}}, {}}}   # {} triangles\n", match, givesOf(c, ontology_, measured_),
                        grouped(triangles));
  }

  void writeRest(const Concept& c, std::string_view comment, std::string& yaml) const {
    yaml += fmt::format("    class: {}{}\n", classFor(c, ontology_), comment);
    if (!c.material.empty() && !measured_) yaml += fmt::format("    material: {}\n", c.material);
  }

  static void writeUnknown(const std::map<std::string, std::uint64_t>& unknown, std::string& yaml) {
    constexpr std::size_t kMost = 20;
    if (unknown.empty()) return;
    std::vector<std::pair<std::string, std::uint64_t>> sorted(unknown.begin(), unknown.end());
    std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
    yaml +=
        "    # No word tells what these are; `color`, `box`, `height` and `size` may tell them apart (docs/keys.md):\n";
    for (std::size_t i = 0; i < std::min(sorted.size(), kMost); ++i) {
      yaml += fmt::format("    #   {}: {} triangles\n", sorted[i].first, grouped(sorted[i].second));
    }
    if (sorted.size() > kMost) yaml += fmt::format("    #   and {} more\n", sorted.size() - kMost);
  }

  std::vector<Concept> concepts_;
  const Ontology& ontology_;
  std::filesystem::path folder_;
  bool measured_ = false;  // the file at hand says what its points reflect
};

// Models are about the origin of their file, or within each other where all are off it alike. Parts of one place share
// its coordinates: most are off the origin, and not within each other.
bool areOnePlace(const std::vector<Box>& boxes) {
  std::vector<Box> away;
  std::copy_if(boxes.begin(), boxes.end(), std::back_inserter(away), [](const Box& box) {
    return !box.empty() && (box.low.x > 0 || box.low.y > 0 || box.high.x < 0 || box.high.y < 0);
  });
  const auto alone = std::count_if(away.begin(), away.end(), [&](const Box& box) {
    const Vec3d middle = (box.low + box.high) * 0.5;
    return std::none_of(away.begin(), away.end(), [&](const Box& other) {
      return &other != &box && middle.x > other.low.x && middle.x < other.high.x && middle.y > other.low.y &&
             middle.y < other.high.y && middle.z > other.low.z && middle.z < other.high.z;
    });
  });
  return boxes.size() > 1 && 2 * static_cast<std::size_t>(alone) > boxes.size();
}

}  // namespace

Draft draftScene(const std::vector<std::filesystem::path>& files, const std::vector<Concept>& concepts,
                 const Ontology& ontology, const std::string& ontologyName, const std::string& name,
                 const std::filesystem::path& folder) {
  constexpr double kGap = 2;  // m between objects
  Draft draft;
  draft.yaml = fmt::format(
      "# A draft: units, axes, classes and materials are guesses by names and sizes. Look at the picture, and at\n"
      "# `scanmill info` of this file, which counts the triangles of each rule.\n"
      "name: {}\nontology: {}\nmaterials: materials\nobjects:\n",
      quoted(name), quoted(ontologyName));
  Writer writer(concepts, ontology, folder);
  std::vector<std::string> objects(files.size());
  std::vector<Box> boxes(files.size());
  for (std::size_t i = 0; i < files.size(); ++i) draft.files.push_back(writer.write(files[i], objects[i], boxes[i]));
  draft.onePlace = areOnePlace(boxes);
  const auto perRow = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(files.size()))));
  double x = 0, y = 0, deepest = 0;
  for (std::size_t i = 0; i < files.size(); ++i) {
    draft.yaml += objects[i];
    const Box& box = boxes[i];
    if (files.size() == 1 || box.empty() || draft.onePlace) continue;
    if (i % perRow == 0) {
      y += deepest + (i == 0 ? 0 : kGap);
      x = deepest = 0;
    }
    draft.yaml += fmt::format("    position: [{:.3f}, {:.3f}, {:.3f}]   # beside the others\n", x - box.low.x,
                              y - box.low.y, -box.low.z);
    x += box.high.x - box.low.x + kGap;
    deepest = std::max(deepest, box.high.y - box.low.y);
  }
  return draft;
}

}  // namespace scanmill::draft
