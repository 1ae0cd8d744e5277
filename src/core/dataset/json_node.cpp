#include "dataset/json_node.h"

#include <cmath>

namespace scanmill {

namespace {

Location placeOfByte(const std::string& text, std::size_t byte, const std::string& file) {
  const std::string_view before = std::string_view(text).substr(0, byte == 0 ? 0 : std::min(byte - 1, text.size()));
  const std::size_t lineStart = before.rfind('\n') + 1;  // if there is no line break, npos + 1 is 0
  return {file, static_cast<int>(std::count(before.begin(), before.end(), '\n')) + 1,
          static_cast<int>(before.size() - lineStart) + 1};
}

}  // namespace

Json parseJson(const std::string& text, const std::string& file) {
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    // The message begins "[json.exception.parse_error.101] parse error at line 1, column 2: syntax error while ..."
    const std::string_view what = error.what();
    const std::size_t colon = what.find(": ");
    throw InputError(
        placeOfByte(text, error.byte, file),
        fmt::format("is not complete JSON: {}", colon == std::string_view::npos ? what : what.substr(colon + 2)));
  } catch (const Json::exception& error) {
    throw InputError({file}, fmt::format("is not valid JSON: {}", reasonOf(error)));
  }
}

Pose poseOf(const JsonNode& node) {
  node.keys({"rotation", "translation"});
  const std::vector<double> q = node["rotation"].numbers(4);
  const std::vector<double> t = node["translation"].numbers(3);
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(std::abs(norm - 1) < 1e-6))
    node["rotation"].fail(fmt::format("is not a unit quaternion (its norm is {})", norm));
  return {{q[0], q[1], q[2], q[3]}, {t[0], t[1], t[2]}};
}

Ontology ontologyOf(const JsonNode& node) {
  node.keys({"name", "source", "classes"});
  Ontology ontology{node["name"].text(), node["source"].text(), {}};
  node["classes"].forEach([&](const JsonNode& item) {
    item.keys({"id", "name", "color", "thing"}, {"aliases"});
    SemanticClass c;
    c.id = item["id"].integer<std::uint16_t>();
    c.name = item["name"].text();
    std::vector<std::uint8_t> color;
    item["color"].forEach([&](const JsonNode& part) { color.push_back(part.integer<std::uint8_t>()); });
    if (color.size() != 3) item["color"].fail("is not [red, green, blue]");
    std::copy(color.begin(), color.end(), c.color.begin());
    c.thing = item["thing"].boolean();
    if (item.has("aliases")) c.aliases = item["aliases"].texts();
    for (const SemanticClass& other : ontology.classes) {
      if (other.id == c.id) item["id"].fail(fmt::format("{} is also the id of '{}'", c.id, other.name));
      if (other.name == c.name) item["name"].fail(fmt::format("'{}' is also the name of class {}", c.name, other.id));
    }
    ontology.classes.push_back(std::move(c));
  });
  return ontology;
}

std::uint16_t classOf(const JsonNode& node, const Ontology& ontology, const std::string& id, const std::string& name) {
  const std::uint16_t number = node[id].integer<std::uint16_t>();
  const SemanticClass* known = ontology.find(number);
  if (known == nullptr) node[id].fail(fmt::format("class {} is not in ontology '{}'", number, ontology.name));
  if (node[name].text() != known->name) {
    node[name].fail(fmt::format("class {} is '{}' in the ontology", number, known->name));
  }
  return number;
}

namespace {

// Returns the item of which an earlier version stored the line, see lineOf().
ModelledItem itemOfLine(const std::string& line) {
  constexpr std::string_view kLeftOut = ": left out";
  const std::size_t at = line.find(kLeftOut);
  if (at == std::string::npos) return {"", line};
  std::string why = line.substr(at + kLeftOut.size());
  if (!why.empty() && !why.starts_with(' ') && !why.starts_with(", ")) return {"", line};
  why.erase(0, why.find_first_not_of(", "));
  return {line.substr(0, at), why, true};
}

}  // namespace

std::vector<ModelledItem> modelledOf(const JsonNode& list, bool mayBeTexts) {
  std::vector<ModelledItem> items;
  list.forEach([&](const JsonNode& node) {
    if (mayBeTexts && node.isText()) {
      items.push_back(itemOfLine(node.text()));
      return;
    }
    node.keys({"topic", "left_out", "text"}, {"sensor", "options", "scenes", "parts"});
    ModelledItem item{node["topic"].text(), node["text"].text(), node["left_out"].boolean()};
    if (node.has("sensor")) item.sensor = node["sensor"].text();
    if (node.has("options")) item.options = node["options"].text();
    if (node.has("scenes")) item.scenes = node["scenes"].texts();
    if (node.has("parts")) item.parts = node["parts"].integer<std::uint64_t>(1);
    items.push_back(std::move(item));
  });
  return items;
}

}  // namespace scanmill
