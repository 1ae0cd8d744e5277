#pragma once

// JSON as text: keys in a fixed order, numbers that round-trip, the same bytes always.

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"
#include "scene/ontology.h"

namespace scanmill {

using OrderedJson = nlohmann::ordered_json;

// One value on one line.
std::string scalarText(const OrderedJson& value);

// What fits a line stays on one, and so do lists of numbers; the rest is indented by one space a level.
std::string layOut(const OrderedJson& value, std::size_t indent = 0);

// JSON has no infinities: throws Error.
double finite(double value, std::string_view what);
OrderedJson finiteList(const std::vector<double>& values, std::string_view what);

OrderedJson poseJson(const Pose& pose, std::string_view what);
OrderedJson ontologyJson(const Ontology& ontology);

}  // namespace scanmill
