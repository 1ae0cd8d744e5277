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
Numbers numberByKey(const std::vector<ThingTriangles>& parts, bool byClass, const KeyOf& keyOf) {
  using Key = std::pair<decltype(keyOf(*parts.front().part)), std::uint16_t>;
  std::vector<Key> keys;  // by part
  std::map<Key, std::uint32_t> lowestNodes;
  for (const auto& [part, semantic] : parts) {
    const auto node = static_cast<std::uint32_t>(part->nodeIndex);
    keys.emplace_back(keyOf(*part), byClass ? semantic : std::uint16_t{0});
    const auto [lowest, isNew] = lowestNodes.emplace(keys.back(), node);
    if (!isNew) lowest->second = std::min(lowest->second, node);
  }
  std::set<std::pair<std::uint32_t, Key>> byNode;
  for (const auto& [key, node] : lowestNodes) byNode.emplace(node, key);
  std::map<Key, std::uint32_t> numberOfKey;
  for (const auto& [node, key] : byNode) numberOfKey.emplace(key, static_cast<std::uint32_t>(numberOfKey.size() + 1));
  Numbers numbers;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    numbers.emplace_back(parts[i].part->triangles.size(), numberOfKey.at(keys[i]));
  }
  return numbers;
}

// Numbers the things of groupIntoThings() from 1, first those of the lowest class. Returns, for each part and each of
// its triangles, the number of its thing.
Numbers numberByConnection(const std::vector<ThingTriangles>& parts) {
  std::map<std::uint16_t, std::vector<std::size_t>> indicesByClass;  // indices of the parts of each class
  for (std::size_t i = 0; i < parts.size(); ++i) indicesByClass[parts[i].semantic].push_back(i);
  Numbers numbers(parts.size());
  std::uint32_t thingsSoFar = 0;
  for (const auto& [semantic, indices] : indicesByClass) {
    std::vector<const AssetPart*> partsOfClass;
    for (const std::size_t i : indices) partsOfClass.push_back(parts[i].part);
    const ConnectedParts connected = connect(partsOfClass);
    const std::vector<std::uint32_t> things = groupIntoThings(connected.boxes);
    for (std::size_t k = 0; k < indices.size(); ++k) {
      for (const std::uint32_t connectedPart : connected.numbers[k]) {
        numbers[indices[k]].push_back(thingsSoFar + things[connectedPart] + 1);
      }
    }
    if (!things.empty()) thingsSoFar += *std::ranges::max_element(things) + 1;
  }
  return numbers;
}

}  // namespace

ThingBounds readThingBounds(Fields& object, ThingBounds::By fallback) {
  ThingBounds bounds;
  bounds.by = fallback;
  const Value* const value = object.find("instances");
  if (value == nullptr) return bounds;
  bounds.where = value->where;
  if (value->kind != Value::Kind::Scalar || !isRegex(value->text)) {
    const std::string division = object.choice("instances", {"object", "node", "part", "/regular expression/"}, "");
    bounds.by = division == "object" ? ThingBounds::By::Object
                : division == "node" ? ThingBounds::By::Node
                                     : ThingBounds::By::Part;
    return bounds;
  }
  bounds.by = ThingBounds::By::Name;
  bounds.pattern = value->text;
  matchedText(bounds.pattern, "", bounds.where);  // throws InputError for an invalid pattern
  return bounds;
}

Numbers numberThings(const ThingBounds& bounds, const std::vector<ThingTriangles>& parts) {
  if (parts.empty()) return {};
  switch (bounds.by) {
    case ThingBounds::By::Object:
      break;
    case ThingBounds::By::Node:
      return numberByKey(parts, bounds.byClass, [](const AssetPart& part) { return part.nodeIndex; });
    case ThingBounds::By::Part:
      return numberByConnection(parts);
    case ThingBounds::By::Name:
      if (std::ranges::none_of(parts, [&](const ThingTriangles& thingPart) {
            return matchedText(bounds.pattern, thingPart.part->node, bounds.where).has_value();
          })) {
        warn(
            fmt::format("{}: the pattern {} matches no node of a class of things, so that each node becomes an "
                        "instance, such as '{}'",
                        bounds.where.text(), bounds.pattern, parts.front().part->node));
      }
      return numberByKey(parts, bounds.byClass, [&](const AssetPart& part) {
        const std::optional<std::string> text = matchedText(bounds.pattern, part.node, bounds.where);
        return text ? "name " + *text : fmt::format("node {}", part.nodeIndex);
      });
  }
  Numbers ones;
  for (const ThingTriangles& thingPart : parts) ones.emplace_back(thingPart.part->triangles.size(), 1);
  return ones;
}

}  // namespace scanmill
