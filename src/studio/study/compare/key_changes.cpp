#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "base/error.h"
#include "base/file.h"
#include "config/named_options.h"
#include "config/value.h"
#include "dataset/manifest.h"
#include "dataset/shard_name.h"
#include "pipeline/plan/dataset_plan.h"
#include "pipeline/read/effects.h"
#include "study/compare/compare.h"

namespace scanmill {
namespace {

// A key of an effect and a figure that grows as a power of the key's value, if other influences stay the same.
struct KeyInfluence {
  std::string_view figure;  // name of an entry in kPatchFeatures, kSetFigures or both
  double least;             // if the figures of both sets are below this value, their difference may be due to chance
  std::string_view effect, key;
  double power;          // the figure is proportional to the key's value to the power 1 / power
  double low, high;      // bounds of the key's value
  bool integer = false;  // true: the key only takes integers
};

constexpr KeyInfluence kKeyInfluences[] = {
    {"ring_offset", 1, "ring_bias", "range_sigma_m", 1, 0, 10},
    {"ring_gain", 1, "ring_bias", "gain_sigma", 1, 0, 2},
    // Speckle with n looks causes an intensity scatter in proportion to 1 / sqrt(n).
    {"intensity_scatter", 1, "speckle", "looks", -2, 1, 30, true},
    {"range_scatter", 1, "range_noise", "sigma_m", 1, 0, 10},
    {"single_missing", 0.05, "dropout", "probability", 1, 0, 1},
};

std::optional<double> numberIn(const Value& options, std::string_view key) {
  const Value* value = options.kind == Value::Kind::Map ? options.find(key) : nullptr;
  if (value == nullptr) return {};
  double number = 0;
  const char* const end = value->text.data() + value->text.size();
  const auto [stop, error] = std::from_chars(value->text.data(), end, number);
  if (value->kind != Value::Kind::Scalar || error != std::errc() || stop != end || !(number > 0)) return std::nullopt;
  return number;
}

// A figure of both sets, as shown to users.
struct FigurePair {
  double real = 0, simulated = 0;
  std::string_view title, unit;

  double ratio() const { return real / simulated; }
};

FigurePair shownPair(const ComparedFigure& f, double real, double simulated) {
  return {real * f.factor, simulated * f.factor, f.title, f.unit};
}

std::optional<FigurePair> figureOfPatches(const SetComparison& comparison, std::string_view name) {
  for (const Separation& s : comparison.features) {
    const ComparedFigure& f = kPatchFeatures[s.feature];
    if (f.name == name) return shownPair(f, s.realValue, s.simulatedValue);
  }
  return {};
}

std::optional<FigurePair> figureOfSets(const SetComparison& comparison, std::string_view name) {
  for (std::size_t i = 0; i < kSetFigureCount; ++i) {
    const ComparedFigure& f = kSetFigures[i];
    if (f.name == name) return shownPair(f, comparison.real.figures[i], comparison.simulated.figures[i]);
  }
  return {};
}

// Returns the figure that describes the complete sets, which is corrected for chance; if there is none, the figure that
// describes patches. Returns nothing if both exist and suggest opposite changes, since something other than the key
// then causes the difference.
std::optional<FigurePair> figureFor(const SetComparison& comparison, const KeyInfluence& influence) {
  const std::optional<FigurePair> sets = figureOfSets(comparison, influence.figure);
  const std::optional<FigurePair> patches = figureOfPatches(comparison, influence.figure);
  const auto known = [](const std::optional<FigurePair>& s) { return s && s->real > 0 && s->simulated > 0; };
  if (known(sets) && known(patches) && (sets->ratio() > 1) != (patches->ratio() > 1)) return {};
  const std::optional<FigurePair>& figure = sets ? sets : patches;
  return known(figure) ? figure : std::nullopt;
}

// Returns the effect with this name in a list of effects; the end if the list does not have it.
auto effectNamed(const std::vector<Value>& effects, std::string_view name) {
  return std::ranges::find_if(effects, [&](const Value& v) { return readNamed(v, "an effect").name == name; });
}

}  // namespace

std::vector<KeyChange> adviceFor(const SetComparison& comparison, const std::vector<Value>& own) {
  constexpr double kNearlyEqual = 1.1;
  std::vector<KeyChange> advice;
  for (const KeyInfluence& influence : kKeyInfluences) {
    const auto item = effectNamed(own, influence.effect);
    const std::optional<FigurePair> figure = figureFor(comparison, influence);
    if (item == own.end() || !figure || std::max(figure->real, figure->simulated) < influence.least) continue;
    const std::optional<double> now = numberIn(readNamed(*item, "an effect").options, influence.key);
    const double ratio = figure->ratio();
    if (!now || std::max(ratio, 1 / ratio) < kNearlyEqual) continue;
    const double exact = *now * std::pow(ratio, influence.power);
    const double within = std::clamp(exact, influence.low, influence.high);
    const double next = influence.integer ? std::round(within) : std::stod(fmt::format("{:.2g}", within));
    if (next == *now) continue;
    advice.push_back({influence.effect, influence.key, figure->title, figure->real, figure->simulated, figure->unit,
                      *now, next, within != exact});
  }
  return advice;
}

std::string assignmentOf(const std::vector<KeyChange>& advice, const std::vector<Value>& items) {
  Value list;
  list.kind = Value::Kind::Sequence;
  list.items = items;
  for (const KeyChange& a : advice) {
    const auto place = static_cast<std::size_t>(effectNamed(list.items, a.effect) - list.items.begin());
    // If the effect is in the sensor's file, an item after the word `sensor` overrides the effect's key.
    if (place == list.items.size()) list.items.emplace_back();
    if (list.items[place].kind != Value::Kind::Map) list.items[place] = {};  // setValue() makes a map of it
    setValue(list, fmt::format("{}.{}.{}={:g}", place, a.effect, a.key, a.next));
  }
  return "effects=" + flowText(list);
}

void addKeyChanges(SetComparison& comparison, const std::filesystem::path& simulated, const std::string& sensor,
                   const std::filesystem::path& pipeline) {
  const auto giveNone = [&](std::string why) { comparison.unadvised = std::move(why); };
  if (!pathExists(simulated / kManifestName)) return giveNone("The second set is not the folder of a dataset.");
  if (comparison.sensorsDiffer()) return giveNone("The sensors differ.");
  try {
    const Plan plan = planOfDataset(readManifest(simulated), simulated, pipeline);
    const Pipeline& read = plan.pipeline;
    if (read.drawn != nullptr) return giveNone("The second set's mounts or effects are random.");
    const auto named = std::ranges::find_if(read.sensors, [&](const MountedSensor& s) { return s.name == sensor; });
    const MountedSensor& compared = named == read.sensors.end() ? read.sensors.front() : *named;
    comparison.advice = adviceFor(comparison, sensorEffectItems(read.effectItems, compared));
    if (comparison.advice.empty())
      return giveNone("No key of the second set's effects scales a figure that differs by a tenth or more.");
    comparison.assignment = assignmentOf(comparison.advice, read.effectItems);
  } catch (const InputError& error) {
    giveNone(
        fmt::format("The second set's pipeline cannot be read: {}. If its files are elsewhere, name the pipeline with "
                    "--pipeline FILE.",
                    error.what()));
  }
}

}  // namespace scanmill
