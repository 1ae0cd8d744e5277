#include "scene/ontology.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "config/fields.h"
#include "config/file_kind.h"

namespace scanmill {
namespace {

std::array<std::uint8_t, 3> readColor(const Value& value) {
  const std::vector<double> parts = readNumbers(value, "color", {0, 255});
  if (parts.size() != 3) {
    throw InputError(value.where, fmt::format("color must be [red, green, blue], found {} numbers", parts.size()));
  }
  std::array<std::uint8_t, 3> color{};
  for (std::size_t i = 0; i < 3; ++i) {
    if (parts[i] != std::floor(parts[i])) {
      throw InputError(value.where, fmt::format("color must be whole numbers from 0 to 255, found {}", parts[i]));
    }
    color[i] = static_cast<std::uint8_t>(parts[i]);
  }
  return color;
}

SemanticClass readClass(const Value& value) {
  Fields f(value, "class");
  SemanticClass c;
  c.id = static_cast<std::uint16_t>(f.integer("id", 0, 65535));
  c.name = f.text("name");
  c.color = readColor(f.require("color"));
  c.thing = f.boolean("thing", false);
  c.aliases = f.texts("aliases");
  f.also({"moving_of"}).finish();
  if (c.name.empty()) throw InputError(value.where, "a class has an empty name");
  return c;
}

}  // namespace

const SemanticClass* Ontology::find(std::uint16_t id) const {
  for (const SemanticClass& c : classes) {
    if (c.id == id) return &c;
  }
  return nullptr;
}

const SemanticClass* Ontology::find(std::string_view nameOrAlias) const {
  for (const SemanticClass& c : classes) {
    if (c.name == nameOrAlias) return &c;
  }
  for (const SemanticClass& c : classes) {
    if (std::ranges::find(c.aliases, nameOrAlias) != c.aliases.end()) return &c;
  }
  return nullptr;
}

const SemanticClass& Ontology::require(std::string_view nameOrAlias, const Location& where) const {
  if (const SemanticClass* const found = find(nameOrAlias)) return *found;
  std::vector<std::string> names;
  for (const SemanticClass& c : classes) {
    names.push_back(c.name);
    names.insert(names.end(), c.aliases.begin(), c.aliases.end());
  }
  throw InputError(where,
                   fmt::format("ontology '{}' has no class '{}'{}", name, nameOrAlias, suggestion(nameOrAlias, names)));
}

bool sameClasses(const Ontology& a, const Ontology& b) {
  return std::equal(a.classes.begin(), a.classes.end(), b.classes.begin(), b.classes.end(),
                    [](const SemanticClass& x, const SemanticClass& y) {
                      return x.id == y.id && x.name == y.name && x.thing == y.thing;
                    });
}

std::vector<std::string> lostBetween(const Ontology& from, const Ontology& to) {
  std::map<std::uint16_t, std::vector<std::string>> sources;  // id of a class in `to` -> names in `from`
  std::vector<std::string> homeless;
  for (const SemanticClass& c : from.classes) {
    if (const SemanticClass* const found = to.find(c.name)) {
      sources[found->id].push_back(c.name);
    } else {
      homeless.push_back(c.name);
    }
  }
  std::vector<std::string> lines;
  for (const auto& [id, names] : sources) {
    if (names.size() > 1) lines.push_back(fmt::format("{} become {}", fmt::join(names, ", "), to.find(id)->name));
  }
  if (!homeless.empty()) lines.push_back(fmt::format("no class for {}", fmt::join(homeless, ", ")));
  return lines;
}

Ontology readOntology(const std::filesystem::path& path) {
  const Value root = readYaml(path);
  expectKind(root, FileKind::Ontology);
  Fields f(root, "ontology");
  f.also({"name", "source", "classes"}).finish();
  Ontology ontology;
  ontology.name = f.text("name", path.stem().string());
  ontology.source = f.text("source", "");
  const std::vector<Value>& list = readList(f.require("classes"), "classes");
  std::set<std::uint16_t> ids;
  std::map<std::string, std::string> owner;  // name or alias -> name of its class
  for (const Value& item : list) {
    SemanticClass c = readClass(item);
    if (!ids.insert(c.id).second) {
      throw InputError(item.where, fmt::format("class '{}' has id {}, as an earlier class", c.name, c.id));
    }
    std::vector<std::string> words = c.aliases;
    words.push_back(c.name);
    for (const std::string& word : words) {
      const auto [known, isNew] = owner.emplace(word, c.name);
      if (!isNew) {
        throw InputError(item.where, fmt::format("the name '{}' of class '{}' is already a name of class '{}'", word,
                                                 c.name, known->second));
      }
    }
    ontology.classes.push_back(std::move(c));
  }
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Value* of = list[i].find("moving_of");
    if (of == nullptr) continue;
    const SemanticClass& still = ontology.require(readText(*of, "moving_of"), of->where);
    SemanticClass& moving = ontology.classes[i];
    if (!still.thing || !moving.thing || still.id == moving.id) {
      throw InputError(of->where,
                       "moving_of names the class of the same things while they stand still: both need "
                       "`thing: true`");
    }
    for (const SemanticClass& c : ontology.classes) {
      if (c.movingOf == still.id) {
        throw InputError(of->where, fmt::format("the class '{}' is moving_of '{}' already", c.name, still.name));
      }
    }
    moving.movingOf = still.id;
  }
  const SemanticClass* zero = ontology.find(0);
  if (!zero || zero->name != "unlabeled") {
    throw InputError(f.require("classes").where,
                     "class 0 must be there and be named 'unlabeled': it is what no rule matched");
  }
  return ontology;
}

std::vector<std::uint16_t> classIds(const Ontology& ontology, const std::vector<std::string>& names,
                                    const Location& where) {
  std::vector<std::uint16_t> ids;
  ids.reserve(names.size());
  for (const std::string& name : names) ids.push_back(ontology.require(name, where).id);
  return ids;
}

}  // namespace scanmill
