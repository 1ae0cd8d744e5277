#include "pipeline/read/effects.h"

#include <fmt/core.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/random.h"
#include "config/fields.h"
#include "pipeline/read/corruption.h"
#include "scenefile/scene_file.h"

namespace scanmill {

namespace {

struct MadeEffect : ChosenEffect {
  Location where;
};

bool meansSensor(const Value& item) {
  return item.kind == Value::Kind::Scalar && item.text == "sensor";
}

bool meansNone(const NamedOptions& item) {
  return item.options.kind == Value::Kind::Scalar && item.options.text == "none";
}

// Replaces the name of a class by its id. Throws InputError for a name or an id that no class has.
void resolveLabel(Value& label, const EffectClasses& classes) {
  if (label.kind != Value::Kind::Scalar) return;
  const Ontology* const ontology = classes.find();
  const bool number =
      !label.quoted && !label.text.empty() && label.text.find_first_not_of("0123456789") == std::string::npos;
  if (!number) {
    if (ontology == nullptr)
      throw InputError(label.where, "the recording has no class names: give `label` as a number");
    label.text = std::to_string(ontology->require(label.text, label.where).id);
    label.quoted = false;
    return;
  }
  const std::int64_t id = readInteger(label, "label", 0, 65535);
  if (ontology == nullptr || ontology->find(static_cast<std::uint16_t>(id)) != nullptr) return;
  throw InputError(label.where, fmt::format("label: no class of the ontology '{}' has the id {}: give an id or a name "
                                            "of one of its classes, or 0 for none",
                                            ontology->name, id));
}

// Resolves the key `label`; removes it if `classes` is null.
void resolveLabels(NamedOptions& named, const EffectEntry& entry, const EffectClasses* classes) {
  if (entry.keys.find("label: ") == std::string_view::npos) return;
  const auto isLabel = [](const Value::Entry& option) { return option.key == "label"; };
  if (classes == nullptr) std::erase_if(named.options.entries, isLabel);
  for (Value::Entry& option : named.options.entries) {
    if (isLabel(option)) resolveLabel(option.value, *classes);
  }
}

// Appends to `made` the effects that the items name. The items must no longer contain the word `sensor`.
void addEffects(const std::vector<Value>& items, const EffectClasses* classes, std::vector<MadeEffect>& made) {
  for (const Value& item : items) {
    NamedOptions named = readNamed(item, "an effect");
    const EffectEntry& entry = requireEffect(named.name, named.where);
    const auto other = std::ranges::find_if(made, [&](const MadeEffect& m) { return m.entry == &entry; });
    if (other != made.end()) {
      throw InputError(named.where, fmt::format("the effect '{}' is listed twice, here and at {}:{}: both would use "
                                                "the same random numbers; leave one out",
                                                named.name, other->where.file, other->where.line));
    }
    if (meansNone(named)) continue;  // `EFFECT: none` changes nothing in a list without the word `sensor`
    resolveLabels(named, entry, classes);
    Fields options(named.options, "effect " + named.name);
    options.alsoDescribed(entry.keys).finish();
    const std::string text = named.options.kind == Value::Kind::Null ? "" : flowText(named.options);
    made.push_back({{&entry, entry.make(options), text}, named.where});
  }
}

// Adds the effect `detection` if a beam may have several echoes and the list has no such effect: by default the
// strongest echo is reported.
void addDetection(std::vector<MadeEffect>& made) {
  const EffectEntry* const detection = &requireEffect("detection", {});
  const auto several = std::ranges::find_if(made, [](const MadeEffect& m) { return m->mostReturns(1) > 1; });
  const bool named = std::ranges::any_of(made, [&](const MadeEffect& m) { return m.entry == detection; });
  if (several == made.end() || named) return;
  const Value none;
  Fields options(none, "effect detection");
  made.push_back({{detection, detection->make(options), ""}, several->where});
}

// Returns the effects in the order of their stages, with `detection` if it is needed. Throws InputError if an effect
// needs another effect that is missing.
Effects inOrder(std::vector<MadeEffect> made) {
  addDetection(made);
  std::ranges::stable_sort(made, {}, [](const MadeEffect& m) { return m.entry->stage; });
  Effects ordered;
  bool intensity = false;
  bool snr = false;
  const bool lit = std::ranges::any_of(made, [](const MadeEffect& m) { return m->setsIntensity(); });
  for (MadeEffect& m : made) {
    if (m->setsGain() && !lit) {
      throw InputError(m.where, fmt::format("the effect '{0}' changes the power, but no effect uses the power: add the "
                                            "effect `intensity`, or leave '{0}' out too (`{0}: none` beside `sensor`)",
                                            m.entry->name));
    }
    if (m->needsIntensity() && !intensity) {
      throw InputError(m.where, fmt::format("the effect '{0}' needs the intensity: add the effect `intensity`, or "
                                            "leave '{0}' out too (`{0}: none` beside `sensor`)",
                                            m.entry->name));
    }
    if (m->setsIntensity() && intensity) {
      throw InputError(
          m.where,
          fmt::format(
              "the effect '{}' sets the intensity, which an earlier effect sets already: leave one of the two out",
              m.entry->name));
    }
    if (m->needsSnr() && !snr) {
      throw InputError(m.where, fmt::format("the effect '{0}' needs the signal-to-noise ratio: add `detection: "
                                            "{{noise: ...}}`, or leave '{0}' out too (`{0}: none` beside `sensor`)",
                                            m.entry->name));
    }
    intensity = intensity || m->setsIntensity();
    snr = snr || m->setsSnr();
    ordered.push_back(std::move(m));
  }
  return ordered;
}

std::vector<Value> withoutNone(std::vector<Value> items) {
  std::erase_if(items, [](const Value& item) { return item.kind == Value::Kind::Scalar && item.text == "none"; });
  return items;
}

void checkIsList(const Value& own) {
  if (own.kind == Value::Kind::Sequence) return;
  throw InputError(own.where, "a sensor's effects must be a list such as [range_noise: {sigma_m: 0.01}]");
}

std::vector<Value> effectItems(const Value& list) {
  if (list.kind == Value::Kind::Null) return {};
  if (list.kind == Value::Kind::Sequence) return withoutNone(list.items);
  if (meansSensor(list)) return {list};
  throw InputError(list.where,
                   "effects must be a list such as [intensity], [] for no effects, or `sensor` for the effects in each "
                   "sensor's file");
}

Effects makeEffects(const std::vector<Value>& items, const EffectClasses& classes) {
  std::vector<MadeEffect> made;
  addEffects(items, &classes, made);
  return inOrder(std::move(made));
}

}  // namespace

std::vector<Value> sensorEffectItems(const std::vector<Value>& items, const MountedSensor& sensor) {
  const auto word = std::ranges::find_if(items, meansSensor);
  if (word == items.end()) return items;
  const Value* own = sensor.description.find("effects");
  if (own == nullptr) {
    throw InputError(
        word->where,
        fmt::format(
            "the file of the sensor '{}' has no effects: measure them with `scanmill fit-noise`, write `effects:` into "
            "the file or beside the sensor (`effects: [intensity]`: its ranges are exact), or name effects here "
            "(`scanmill list sensors` shows the presets with effects)",
            sensor.name));
  }
  checkIsList(*own);
  std::vector<Value> expanded = withoutNone(own->items);
  std::set<std::string> changed;
  for (const Value& item : items) {
    if (&item == &*word) continue;
    if (meansSensor(item)) throw InputError(item.where, "the word `sensor` is listed twice");
    const NamedOptions change = readNamed(item, "an effect");
    requireEffect(change.name, change.where);
    if (!changed.insert(change.name).second) {
      throw InputError(change.where, fmt::format("the effect '{}' is listed twice beside `sensor`", change.name));
    }
    const auto old = std::ranges::find_if(
        expanded, [&](const Value& effect) { return readNamed(effect, "an effect").name == change.name; });
    if (old == expanded.end()) {
      if (!meansNone(change)) expanded.push_back(item);
    } else if (meansNone(change)) {
      expanded.erase(old);
    } else if (change.options.kind == Value::Kind::Map) {
      *old = withKeysOf(readNamed(*old, "an effect"), change);
    } else if (change.options.kind != Value::Kind::Null) {
      throw InputError(
          change.options.where,
          fmt::format(
              "effect {}: give a map of the keys to change, or `none` to leave out the effect of the sensor's file",
              change.name));
    }
  }
  return expanded;
}

Value withKeysOf(const NamedOptions& own, const NamedOptions& change) {
  Value options = own.options;
  options.where = change.options.where;
  if (options.kind == Value::Kind::Null) options.kind = change.options.kind;
  for (const Value::Entry& entry : change.options.entries) {
    const auto old = std::ranges::find_if(options.entries, [&](const Value::Entry& e) { return e.key == entry.key; });
    if (old != options.entries.end()) {
      old->value = entry.value;
    } else {
      options.entries.push_back(entry);
    }
  }
  Value item;
  item.kind = Value::Kind::Map;
  item.where = change.where;
  item.entries.push_back({own.name, std::move(options)});
  return item;
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
  const Value own = withDraws(sensor.valueOf("effects"), "effects", {}, ignored);
  checkIsList(own);
  std::vector<MadeEffect> made;
  addEffects(withoutNone(own.items), classes, made);
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
    const auto isLit = [](const MountedSensor& s) { return intensityFullScale(*s.effects) > 0; };
    if (isLit(sensor) == isLit(pipeline.sensors.front())) continue;
    throw InputError(written.where,
                     fmt::format("only one of the sensors '{}' and '{}' has an intensity, but all scans of a dataset "
                                 "have the same columns: add `intensity` to the effects of the other sensor",
                                 pipeline.sensors.front().name, sensor.name));
  }
}

}  // namespace scanmill
