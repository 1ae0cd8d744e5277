#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "base/error.h"
#include "base/file.h"
#include "base/text_scan.h"
#include "config/distribution.h"
#include "config/fields.h"
#include "config/value.h"
#include "dataset/manifest.h"
#include "dataset/names.h"
#include "pipeline/plan/dataset_plan.h"
#include "pipeline/read/effects.h"
#include "sensors/trajectory.h"
#include "study/compare/compare.h"

namespace scanmill {
namespace {

// A key of an effect, and a figure that is proportional to a power of the key's value if other influences stay equal.
struct KeyInfluence {
  std::string_view figure;  // name of an entry in kPatchFeatures, kSetFigures or both
  double leastFigure = 1;   // if both sets' figures (as shown to users) are below, they may differ by chance
  std::string_view effect, key;
  double power = 1;  // the key's value is proportional to the figure to this power
  Range allowed;
  bool whole = false;    // true: the key only takes integers
  bool perRing = false;  // true: the key is a standard deviation of values that are drawn for each ring
};

constexpr KeyInfluence kKeyInfluences[] = {
    {.figure = "ring_offset", .effect = "ring_bias", .key = "range_sigma_m", .allowed = {0, 10}, .perRing = true},
    {.figure = "ring_gain", .effect = "ring_bias", .key = "gain_sigma", .allowed = {0, 2}, .perRing = true},
    // Speckle with n looks causes an intensity scatter in proportion to 1 / sqrt(n).
    {.figure = "intensity_scatter",
     .effect = "speckle",
     .key = "looks",
     .power = -2,
     .allowed = {1, 30},
     .whole = true},
    {.figure = "range_scatter", .effect = "range_noise", .key = "sigma_m", .allowed = {0, 10}},
    {.figure = "single_missing", .leastFigure = 0.05, .effect = "dropout", .key = "probability", .allowed = {0, 1}},
};

// Returns the number that a value is; nothing if it is no number.
std::optional<double> numberOf(const Value& value) {
  double number = 0;
  return value.kind == Value::Kind::Scalar && parseNumber(value.text, number) ? std::optional(number) : std::nullopt;
}

// Returns the number of a mount's key, 0 if the key is absent; nothing if it is no number.
std::optional<double> mountNumber(const Value& mount, std::string_view key) {
  const bool isHeight = key == "position.2";
  const Value* const value = mount.find(isHeight ? "position" : key);
  if (value == nullptr) return 0;
  return numberOf(isHeight && value->items.size() == 3 ? value->items[2] : *value);
}

FigurePair shownPair(const ComparedFigure& figure, double real, double simulated) {
  return {real * figure.factor, simulated * figure.factor, figure.title, figure.unit};
}

// Returns the set figure `name`, which is corrected for chance; if there is none, the patch feature `name`. Returns
// nothing if the figure is not positive in both sets. Also returns nothing if set figure and patch feature suggest
// opposite changes, since something other than the key then causes the difference.
std::optional<FigurePair> figureFor(const SetComparison& comparison, std::string_view name) {
  std::optional<FigurePair> ofSets, ofPatches;
  for (std::size_t i = 0; i < kSetFigureCount; ++i) {
    if (kSetFigures[i].name != name) continue;
    ofSets = shownPair(kSetFigures[i], comparison.real.figures[i], comparison.simulated.figures[i]);
  }
  for (const Separation& s : comparison.features) {
    if (kPatchFeatures[s.feature].name != name) continue;
    ofPatches = shownPair(kPatchFeatures[s.feature], s.realValue, s.simulatedValue);
  }
  const auto isPositive = [](const std::optional<FigurePair>& f) { return f && f->real > 0 && f->simulated > 0; };
  if (isPositive(ofSets) && isPositive(ofPatches) && (ofSets->ratio() > 1) != (ofPatches->ratio() > 1)) return {};
  const std::optional<FigurePair>& figure = ofSets ? ofSets : ofPatches;
  return isPositive(figure) ? figure : std::nullopt;
}

// Returns an iterator to the effect with this name in a list of effects; the end iterator if there is none.
auto effectNamed(const std::vector<Value>& effects, std::string_view name) {
  return std::ranges::find_if(effects, [&](const Value& v) { return readNamed(v, "an effect").name == name; });
}

void addMountChanges(SetComparison& comparison, const Pipeline& pipeline, std::size_t sensor) {
  const std::string key = fmt::format("sensors.{}.mount", sensor);
  constexpr double kMostSuspension = 0.3;  // m between a sensor's height above its vehicle and above the ground
  Value mount = pipeline.root.valueOf("sensors").items.at(sensor).valueOf("mount");
  if (holdsDistribution(mount))
    comparison.warnings.push_back(key + " is random: no value is proposed for what is drawn");
  if (isDistribution(mount) || mount.find("rotation") != nullptr) return;
  // Waypoints may fly, which only the scene tells: then the scans' heights do.
  const std::optional<double> height = mountNumber(mount, "position.2");
  const bool isAtGround =
      height && std::fabs(comparison.simulated.roadPose[kHeight].median - *height) < kMostSuspension;
  const bool isOnWheels = std::ranges::all_of(pipeline.sequences, [&](const Sequence& sequence) {
    const GroundOptions* const ground = sequence.trajectory->ground();
    return ground != nullptr && ground->wheels && (isAtGround || !ground->onlyIfAtGround);
  });
  comparison.advice = changeMount(comparison, key, isOnWheels, mount);
  if (comparison.advice.empty()) return;
  comparison.assignments = {fmt::format("{}={}", key, flowText(mount))};
  if (isOnWheels) return;
  comparison.warnings.emplace_back(
      "the simulated vehicle stands as its path or its poses say, not on its wheels: height and pitch of a mount are "
      "relative to these, and no roll is proposed. With `ground: drop` in all trajectories it leans with the road");
}

}  // namespace

std::string KeyChange::suggestedText() const {
  return deviation == 0 ? fmt::format("{:g}", suggested)
                        : fmt::format("{{normal: [{:g}, {:g}]}}", suggested, deviation);
}

std::vector<KeyChange> adviceFor(const SetComparison& comparison, const std::vector<Value>& effectItems) {
  std::vector<KeyChange> advice;
  for (const KeyInfluence& influence : kKeyInfluences) {
    const auto effect = effectNamed(effectItems, influence.effect);
    const std::optional<FigurePair> figure = figureFor(comparison, influence.figure);
    if (effect == effectItems.end() || !figure) continue;
    if (std::max(figure->real, figure->simulated) < influence.leastFigure) continue;
    const std::optional<double> current = numberOf(readNamed(*effect, "an effect").options.valueOf(influence.key));
    const double ratio = figure->ratio();
    // The spread of n drawn values scatters by 1 / sqrt(2 n) of itself, the ratio of two of them by 1 / sqrt(n).
    const double nearlyEqual = influence.perRing ? 1 + 3 / std::sqrt(comparison.simulated.rows) : 1.1;
    if (!current || *current <= 0 || std::max(ratio, 1 / ratio) < nearlyEqual) continue;
    const double exact = *current * std::pow(ratio, influence.power);
    const double allowed = std::clamp(exact, influence.allowed.low, influence.allowed.high);
    const double suggested = influence.whole ? std::round(allowed) : std::stod(fmt::format("{:.2g}", allowed));
    if (suggested == *current) continue;
    advice.push_back({.key = fmt::format("{}.{}", influence.effect, influence.key),
                      .figure = *figure,
                      .current = *current,
                      .suggested = suggested,
                      .isEnd = allowed != exact});
  }
  return advice;
}

std::string assignmentOf(const std::vector<KeyChange>& advice, const std::vector<Value>& pipelineItems) {
  Value list = sequenceValue(pipelineItems);
  for (const KeyChange& change : advice) {
    const std::string effect = change.key.substr(0, change.key.find('.'));
    const auto index = static_cast<std::size_t>(effectNamed(list.items, effect) - list.items.begin());
    // If the pipeline's list lacks the effect, the sensor's file has it; an item added to the list overrides the key.
    if (index == list.items.size()) list.items.emplace_back();
    if (list.items[index].kind != Value::Kind::Map) list.items[index] = {};  // setValue() makes a map of it
    setValue(list, fmt::format("{}.{}={}", index, change.key, change.suggestedText()));
  }
  return "effects=" + flowText(list);
}

std::vector<KeyChange> changeMount(const SetComparison& comparison, const std::string& mountKey, bool isOnWheels,
                                   Value& mount) {
  constexpr double kUnlike = 1.5;  // ratio of two deviations over a dozen sequences that chance hardly exceeds
  const auto toHundredths = [](double value) { return std::round(value * 100) / 100 + 0.0; };  // no -0
  const RoadPoses &realPose = comparison.real.roadPose, &simulatedPose = comparison.simulated.roadPose;
  std::vector<KeyChange> advice;
  // Keys of a mount, the figures that they change, and the signs of the changes. The vehicle stands on its own lane:
  // the ground within 12 m has a cross fall to both sides, whatever the mount's roll.
  for (const auto& [key, figure, sign] :
       {std::tuple("position.2", kHeight, 1), {"pitch_deg", kPitch, 1}, {"roll_deg", kLaneSlope, -1}}) {
    const FigureSpread &real = realPose[figure], &simulated = simulatedPose[figure];
    const std::optional<double> current = mountNumber(mount, key);
    const double difference = real.median - simulated.median;
    if (!current || std::isnan(difference) || (figure == kLaneSlope && !isOnWheels)) continue;
    KeyChange change{.key = fmt::format("{}.{}", mountKey, key),
                     .figure = shownPair(kRoadFigures[figure], real.median, simulated.median),
                     .current = *current,
                     .suggested = toHundredths(*current + sign * difference)};
    // Mounts and places vary independently, so that their variances add up. NaN if a set has too few sequences.
    if (real.overSequences > kUnlike * simulated.overSequences) {
      change.deviation =
          toHundredths(std::sqrt(std::pow(real.overSequences, 2) - std::pow(simulated.overSequences, 2)));
    }
    if (differenceText(figure, realPose, simulatedPose).empty() && change.deviation == 0) continue;
    if (mount.find("position") == nullptr) setValue(mount, "position=[0, 0, 0]");
    setValue(mount, fmt::format("{}={}", key, change.suggestedText()));
    advice.push_back(std::move(change));
  }
  return advice;
}

void addKeyChanges(SetComparison& comparison, const std::filesystem::path& simulated, const std::string& sensor,
                   const std::filesystem::path& pipeline) {
  comparison.unadvised = "The second set is not the folder of a dataset.";
  if (!pathExists(simulated / kManifestName)) return;
  try {
    const Plan plan = planOfDataset(readManifest(simulated), simulated, pipeline);
    const std::vector<MountedSensor>& sensors = plan.pipeline.sensors;
    const auto named = std::ranges::find(sensors, sensor, &MountedSensor::name);
    const std::size_t index = named == sensors.end() ? 0 : static_cast<std::size_t>(named - sensors.begin());
    addMountChanges(comparison, plan.pipeline, index);
    const std::vector<Value>& pipelineItems = plan.pipeline.effectItems;
    std::vector<KeyChange> effects;
    if (comparison.sensorsDiffer()) {
      comparison.unadvised = "The sensors differ.";
    } else if (holdsDistribution(plan.pipeline.root.valueOf("effects")) ||
               holdsDistribution(plan.pipeline.root.valueOf("corruption")) ||
               holdsDistribution(sensors[index].description.valueOf("effects"))) {
      comparison.unadvised = "The second set's effects are random.";
    } else {
      effects = adviceFor(comparison, sensorEffectItems(pipelineItems, sensors[index]));
      comparison.unadvised = "No key of the second set's effects scales a figure that differs by a tenth or more.";
    }
    if (!effects.empty()) comparison.assignments.push_back(assignmentOf(effects, pipelineItems));
    comparison.advice.insert(comparison.advice.end(), effects.begin(), effects.end());
    if (!comparison.advice.empty()) comparison.unadvised.clear();
  } catch (const InputError& error) {
    comparison.unadvised = fmt::format("The second set's pipeline cannot be read: {}", error.what());
  }
}

}  // namespace scanmill
