#include "scene/ontology.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "config/fields.h"
#include "config/resources.h"

namespace scanmill {
namespace {

// Reads [red, green, blue], whole numbers from 0 to 255.
std::array<std::uint8_t, 3> readColor(const Value& value) {
  const std::vector<double> channels = readNumbers(value, "color", {0, 255});
  if (channels.size() != 3) {
    throw InputError(value.where, "color must be [red, green, blue], found {} numbers", channels.size());
  }
  std::array<std::uint8_t, 3> color{};
  for (std::size_t i = 0; i < 3; ++i) {
    if (channels[i] != std::floor(channels[i])) {
      throw InputError(value.where, "color must be whole numbers from 0 to 255, found {}", channels[i]);
    }
    color[i] = static_cast<std::uint8_t>(channels[i]);
  }
  return color;
}

// Reads a class, except `moving_of`, which needs the other classes.
SemanticClass readClass(const Value& value) {
  Fields fields(value, "class");
  SemanticClass c{.id = static_cast<std::uint16_t>(fields.integer("id", 0, 65535)),
                  .name = fields.text("name"),
                  .color = readColor(fields.require("color")),
                  .thing = fields.boolean("thing", false),
                  .aliases = fields.texts("aliases"),
                  .movingOf = {},
                  .roadUser = fields.boolean("road_user", false)};
  fields.also({"moving_of"}).finish();
  if (c.name.empty()) throw InputError(value.where, "a class has an empty name");
  return c;
}

// Adds the name and the aliases of a class to the map `classOfName`, with the class's name as their value. Throws
// InputError at `where` if the name or an alias is in the map already.
void addNames(const SemanticClass& added, std::map<std::string, std::string>& classOfName, const Location& where) {
  std::vector<std::string> names = added.aliases;
  names.push_back(added.name);
  for (const std::string& name : names) {
    const auto [entry, isNew] = classOfName.emplace(name, added.name);
    if (isNew) continue;
    throw InputError(where, "the name '{}' of class '{}' is already a name of class '{}'", name, added.name,
                     entry->second);
  }
}

// Reads `moving_of`: sets SemanticClass::movingOf of the class with this index.
void readMovingOf(const Value& movingOf, Ontology& ontology, std::size_t index) {
  const SemanticClass& still = ontology.require(readText(movingOf, "moving_of"), movingOf.where);
  SemanticClass& moving = ontology.classes[index];
  if (!still.thing || !moving.thing || still.id == moving.id) {
    throw InputError(movingOf.where,
                     "moving_of names the class of the same things while they stand still: both need `thing: true`");
  }
  const auto other = std::ranges::find(ontology.classes, still.id, &SemanticClass::movingOf);
  if (other != ontology.classes.end()) {
    throw InputError(movingOf.where, "the class '{}' is moving_of '{}' already", other->name, still.name);
  }
  moving.movingOf = still.id;
}

}  // namespace

const SemanticClass* Ontology::find(std::uint16_t id) const {
  const auto found = std::ranges::find(classes, id, &SemanticClass::id);
  return found == classes.end() ? nullptr : &*found;
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
  throw InputError(where, "ontology '{}' has no class '{}'{}", name, nameOrAlias, suggestion(nameOrAlias, names));
}

bool sameClasses(const Ontology& a, const Ontology& b) {
  return std::equal(a.classes.begin(), a.classes.end(), b.classes.begin(), b.classes.end(),
                    [](const SemanticClass& x, const SemanticClass& y) {
                      return x.id == y.id && x.name == y.name && x.thing == y.thing;
                    });
}

std::vector<std::string> lostBetween(const Ontology& oldOntology, const Ontology& newOntology) {
  std::map<std::uint16_t, std::vector<std::string>> sources;  // names of the old classes, by id of the new class
  std::vector<std::string> missing;
  for (const SemanticClass& c : oldOntology.classes) {
    if (const SemanticClass* const newClass = newOntology.find(c.name)) {
      sources[newClass->id].push_back(c.name);
    } else {
      missing.push_back(c.name);
    }
  }
  std::vector<std::string> lines;
  for (const auto& [id, names] : sources) {
    if (names.size() > 1)
      lines.push_back(fmt::format("{} become {}", fmt::join(names, ", "), newOntology.find(id)->name));
  }
  if (!missing.empty()) lines.push_back(fmt::format("no class for {}", fmt::join(missing, ", ")));
  return lines;
}

Ontology readOntology(const std::filesystem::path& path) {
  const Value root = readYaml(path);
  expectKind(root, FileKind::Ontology);
  Fields fields(root, "ontology");
  fields.also({"name", "source", "classes"}).finish();
  Ontology ontology{.name = fields.text("name", path.stem().string()), .source = fields.text("source", "")};
  const std::vector<Value>& list = readList(fields.require("classes"), "classes");
  std::map<std::string, std::string> classOfName;
  for (const Value& item : list) {
    SemanticClass c = readClass(item);
    if (ontology.find(c.id) != nullptr) {
      throw InputError(item.where, "class '{}' has id {}, as an earlier class", c.name, c.id);
    }
    addNames(c, classOfName, item.where);
    ontology.classes.push_back(std::move(c));
  }
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (const Value* movingOf = list[i].find("moving_of")) readMovingOf(*movingOf, ontology, i);
  }
  const SemanticClass* zero = ontology.find(0);
  if (!zero || zero->name != "unlabeled") {
    throw InputError(fields.require("classes").where,
                     "class 0 must be there and be named 'unlabeled': it is what no rule matched");
  }
  return ontology;
}

std::vector<std::uint16_t> classIds(const Ontology& ontology, const std::vector<std::string>& names,
                                    const Location& where) {
  std::vector<std::uint16_t> ids;
  for (const std::string& name : names) ids.push_back(ontology.require(name, where).id);
  return ids;
}

}  // namespace scanmill
