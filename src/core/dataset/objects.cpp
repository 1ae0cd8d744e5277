#include "dataset/objects.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/error.h"
#include "dataset/json_node.h"
#include "dataset/json_text.h"

namespace scanmill {

namespace {

constexpr double kLengths = 1e4;  // rounding steps of lengths and coordinates, per metre
constexpr double kAngles = 1e9;   // rounding steps of a quaternion's components, per unit
constexpr double kShares = 1e3;   // rounding steps of a fraction from 0 to 1
constexpr double kTimes = 1e7;    // rounding steps of times, per second

double rounded(double value, double steps) {
  const double result = std::round(value * steps) / steps;
  return result == 0 ? 0.0 : result;  // avoids -0
}

OrderedJson vectorJson(const Vec3d& v, const std::string& what) {
  return finiteList({rounded(v.x, kLengths), rounded(v.y, kLengths), rounded(v.z, kLengths)}, what);
}

OrderedJson roundedPose(const Pose& pose, const std::string& what) {
  const Quat& q = pose.rotation;
  return {
      {"rotation",
       finiteList({rounded(q.w, kAngles), rounded(q.x, kAngles), rounded(q.y, kAngles), rounded(q.z, kAngles)}, what)},
      {"translation", vectorJson(pose.translation, what)}};
}

OrderedJson viewJson(const ObjectView& view, const std::string& what) {
  OrderedJson json{{"sensor", view.sensor},
                   {"time", finite(rounded(view.time, kTimes), what)},
                   {"sensor_from_box", roundedPose(view.sensorFromBox, what)},
                   {"points", view.points},
                   {"beams", view.beams},
                   {"beams_alone", view.beamsAlone}};
  const std::optional<double> visibility = view.visibility();
  json["visibility"] = visibility ? OrderedJson(rounded(*visibility, kShares)) : OrderedJson();
  json["truncation"] = finite(rounded(view.truncation, kShares), what);
  json["nearest_range"] =
      view.nearestRange ? OrderedJson(finite(rounded(*view.nearestRange, kLengths), what)) : OrderedJson();
  return json;
}

OrderedJson objectJson(const ObjectRecord& object, const std::string& key, const Ontology& ontology) {
  const SemanticClass& known = requireClass(object.semantic, key, ontology);
  const std::string what = fmt::format("{}: object {}", key, object.id);
  OrderedJson json{{"id", object.id}, {"class", object.semantic}, {"class_name", known.name}, {"name", object.name}};
  if (!object.parts.empty()) json["parts"] = object.parts;
  json["moves"] = object.moves;
  json["world_from_box"] = roundedPose(object.worldFromBox, what);
  json["size"] = vectorJson(object.size, what);
  json["heading_known"] = object.headingKnown;
  json["velocity"] = vectorJson(object.velocity, what);
  json["views"] = OrderedJson::array();
  for (const ObjectView& view : object.views) json["views"].push_back(viewJson(view, what));
  return json;
}

Vec3d vectorOf(const JsonNode& node, double low = -std::numeric_limits<double>::max()) {
  const std::vector<double> v = node.numbers(3);
  if (std::any_of(v.begin(), v.end(), [&](double value) { return value < low; })) {
    node.fail(fmt::format("has a number below {}", low));
  }
  return {v[0], v[1], v[2]};
}

ObjectView viewOf(const JsonNode& node) {
  node.keys({"sensor", "time", "sensor_from_box", "points", "beams", "beams_alone", "visibility", "truncation",
             "nearest_range"});
  ObjectView view;
  view.sensor = node["sensor"].text();
  view.time = node["time"].number();
  view.sensorFromBox = poseOf(node["sensor_from_box"]);
  view.points = node["points"].integer<std::uint64_t>();
  view.beams = node["beams"].integer<std::uint32_t>();
  view.beamsAlone = node["beams_alone"].integer<std::uint32_t>();
  view.truncation = node["truncation"].number(0, 1);
  if (!node["nearest_range"].isNull()) view.nearestRange = node["nearest_range"].number(0);
  const std::optional<double> expected = view.visibility();
  const bool same = node["visibility"].isNull()
                        ? !expected
                        : expected && std::abs(node["visibility"].number(0, 1) - *expected) <= 1 / kShares;
  if (!same) node["visibility"].fail("is not beams / beams_alone");
  return view;
}

ObjectRecord objectOf(const JsonNode& node, const Ontology& ontology) {
  node.keys(
      {"id", "class", "class_name", "name", "moves", "world_from_box", "size", "heading_known", "velocity", "views"},
      {"parts"});
  ObjectRecord object;
  object.id = node["id"].integer<std::uint32_t>(1);
  object.semantic = classOf(node, ontology, "class", "class_name");
  object.name = node["name"].text();
  if (node.has("parts")) object.parts = node["parts"].texts();
  object.moves = node["moves"].boolean();
  object.worldFromBox = poseOf(node["world_from_box"]);
  object.size = vectorOf(node["size"], 0);
  object.headingKnown = node["heading_known"].boolean();
  object.velocity = vectorOf(node["velocity"]);
  std::set<std::string> sensors;
  node["views"].forEach([&](const JsonNode& item) {
    object.views.push_back(viewOf(item));
    if (!sensors.insert(object.views.back().sensor).second) item["sensor"].fail("has two views of this object");
  });
  return object;
}

}  // namespace

std::string objectsMember(const std::string& key) {
  return fmt::format("{}.{}", key, kObjectsSuffix);
}

std::optional<double> ObjectView::visibility() const {
  if (beamsAlone > 0) return std::min(1.0, static_cast<double>(beams) / beamsAlone);
  return beams > 0 ? std::optional(1.0) : std::nullopt;
}

std::map<std::uint16_t, ObjectCount> SampleObjects::counts() const {
  std::map<std::uint16_t, ObjectCount> counts;
  for (const ObjectRecord& object : objects) {
    ObjectCount& count = counts[object.semantic];
    ++count.objects;
    const auto points = [](const ObjectView& view) { return view.points > 0; };
    count.withPoints += std::any_of(object.views.begin(), object.views.end(), points) ? 1 : 0;
  }
  return counts;
}

std::string objectsJson(const SampleObjects& sample, const Ontology& ontology) {
  OrderedJson objects = OrderedJson::array();
  for (const ObjectRecord& object : sample.objects) objects.push_back(objectJson(object, sample.key, ontology));
  return layOut({{"key", sample.key},
                 {"time", finite(rounded(sample.time, kTimes), sample.key + ": time")},
                 {"objects", std::move(objects)}}) +
         "\n";
}

SampleObjects parseObjects(std::string_view text, const std::string& name, const Ontology& ontology) {
  const Json json = parseJson(std::string(text), name);
  const JsonNode root(json, "", name);
  root.keys({"key", "time", "objects"});
  SampleObjects sample;
  sample.key = root["key"].text();
  sample.time = root["time"].number();
  std::set<std::uint32_t> ids;
  root["objects"].forEach([&](const JsonNode& item) {
    sample.objects.push_back(objectOf(item, ontology));
    if (!ids.insert(sample.objects.back().id).second) item["id"].fail("another object has this id");
  });
  return sample;
}

}  // namespace scanmill
