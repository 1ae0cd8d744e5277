#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.h"
#include "base/file.h"
#include "base/text_scan.h"
#include "config/fields.h"
#include "config/value.h"
#include "dataset/manifest.h"
#include "dataset/names.h"
#include "pipeline/plan/dataset_plan.h"
#include "pipeline/read/effects.h"
#include "study/compare/compare.h"

namespace scanmill {
namespace {

// A key of an effect, and a figure that is proportional to a power of the key's value if other influences stay equal.
struct KeyInfluence {
  std::string_view figure;  // name of an entry in kPatchFeatures, kSetFigures or both
  double leastFigure = 1;   // if both sets' figures (as shown to users) are below, they may differ by chance
  std::string_view effect, key;
  double power = 1;                // the key's value is proportional to the figure to this power
  double lowest = 0, highest = 0;  // bounds of the key's value
  bool isInteger = false;          // true: the key only takes integers
};

constexpr KeyInfluence kKeyInfluences[] = {
    {.figure = "ring_offset", .effect = "ring_bias", .key = "range_sigma_m", .highest = 10},
    {.figure = "ring_gain", .effect = "ring_bias", .key = "gain_sigma", .highest = 2},
    // Speckle with n looks causes an intensity scatter in proportion to 1 / sqrt(n).
    {.figure = "intensity_scatter",
     .effect = "speckle",
     .key = "looks",
     .power = -2,
     .lowest = 1,
     .highest = 30,
     .isInteger = true},
    {.figure = "range_scatter", .effect = "range_noise", .key = "sigma_m", .highest = 10},
    {.figure = "single_missing", .leastFigure = 0.05, .effect = "dropout", .key = "probability", .highest = 1},
};

// Returns the value of a key in an effect's options; nothing unless the value is a positive number.
std::optional<double> positiveNumber(const Value& options, std::string_view key) {
  const Value* value = options.kind == Value::Kind::Map ? options.find(key) : nullptr;
  double number = 0;
  const bool isNumber = value != nullptr && value->kind == Value::Kind::Scalar && parseNumber(value->text, number);
  return isNumber && number > 0 ? std::optional(number) : std::nullopt;
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

}  // namespace

std::vector<KeyChange> adviceFor(const SetComparison& comparison, const std::vector<Value>& effectItems) {
  constexpr double kNearlyEqual = 1.1;  // a smaller ratio of the figures leads to no advice
  std::vector<KeyChange> advice;
  for (const KeyInfluence& influence : kKeyInfluences) {
    const auto effect = effectNamed(effectItems, influence.effect);
    const std::optional<FigurePair> figure = figureFor(comparison, influence.figure);
    if (effect == effectItems.end() || !figure) continue;
    if (std::max(figure->real, figure->simulated) < influence.leastFigure) continue;
    const std::optional<double> current = positiveNumber(readNamed(*effect, "an effect").options, influence.key);
    const double ratio = figure->ratio();
    if (!current || std::max(ratio, 1 / ratio) < kNearlyEqual) continue;
    const double exact = *current * std::pow(ratio, influence.power);
    const double allowed = std::clamp(exact, influence.lowest, influence.highest);
    const double suggested = influence.isInteger ? std::round(allowed) : std::stod(fmt::format("{:.2g}", allowed));
    if (suggested == *current) continue;
    advice.push_back({.effect = influence.effect,
                      .key = influence.key,
                      .figure = *figure,
                      .currentValue = *current,
                      .suggestedValue = suggested,
                      .isEnd = allowed != exact});
  }
  return advice;
}

std::string assignmentOf(const std::vector<KeyChange>& advice, const std::vector<Value>& pipelineItems) {
  Value list{.kind = Value::Kind::Sequence, .items = pipelineItems};
  for (const KeyChange& change : advice) {
    const auto index = static_cast<std::size_t>(effectNamed(list.items, change.effect) - list.items.begin());
    // If the pipeline's list lacks the effect, the sensor's file has it; an item added to the list overrides the key.
    if (index == list.items.size()) list.items.emplace_back();
    if (list.items[index].kind != Value::Kind::Map) list.items[index] = {};  // setValue() makes a map of it
    setValue(list, fmt::format("{}.{}.{}={:g}", index, change.effect, change.key, change.suggestedValue));
  }
  return "effects=" + flowText(list);
}

void addKeyChanges(SetComparison& comparison, const std::filesystem::path& simulated, const std::string& sensor,
                   const std::filesystem::path& pipeline) {
  const auto setUnadvised = [&](std::string reason) { comparison.unadvised = std::move(reason); };
  if (!pathExists(simulated / kManifestName)) return setUnadvised("The second set is not the folder of a dataset.");
  if (comparison.sensorsDiffer()) return setUnadvised("The sensors differ.");
  try {
    const Plan plan = planOfDataset(readManifest(simulated), simulated, pipeline);
    const std::vector<MountedSensor>& sensors = plan.pipeline.sensors;
    const std::vector<Value>& pipelineItems = plan.pipeline.effectItems;
    if (plan.pipeline.drawn != nullptr) return setUnadvised("The second set's mounts or effects are random.");
    const auto named = std::ranges::find(sensors, sensor, &MountedSensor::name);
    const MountedSensor& compared = named == sensors.end() ? sensors.front() : *named;
    comparison.advice = adviceFor(comparison, sensorEffectItems(pipelineItems, compared));
    if (comparison.advice.empty())
      return setUnadvised("No key of the second set's effects scales a figure that differs by a tenth or more.");
    comparison.assignment = assignmentOf(comparison.advice, pipelineItems);
  } catch (const InputError& error) {
    setUnadvised(
        fmt::format("The second set's pipeline cannot be read: {}. If its files are elsewhere, name the pipeline with "
                    "--pipeline FILE.",
                    error.what()));
  }
}

}  // namespace scanmill
