#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "base/error.h"
#include "scenefile/connected_parts.h"
#include "scenefile/labelling.h"
#include "scenefile/rules.h"

namespace scanmill {
namespace {

using Numbers = std::vector<std::vector<std::uint32_t>>;

// Numbers the keys from 1, in the order of the lowest node index of each key; with `byClass` a class is part of the
// key. Returns, for each part and each of its triangles, the number of the part's key.
template <class KeyOf>
Numbers byKeys(const std::vector<ThingTriangles>& triangles, bool byClass, const KeyOf& keyOf) {
  using Key = std::pair<decltype(keyOf(*triangles.front().part)), std::uint16_t>;
  std::vector<Key> keys;
  std::map<Key, std::uint32_t> lowest;
  for (const ThingTriangles& t : triangles) {
    const auto node = static_cast<std::uint32_t>(t.part->nodeIndex);
    keys.emplace_back(keyOf(*t.part), byClass ? t.semantic : std::uint16_t{0});
    const auto [known, added] = lowest.emplace(keys.back(), node);
    if (!added) known->second = std::min(known->second, node);
  }
  std::vector<std::pair<std::uint32_t, Key>> order;
  for (const auto& [key, node] : lowest) order.emplace_back(node, key);
  std::ranges::sort(order);
  std::map<Key, std::uint32_t> numbers;
  for (const auto& [node, key] : order) numbers.emplace(key, static_cast<std::uint32_t>(numbers.size() + 1));
  Numbers found;
  found.reserve(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    found.emplace_back(triangles[i].part->triangles.size(), numbers.at(keys[i]));
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
    if (!things.empty()) before += *std::ranges::max_element(things) + 1;
  }
  return found;
}

}  // namespace

ThingBounds readThingBounds(Fields& object, ThingBounds::By fallback) {
  ThingBounds bounds;
  bounds.by = fallback;
  const Value* const value = object.find("instances");
  if (value == nullptr) return bounds;
  bounds.where = value->where;
  if (value->kind != Value::Kind::Scalar || !isRegex(value->text)) {
    const std::string word = object.choice("instances", {"object", "node", "part", "/regular expression/"}, "");
    bounds.by = word == "object" ? ThingBounds::By::Object
                : word == "node" ? ThingBounds::By::Node
                                 : ThingBounds::By::Part;
    return bounds;
  }
  bounds.by = ThingBounds::By::Name;
  bounds.pattern = value->text;
  matchedText(bounds.pattern, "", bounds.where);  // throws InputError for an invalid pattern
  return bounds;
}

Numbers numberThings(const ThingBounds& bounds, const std::vector<ThingTriangles>& triangles) {
  if (triangles.empty()) return {};
  switch (bounds.by) {
    case ThingBounds::By::Object:
      break;
    case ThingBounds::By::Node:
      return byKeys(triangles, bounds.byClass, [](const AssetPart& part) { return part.nodeIndex; });
    case ThingBounds::By::Part:
      return byConnection(triangles);
    case ThingBounds::By::Name:
      if (std::ranges::none_of(triangles, [&](const ThingTriangles& t) {
            return matchedText(bounds.pattern, t.part->node, bounds.where).has_value();
          })) {
        warn(
            fmt::format("{}: the pattern {} matches no node of a class of things, so that each node becomes an "
                        "instance, such as '{}'",
                        bounds.where.text(), bounds.pattern, triangles.front().part->node));
      }
      return byKeys(triangles, bounds.byClass, [&](const AssetPart& part) {
        const std::optional<std::string> text = matchedText(bounds.pattern, part.node, bounds.where);
        return text ? "name " + *text : fmt::format("node {}", part.nodeIndex);
      });
  }
  Numbers found;
  for (const ThingTriangles& t : triangles) found.emplace_back(t.part->triangles.size(), 1);
  return found;
}

}  // namespace scanmill
