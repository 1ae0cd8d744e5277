#pragma once

// Writes JSON as text. Keys keep their order, and numbers read back to the same bits. The same values therefore always
// give the same bytes.

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"
#include "dataset/manifest.h"
#include "scene/ontology.h"

namespace scanmill {

using OrderedJson = nlohmann::ordered_json;

// Returns the text of a single value (no list or map), without line breaks.
std::string scalarText(const OrderedJson& value);

// Returns the text of a value of any kind. Values that fit into a line, and all lists of numbers, are written on one
// line; other values are broken into lines, indented by one space per level.
std::string layOut(const OrderedJson& value, std::size_t indent = 0);
// Returns the text of a list. `items`: the texts of the items, laid out with `indent` + 1.
std::string layOutList(const std::vector<std::string>& items, std::size_t indent);

// Return the given values. Infinities and NaN, which JSON does not have, cause an Error that names `what`.
double finite(double value, std::string_view what);
OrderedJson finiteList(const std::vector<double>& values, std::string_view what);

OrderedJson poseJson(const Pose& pose, std::string_view what);
// Returns the class with this id. Throws an Error that begins with `key` if the ontology does not have it.
const SemanticClass& requireClass(std::uint16_t id, const std::string& key, const Ontology& ontology);
OrderedJson ontologyJson(const Ontology& ontology);

}  // namespace scanmill
