#pragma once

// The places of a JSON document, for tests that damage each of its values.

#include <cstddef>
#include <nlohmann/json.hpp>
#include <vector>

namespace scanmill {

using JsonPlace = nlohmann::ordered_json::json_pointer;

// Pointers of all values below `place`, each before those in it.
inline std::vector<JsonPlace> placesIn(const nlohmann::ordered_json& json, const JsonPlace& place = JsonPlace()) {
  std::vector<JsonPlace> places;
  if (!json.is_structured()) return places;
  std::size_t i = 0;
  for (const auto& entry : json.items()) {
    const JsonPlace child = json.is_object() ? place / entry.key() : place / i++;
    places.push_back(child);
    const std::vector<JsonPlace> below = placesIn(entry.value(), child);
    places.insert(places.end(), below.begin(), below.end());
  }
  return places;
}

}  // namespace scanmill
