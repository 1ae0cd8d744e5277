#include "pipeline/read/effects.h"

#include <fmt/core.h>

#include <algorithm>
#include <set>
#include <utility>

#include "base/error.h"
#include "base/random.h"
#include "config/distribution.h"
#include "config/resources.h"
#include "scenefile/scene_file.h"

namespace scanmill {
namespace {

struct ListedEffect : ChosenEffect {
  Location where;  // of its item in the list
};

bool meansSensor(const Value& item) {
  return item.kind == Value::Kind::Scalar && item.text == "sensor";
}

bool meansNone(const Value& item) {
  return item.kind == Value::Kind::Scalar && item.text == "none";
}

// Replaces the name of a class by its id. Throws InputError for a name or an id that no class has.
void resolveLabel(Value& label, const EffectClasses& classes) {
  if (label.kind != Value::Kind::Scalar) return;
  const Ontology* const ontology = classes.find();
  const bool isNumber =
      !label.quoted && !label.text.empty() && label.text.find_first_not_of("0123456789") == std::string::npos;
  if (!isNumber) {
    if (ontology == nullptr)
      throw InputError(label.where, "the recording has no class names: give `label` as a number");
    label.text = std::to_string(ontology->require(label.text, label.where).id);
    label.quoted = false;
    return;
  }
  const std::int64_t id = readInteger(label, "label", 0, 65535);
  if (ontology == nullptr || ontology->find(static_cast<std::uint16_t>(id)) != nullptr) return;
  throw InputError(label.where,
                   "label: no class of the ontology '{}' has the id {}: give an id or a name "
                   "of one of its classes, or 0 for none",
                   ontology->name, id);
}

// Replaces the class name in an effect's key `label` by the id; removes the key if `classes` is null.
void resolveLabels(NamedOptions& named, const EffectEntry& entry, const EffectClasses* classes) {
  if (entry.keys.find("label: ") == std::string_view::npos) return;
  const auto isLabel = [](const Value::Entry& option) { return option.key == "label"; };
  if (classes == nullptr) std::erase_if(named.options.entries, isLabel);
  for (Value::Entry& option : named.options.entries) {
    if (isLabel(option)) resolveLabel(option.value, *classes);
  }
}

// Returns the effects that the items name, in the order of the items, which must no longer contain the word `sensor`.
// `classes`: null if no ontology is known; then labels are not checked.
std::vector<ListedEffect> listedEffects(const std::vector<Value>& items, const EffectClasses* classes) {
  std::vector<ListedEffect> effects;
  for (const Value& item : items) {
    NamedOptions named = readNamed(item, "an effect");
    const EffectEntry& entry = requireEffect(named.name, named.where);
    const auto earlier = std::ranges::find_if(effects, [&](const ListedEffect& e) { return e.entry == &entry; });
    if (earlier != effects.end()) {
      throw InputError(named.where,
                       "the effect '{}' is listed twice, here and at {}:{}: both would use "
                       "the same random numbers; leave one out",
                       named.name, earlier->where.file, earlier->where.line);
    }
    if (meansNone(named.options)) continue;  // `EFFECT: none` changes nothing in a list without the word `sensor`
    resolveLabels(named, entry, classes);
    Fields options(named.options, "effect " + named.name);
    options.alsoDescribed(entry.keys).finish();
    const std::string text = named.options.kind == Value::Kind::Null ? "" : flowText(named.options);
    effects.push_back({{&entry, entry.make(options), text}, named.where});
  }
  return effects;
}

// Adds the effect `detection` if a beam may have several echoes and the list has no such effect: by default the
// strongest echo is reported.
void addDetection(std::vector<ListedEffect>& effects) {
  const EffectEntry* const detection = &requireEffect("detection", {});
  const auto multiEcho = std::ranges::find_if(effects, [](const ListedEffect& e) { return e->mostReturns(1) > 1; });
  const bool isListed = std::ranges::any_of(effects, [&](const ListedEffect& e) { return e.entry == detection; });
  if (multiEcho == effects.end() || isListed) return;
  const Value none;
  Fields options(none, "effect detection");
  effects.push_back({{detection, detection->make(options), ""}, multiEcho->where});
}

// Returns the effects in the order of their stages, with `detection` if it is needed. Throws InputError if an effect
// needs another effect that is missing.
Effects inOrder(std::vector<ListedEffect> effects) {
  addDetection(effects);
  std::ranges::stable_sort(effects, {}, [](const ListedEffect& effect) { return effect.entry->stage; });
  Effects ordered;
  bool hasIntensity = false;
  bool hasSnr = false;
  const bool usesPower = std::ranges::any_of(effects, [](const ListedEffect& e) { return e->setsIntensity(); });
  const auto require = [](const ListedEffect& effect, bool condition, const char* message) {
    if (!condition) throw InputError(effect.where, fmt::format(fmt::runtime(message), effect.entry->name));
  };
  for (ListedEffect& effect : effects) {
    require(effect, usesPower || !effect->setsGain(),
            "the effect '{0}' changes the power, but no effect uses the power: add the effect `intensity`, or leave "
            "'{0}' out too (`{0}: none` beside `sensor`)");
    require(effect, hasIntensity || !effect->needsIntensity(),
            "the effect '{0}' needs the intensity: add the effect `intensity`, or leave '{0}' out too (`{0}: none` "
            "beside `sensor`)");
    require(effect, !hasIntensity || !effect->setsIntensity(),
            "the effect '{}' sets the intensity, which an earlier effect sets already: leave one of the two out");
    require(effect, hasSnr || !effect->needsSnr(),
            "the effect '{0}' needs the signal-to-noise ratio: add `detection: {{noise: ...}}`, or leave '{0}' out too "
            "(`{0}: none` beside `sensor`)");
    hasIntensity = hasIntensity || effect->setsIntensity();
    hasSnr = hasSnr || effect->setsSnr();
    ordered.push_back(std::move(effect));
  }
  return ordered;
}

std::vector<Value> withoutNone(std::vector<Value> items) {
  std::erase_if(items, meansNone);
  return items;
}

void checkIsList(const Value& effects) {
  if (effects.kind == Value::Kind::Sequence) return;
  throw InputError(effects.where, "a sensor's effects must be a list such as [range_noise: {sigma_m: 0.01}]");
}

// Returns the items of `list`, the value of the key `effects`: a list, the word `sensor`, or Null for no items.
std::vector<Value> effectItems(const Value& list) {
  if (list.kind == Value::Kind::Null) return {};
  if (list.kind == Value::Kind::Sequence) return withoutNone(list.items);
  if (meansSensor(list)) return {list};
  throw InputError(list.where,
                   "effects must be a list such as [intensity], [] for no effects, or `sensor` for the effects in each "
                   "sensor's file");
}

Effects makeEffects(const std::vector<Value>& items, const EffectClasses& classes) {
  return inOrder(listedEffects(items, &classes));
}

constexpr const char* kFolder = "pipelines/corruptions";

// Returns the contents of a corruption file. Throws InputError if a severity has no list of effects.
Value readCorruption(const std::filesystem::path& file) {
  Value root = readYaml(file);
  Fields fields(root, "corruption");
  fields.also({"summary", "light", "moderate", "heavy"}).finish();
  fields.text("summary");
  for (const std::string& severity : severities()) {
    for (const Value& item : readList(fields.require(severity), severity)) readNamed(item, "an effect");
  }
  return root;
}

}  // namespace

std::vector<Value> sensorEffectItems(const std::vector<Value>& items, const MountedSensor& sensor) {
  const auto sensorItem = std::ranges::find_if(items, meansSensor);
  if (sensorItem == items.end()) return items;
  const Value* sensorEffects = sensor.description.find("effects");
  if (sensorEffects == nullptr) {
    throw InputError(
        sensorItem->where,
        fmt::format("the file of the sensor '{}' has no effects: measure them with `scanmill fit-noise`, write "
                    "`effects:` into the file or beside the sensor (`effects: [intensity]`: its ranges are exact), "
                    "or name effects here (`scanmill list sensors` shows the presets with effects)",
                    sensor.name));
  }
  checkIsList(*sensorEffects);
  std::vector<Value> expanded = withoutNone(sensorEffects->items);
  std::set<std::string> changed;
  for (const Value& item : items) {
    if (&item == &*sensorItem) continue;
    if (meansSensor(item)) throw InputError(item.where, "the word `sensor` is listed twice");
    const NamedOptions change = readNamed(item, "an effect");
    requireEffect(change.name, change.where);
    if (!changed.insert(change.name).second) {
      throw InputError(change.where, "the effect '{}' is listed twice beside `sensor`", change.name);
    }
    const auto effect =
        std::ranges::find_if(expanded, [&](const Value& e) { return readNamed(e, "an effect").name == change.name; });
    if (effect == expanded.end()) {
      if (!meansNone(change.options)) expanded.push_back(item);
    } else if (meansNone(change.options)) {
      expanded.erase(effect);
    } else if (change.options.kind == Value::Kind::Map) {
      *effect = withKeysOf(readNamed(*effect, "an effect"), change);
    } else if (change.options.kind != Value::Kind::Null) {
      throw InputError(change.options.where,
                       "effect {}: give a map of the keys to change, or `none` to "
                       "leave out the effect of the sensor's file",
                       change.name);
    }
  }
  return expanded;
}

Value withKeysOf(const NamedOptions& effect, const NamedOptions& change) {
  Value options = effect.options;
  options.where = change.options.where;
  if (options.kind == Value::Kind::Null) options.kind = change.options.kind;
  for (const Value::Entry& entry : change.options.entries) {
    const auto match = std::ranges::find(options.entries, entry.key, &Value::Entry::key);
    if (match != options.entries.end()) {
      match->value = entry.value;
    } else {
      options.entries.push_back(entry);
    }
  }
  return mapValue({{effect.name, std::move(options)}}, change.where);
}

EffectClasses::EffectClasses(const Pipeline& pipeline) : ontologyFile_(pipeline.ontology) {
  if (!ontologyFile_.empty()) return;
  if (pipeline.recording == nullptr) {
    sceneFile_ = pipeline.sequences.front().sceneFile;
  } else if (!pipeline.recording->ontology.classes.empty()) {
    ontology_ = pipeline.recording->ontology;
  }
}

const Ontology* EffectClasses::find() const {
  std::call_once(read_, [&] {
    if (!ontologyFile_.empty()) ontology_ = readOntology(ontologyFile_);
    if (!sceneFile_.empty()) ontology_ = readSceneOntology(sceneFile_);
  });
  return ontology_ ? &*ontology_ : nullptr;
}

void checkSensorEffects(const Value& sensor, const EffectClasses* classes) {
  if (sensor.find("effects") == nullptr) return;
  std::vector<DrawnValue> ignored;
  const Value effects = withDraws(sensor.valueOf("effects"), "effects", {}, ignored);
  checkIsList(effects);
  listedEffects(withoutNone(effects.items), classes);
}

Effects readSensorEffects(const Value& list, const EffectClasses& classes, const MountedSensor& sensor) {
  return makeEffects(sensorEffectItems(effectItems(list), sensor), classes);
}

Value writtenEffects(const Value& root) {
  const Value& written = root.valueOf("effects");
  const Value& corruption = root.valueOf("corruption");
  return corruption.kind == Value::Kind::Null ? written : withCorruption(written, corruption);
}

bool takesSensorEffects(const Pipeline& pipeline) {
  return std::ranges::any_of(pipeline.effectItems, meansSensor);
}

void readEffects(const Value& written, Pipeline& pipeline) {
  const EffectClasses classes(pipeline);
  for (const MountedSensor& sensor : pipeline.sensors) checkSensorEffects(sensor.description, &classes);
  std::vector<DrawnValue> ignored;
  pipeline.effectItems = effectItems(withDraws(written, "effects", {.seed = pipeline.seed}, ignored));
  const std::vector<Value>& items = pipeline.effectItems;
  if (!takesSensorEffects(pipeline)) {
    const auto shared = std::make_shared<const Effects>(makeEffects(items, classes));
    for (MountedSensor& sensor : pipeline.sensors) sensor.effects = shared;
    return;
  }
  for (MountedSensor& sensor : pipeline.sensors) {
    sensor.effects = std::make_shared<const Effects>(makeEffects(sensorEffectItems(items, sensor), classes));
    const auto hasIntensity = [](const MountedSensor& s) { return intensityFullScale(*s.effects) > 0; };
    if (hasIntensity(sensor) == hasIntensity(pipeline.sensors.front())) continue;
    throw InputError(written.where,
                     "only one of the sensors '{}' and '{}' has an intensity, but all scans of a dataset "
                     "have the same columns: add `intensity` to the effects of the other sensor",
                     pipeline.sensors.front().name, sensor.name);
  }
}

const std::vector<std::string>& severities() {
  static const std::vector<std::string> kSeverities{"light", "moderate", "heavy"};
  return kSeverities;
}

Value withCorruption(const Value& effects, const Value& corruption) {
  const NamedOptions named = readNamed(corruption, "corruption");
  if (named.options.kind != Value::Kind::Scalar) {
    throw InputError(corruption.where, "corruption must be a name and its severity, such as {fog: heavy}");
  }
  Value options = corruption;
  options.entries = {{"severity", named.options}};
  const std::string severity = Fields(options, "corruption " + named.name).choice("severity", severities(), "");
  const Value file = readCorruption(resolveResource(corruption, named.name, kFolder));
  if (isDistribution(effects)) {
    throw InputError(effects.where,
                     "a corruption cannot be added to effects whose complete list is random: write a list with random "
                     "items, or leave out the corruption or the random list");
  }
  Value list = effects;
  if (list.kind != Value::Kind::Sequence) {
    list.items = list.kind == Value::Kind::Null ? std::vector<Value>{} : std::vector<Value>{effects};
    list.kind = Value::Kind::Sequence;
    if (effects.kind == Value::Kind::Null) list.where = corruption.where;
  }
  for (const Value& item : file.find(severity)->items) {
    const NamedOptions change = readNamed(item, "an effect");
    const auto effect = std::ranges::find_if(list.items, [&](const Value& other) {
      return !isDistribution(other) && readNamed(other, "an effect").name == change.name;
    });
    if (effect == list.items.end()) {
      list.items.push_back(item);
      continue;
    }
    const NamedOptions listed = readNamed(*effect, "an effect");
    // Merges the options by key. If the listed effect is `none` or random, or the change names a `kind` of weather, the
    // change replaces the effect instead.
    const bool isMerged = listed.options.kind != Value::Kind::Scalar && !isDistribution(listed.options) &&
                          change.options.find("kind") == nullptr;
    *effect = isMerged ? withKeysOf(listed, change) : item;
  }
  return list;
}

std::vector<std::string> corruptionNames() {
  const std::set<std::string> names = resourceNames(kFolder);
  return {names.begin(), names.end()};
}

std::string corruptionSummary(const std::string& name) {
  return readCorruption(namedResource(name, kFolder)).find("summary")->text;
}

}  // namespace scanmill
