#pragma once

// Writes JSON as text. Keys keep their order and numbers read back to the same bits, so that the same values give the
// same bytes.

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"
#include "dataset/manifest.h"
#include "scene/ontology.h"

namespace scanmill {

using OrderedJson = nlohmann::ordered_json;

// The text of a single value, without line breaks.
std::string scalarText(const OrderedJson& value);

// The text of a whole value. What fits into a line stays on one, and so do lists of numbers; all else is indented by
// one space a level.
std::string layOut(const OrderedJson& value, std::size_t indent = 0);
// The text of a list of such texts, whose items were laid out with `indent` + 1.
std::string layOutList(const std::vector<std::string>& items, std::size_t indent);

// Give the values themselves. JSON has no infinities and no NaN: they throw an Error that names `what`.
double finite(double value, std::string_view what);
OrderedJson finiteList(const std::vector<double>& values, std::string_view what);

OrderedJson poseJson(const Pose& pose, std::string_view what);
OrderedJson ontologyJson(const Ontology& ontology);
OrderedJson choiceJson(const MethodRecord& chosen);

}  // namespace scanmill
