#include "pipeline/read/corruption.h"

#include <algorithm>

#include "config/distribution.h"
#include "config/fields.h"
#include "config/resources.h"
#include "pipeline/read/effects.h"

namespace scanmill {

namespace {

constexpr const char* kFolder = "pipelines/corruptions";

// Reads a corruption file and checks that it has a list of effects for each severity.
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

// True if the keys of `change` are merged into the options of the same effect in the pipeline. False if these are
// `none` or random, or if `change` names a kind of weather: then `change` replaces the options.
bool isMerged(const Value& options, const Value& change) {
  return options.kind != Value::Kind::Scalar && !isDistribution(options) && change.find("kind") == nullptr;
}

}  // namespace

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
    *effect = isMerged(listed.options, change.options) ? withKeysOf(listed, change) : item;
  }
  return list;
}

std::vector<std::string> corruptionNames() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(resourceFolder() / kFolder)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::ranges::sort(names);
  return names;
}

std::string corruptionSummary(const std::string& name) {
  const Value root = readCorruption(namedResource(name, kFolder));
  return root.find("summary")->text;
}

}  // namespace scanmill
