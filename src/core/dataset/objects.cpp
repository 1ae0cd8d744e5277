#include "dataset/objects.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "dataset/json_record.h"

namespace scanmill {

namespace {

constexpr double kLengthSteps = 1e4;      // rounding steps of lengths, coordinates and speeds, per metre
constexpr double kQuaternionSteps = 1e9;  // rounding steps of a quaternion's components, per unit
constexpr double kFractionSteps = 1e3;    // rounding steps of a fraction from 0 to 1
constexpr double kTimeSteps = 1e7;        // rounding steps of times, per second

double rounded(double value, double stepsPerUnit) {
  const double result = std::round(value * stepsPerUnit) / stepsPerUnit;
  return result == 0 ? 0.0 : result;  // avoids -0
}

// Returns the sample with all numbers rounded as objectsJson() states.
SampleObjects roundedForFile(SampleObjects sample) {
  const auto roundVector = [&](Vec3d& v) {
    for (double* const coordinate : {&v.x, &v.y, &v.z}) *coordinate = rounded(*coordinate, kLengthSteps);
  };
  const auto roundPose = [&](Pose& pose) {
    Quat& q = pose.rotation;
    for (double* const component : {&q.w, &q.x, &q.y, &q.z}) *component = rounded(*component, kQuaternionSteps);
    roundVector(pose.translation);
  };
  sample.time = rounded(sample.time, kTimeSteps);
  for (ObjectRecord& object : sample.objects) {
    roundPose(object.worldFromBox);
    roundVector(object.size);
    roundVector(object.velocity);
    for (ObjectView& view : object.views) {
      view.time = rounded(view.time, kTimeSteps);
      roundPose(view.sensorFromBox);
      view.truncation = rounded(view.truncation, kFractionSteps);
      if (view.nearestRange) view.nearestRange = rounded(*view.nearestRange, kLengthSteps);
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
      [&] { return view.visibility() ? OrderedJson(rounded(*view.visibility(), kFractionSteps)) : OrderedJson(); },
      [&](const JsonNode& node) {
        const std::optional<double> computed = view.visibility();
        const bool same =
            node.isNull() ? !computed : computed && std::abs(node.number(0, 1) - *computed) <= 1 / kFractionSteps;
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
    const auto hasPoints = [](const ObjectView& view) { return view.points > 0; };
    if (std::ranges::any_of(object.views, hasPoints)) ++count.withPoints;
  }
  return counts;
}

std::string objectsJson(const SampleObjects& sample, const Ontology& ontology) {
  return layOut(jsonOf(roundedForFile(sample), sample.key, {.ontology = &ontology})) + "\n";
}

SampleObjects parseObjects(std::string_view text, const std::string& name, const Ontology& ontology) {
  const Json json = parseJson(std::string(text), name);
  SampleObjects sample;
  readJson(JsonNode(json, "", name), sample, {.ontology = &ontology});
  return sample;
}

}  // namespace scanmill
