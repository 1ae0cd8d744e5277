#include "dataset/objects.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "dataset/json_record.h"

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

// Returns the sample with numbers as its file has them.
SampleObjects rounded(SampleObjects sample) {
  const auto each = [](double steps, auto&... values) { ((values = rounded(values, steps)), ...); };
  const auto vector = [&](Vec3d& v) { each(kLengths, v.x, v.y, v.z); };
  const auto pose = [&](Pose& p) {
    each(kAngles, p.rotation.w, p.rotation.x, p.rotation.y, p.rotation.z);
    vector(p.translation);
  };
  each(kTimes, sample.time);
  for (ObjectRecord& object : sample.objects) {
    pose(object.worldFromBox);
    vector(object.size);
    vector(object.velocity);
    for (ObjectView& view : object.views) {
      each(kTimes, view.time);
      pose(view.sensorFromBox);
      each(kShares, view.truncation);
      if (view.nearestRange) each(kLengths, *view.nearestRange);
    }
  }
  return sample;
}

}  // namespace

static void describe(RecordKeys& keys, ObjectView& view) {
  keys("sensor", view.sensor);
  keys("time", view.time);
  keys("sensor_from_box", view.sensorFromBox);
  keys("points", view.points);
  keys("beams", view.beams);
  keys("beams_alone", view.beamsAlone);
  keys.custom(
      "visibility",
      [&] { return view.visibility() ? OrderedJson(rounded(*view.visibility(), kShares)) : OrderedJson(); },
      [&](const JsonNode& node) {
        const std::optional<double> computed = view.visibility();
        const bool same =
            node.isNull() ? !computed : computed && std::abs(node.number(0, 1) - *computed) <= 1 / kShares;
        if (!same) node.fail("is not beams / beams_alone");
      });
  keys("truncation", view.truncation, within(0, 1));
  keys.custom(
      "nearest_range", [&] { return view.nearestRange ? jsonOf(*view.nearestRange, view.sensor) : OrderedJson(); },
      [&](const JsonNode& node) {
        if (!node.isNull()) view.nearestRange = node.number(0);
      });
}

static void describe(RecordKeys& keys, ObjectRecord& object) {
  keys("id", object.id, wholeNumber(1));
  keys("class", object.semantic);
  describeClassName(keys, "class_name", object.semantic);
  keys("name", object.name);
  keys.optional("parts", object.parts);
  keys("moves", object.moves);
  keys("world_from_box", object.worldFromBox);
  keys("size", object.size,
       [](const JsonNode& node) { node.forEach([](const JsonNode& length) { length.number(0); }); });
  keys("heading_known", object.headingKnown);
  keys("velocity", object.velocity);
  keys("views", object.views, distinct("sensor"));
}

static void describe(RecordKeys& keys, SampleObjects& sample) {
  keys("key", sample.key);
  keys("time", sample.time);
  keys("objects", sample.objects, distinct("id"));
}

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
    count.withPoints += std::ranges::any_of(object.views, points) ? 1 : 0;
  }
  return counts;
}

std::string objectsJson(const SampleObjects& sample, const Ontology& ontology) {
  return layOut(jsonOf(rounded(sample), sample.key, {.ontology = &ontology})) + "\n";
}

SampleObjects parseObjects(std::string_view text, const std::string& name, const Ontology& ontology) {
  const Json json = parseJson(std::string(text), name);
  SampleObjects sample;
  readJson(JsonNode(json, "", name), sample, {.ontology = &ontology});
  return sample;
}

}  // namespace scanmill
