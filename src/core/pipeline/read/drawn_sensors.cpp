#include "pipeline/read/drawn_sensors.h"

#include <fmt/core.h>

#include <algorithm>
#include <functional>
#include <map>
#include <utility>

#include "base/random.h"
#include "config/fields.h"

namespace scanmill {

namespace {

// Calls visit(key, value) for each distribution within a value. Distributions within other distributions are not
// visited.
void forEachDistribution(const Value& value, const std::string& key,
                         const std::function<void(const std::string&, const Value&)>& visit) {
  if (isDistribution(value)) return visit(key, value);
  for (std::size_t i = 0; i < value.items.size(); ++i) {
    forEachDistribution(value.items[i], fmt::format("{}.{}", key, i), visit);
  }
  for (const Value::Entry& entry : value.entries) forEachDistribution(entry.value, key + "." + entry.key, visit);
}

}  // namespace

bool DrawnSensors::draws(const Written& written) {
  return holdsDistribution(written.effects) || !written.choices.empty() ||
         std::ranges::any_of(written.mounts, holdsDistribution) ||
         std::ranges::any_of(written.descriptions, [](const Value& description) {
           const Value* effects = description.find("effects");
           return effects != nullptr && holdsDistribution(*effects);
         });
}

DrawnSensors::DrawnSensors(Written written, const Pipeline& pipeline)
    : written_(std::move(written)), classes_(std::make_shared<const EffectClasses>(pipeline)) {
  std::size_t caseCount = 1;
  forEachKey([&](const std::string& key, const Value& value) {
    caseCount = std::max(caseCount, countCases(value));
    const Value* perFrame = findDrawnPerFrame(value);
    drawsPerFrame_ = drawsPerFrame_ || perFrame != nullptr;
    if (!key.ends_with(".mount") || !holdsDistribution(value)) return;
    drawsMounts_ = true;
    if (perFrame == nullptr) return;
    throw InputError(perFrame->where,
                     "`per: frame`: the mount of a sensor is fixed during a sequence: leave `per` out, for a random "
                     "mount in each sequence");
  });
  std::map<std::string, PlaceInSplit> totals;  // by split: numbers of sequences and frames so far
  for (const Sequence& s : pipeline.sequences) {
    PlaceInSplit& total = totals[s.split];
    places_.push_back({.split = s.split, .sequence = total.sequence++, .frame = total.frame});
    total.frame += s.frames;
  }
  for (PlaceInSplit& place : places_) {
    place.sequences = totals[place.split].sequence;
    place.frames = totals[place.split].frame;
  }
  for (std::size_t i = 0; i < caseCount; ++i) {
    cases_.push_back(settingsWith(pipeline, [&](const Value& value, const std::string& /*key*/,
                                                std::vector<DrawnValue>& /*draws*/) { return withCase(value, i); }));
  }
  checkCases();
}

// Throws InputError if the cases differ in the number of rays per beam, in whether there is an intensity, or in its
// unit. All scans of a dataset must agree in these properties.
void DrawnSensors::checkCases() const {
  for (const SensorDraw& testCase : cases_) {
    for (std::size_t s = 0; s < testCase.effects.size(); ++s) {
      const Effects& firstCase = *cases_.front().effects[s];
      const Effects& effects = *testCase.effects[s];
      const bool sameRays = raysPerBeam(effects) == raysPerBeam(firstCase);
      if (sameRays && intensityFullScale(effects) == intensityFullScale(firstCase)) continue;
      throw InputError(
          written_.effects.where,
          "the random effects of '{1}' change {0}, but all scans of a dataset must agree in this: make all "
          "choices agree, or make a dataset of each",
          sameRays ? "the existence or the unit of its intensity" : "the number of rays per beam",
          Fields(written_.descriptions[s], "sensor").text("model", fmt::format("sensor {}", s)));
    }
  }
}

template <class Visit>
void DrawnSensors::forEachKey(const Visit& visit) const {
  for (std::size_t s = 0; s < written_.mounts.size(); ++s) {
    visit(written_.keys[s] + ".mount", written_.mounts[s]);
    if (const Value* list = written_.descriptions[s].find("effects")) visit(written_.keys[s] + ".effects", *list);
  }
  for (const auto& [key, names] : written_.choices) visit(key, names);
  visit(std::string("effects"), written_.effects);
}

// Returns the mounts and effects of a frame. sampled(value, key, draws) returns a value of the pipeline with each of
// its distributions replaced by one value, and may append random values to `draws`.
template <class Sampled>
SensorDraw DrawnSensors::settingsWith(const Pipeline& pipeline, const Sampled& sampled) const {
  SensorDraw drawn;
  const Value effects = sampled(written_.effects, "effects", drawn.draws);
  std::map<std::string, std::string> chosen;  // by key of the choice: the name of the sensor that scans
  for (const auto& [key, names] : written_.choices) chosen[key] = sampled(names, key, drawn.draws).text;
  for (std::size_t s = 0; s < written_.mounts.size(); ++s) {
    MountedSensor sensor = pipeline.sensors[s];
    drawn.scans.push_back(sensor.choice.empty() || chosen[sensor.choice] == sensor.name);
    std::vector<DrawnValue> unused;
    std::vector<DrawnValue>& draws = drawn.scans.back() ? drawn.draws : unused;
    const Value mount = sampled(written_.mounts[s], sensor.key + ".mount", draws);
    drawn.mounts.push_back(readMount(mount, pipeline.vehicle));
    sensor.description = written_.descriptions[s];
    for (auto& [key, value] : sensor.description.entries) {
      if (key == "effects") value = sampled(value, sensor.key + ".effects", draws);
    }
    drawn.effects.push_back(std::make_shared<const Effects>(readSensorEffects(effects, *classes_, sensor)));
  }
  return drawn;
}

SensorDraw DrawnSensors::draw(const Pipeline& pipeline, std::size_t sequence, std::uint32_t frame) const {
  const RandomAddress address{.seed = pipeline.seed, .scene = static_cast<std::uint32_t>(sequence), .frame = frame};
  PlaceInSplit place = places_.at(sequence);
  place.frame += frame;
  return settingsWith(pipeline, [&](const Value& value, const std::string& key, std::vector<DrawnValue>& draws) {
    return withDraws(value, key, address, draws, place);
  });
}

std::vector<ModelledItem> DrawnSensors::items() const {
  std::vector<ModelledItem> items;
  forEachKey([&](const std::string& key, const Value& value) {
    forEachDistribution(value, key, [&](const std::string& path, const Value& distribution) {
      items.push_back(
          {fmt::format("random for each {}", findDrawnPerFrame(distribution) == nullptr ? "sequence" : "frame"),
           fmt::format("{} {}", path, flowText(distribution))});
    });
  });
  return items;
}

}  // namespace scanmill
