#include "scene/things.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <regex>
#include <set>

#include "scene/connected_parts.h"

namespace scanmill {
namespace {

using Numbers = std::vector<std::vector<std::uint32_t>>;

// Numbers from 1 in the order of the keys' lowest nodes.
template <class KeyOf>
Numbers byKeys(const std::vector<ThingTriangles>& triangles, const KeyOf& keyOf) {
  using Key = decltype(keyOf(*triangles.front().part));
  std::map<Key, std::uint32_t> lowest;
  for (const ThingTriangles& t : triangles) {
    const auto node = static_cast<std::uint32_t>(t.part->nodeIndex);
    const auto [known, added] = lowest.emplace(keyOf(*t.part), node);
    if (!added) known->second = std::min(known->second, node);
  }
  std::vector<std::pair<std::uint32_t, Key>> order;
  for (const auto& [key, node] : lowest) order.emplace_back(node, key);
  std::sort(order.begin(), order.end());
  std::map<Key, std::uint32_t> numbers;
  for (const auto& [node, key] : order) numbers.emplace(key, static_cast<std::uint32_t>(numbers.size() + 1));
  Numbers found;
  for (const ThingTriangles& t : triangles) {
    found.emplace_back(t.part->triangles.size(), numbers.at(keyOf(*t.part)));
  }
  return found;
}

Numbers byConnection(const std::vector<ThingTriangles>& triangles) {
  Numbers found(triangles.size());
  std::set<std::uint16_t> classes;
  for (const ThingTriangles& t : triangles) classes.insert(t.semantic);
  std::uint32_t before = 0;
  for (const std::uint16_t semantic : classes) {
    std::vector<const AssetPart*> parts;
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      if (triangles[i].semantic != semantic) continue;
      parts.push_back(triangles[i].part);
      places.push_back(i);
    }
    const ConnectedParts connected = connect(parts);
    const std::vector<std::uint32_t> things = thingsOf(connected.boxes);
    for (std::size_t p = 0; p < parts.size(); ++p) {
      for (const std::uint32_t number : connected.of[p]) found[places[p]].push_back(before + things[number] + 1);
    }
    if (!things.empty()) before += *std::max_element(things.begin(), things.end()) + 1;
  }
  return found;
}

}  // namespace

std::string ThingBounds::text() const {
  return fmt::format("{} {}", static_cast<int>(by), pattern);
}

ThingBounds readThingBounds(Fields& object, ThingBounds::By fallback) {
  ThingBounds bounds;
  bounds.by = fallback;
  const Value* const value = object.find("instances");
  if (value == nullptr) return bounds;
  bounds.where = value->where;
  const bool pattern = value->kind == Value::Kind::Scalar && value->text.size() > 2 && value->text.front() == '/' &&
                       value->text.back() == '/';
  if (!pattern) {
    const std::string word = object.choice("instances", {"object", "node", "part", "/regular expression/"}, "");
    bounds.by = word == "object" ? ThingBounds::By::Object
                : word == "node" ? ThingBounds::By::Node
                                 : ThingBounds::By::Part;
    return bounds;
  }
  bounds.by = ThingBounds::By::Name;
  bounds.pattern = value->text.substr(1, value->text.size() - 2);
  try {
    const std::regex checked(bounds.pattern, std::regex::ECMAScript);
  } catch (const std::regex_error& e) {
    throw InputError(value->where, fmt::format("{} is no regular expression: {}", value->text, e.what()));
  }
  return bounds;
}

Numbers numberThings(const ThingBounds& bounds, const std::vector<ThingTriangles>& triangles) {
  if (triangles.empty()) return {};
  switch (bounds.by) {
    case ThingBounds::By::Object:
      break;
    case ThingBounds::By::Node:
      return byKeys(triangles, [](const AssetPart& part) { return part.nodeIndex; });
    case ThingBounds::By::Part:
      return byConnection(triangles);
    case ThingBounds::By::Name: {
      const std::regex pattern(bounds.pattern, std::regex::ECMAScript);
      return byKeys(triangles, [&](const AssetPart& part) {
        std::smatch match;
        if (!std::regex_search(part.node, match, pattern)) return fmt::format("node {}", part.nodeIndex);
        return "name " + match[match.size() > 1 ? 1 : 0].str();
      });
    }
  }
  Numbers found;
  for (const ThingTriangles& t : triangles) found.emplace_back(t.part->triangles.size(), 1);
  return found;
}

}  // namespace scanmill
