#include <algorithm>

#include "base/error.h"
#include "config/fields.h"
#include "pipeline/read/effects.h"
#include "study/repeatability/repeatability.h"

namespace scanmill {

namespace {

// Maximum numbers of levels and scans. The number of compared pairs per pose grows with the squares of both.
constexpr std::size_t kMostLevels = 32;
constexpr std::int64_t kMostScans = 100;

// Reads the list `repeatability.noise`. Throws InputError if two levels have one name, since `reference` names a level.
std::vector<NoiseLevel> readLevels(const Value& list, const Pipeline& pipeline) {
  if (list.kind != Value::Kind::Sequence || list.items.empty()) {
    throw InputError(list.where,
                     "repeatability.noise must be a list of levels such as "
                     "{name: 1 cm, effects: [{shell: {scale_m: 0.01}}]}");
  }
  if (list.items.size() > kMostLevels) {
    throw InputError(list.where,
                     "repeatability.noise: {} levels are too many: at most {} are possible, "
                     "since each is compared with every other",
                     list.items.size(), kMostLevels);
  }
  std::vector<NoiseLevel> levels;
  for (const Value& item : list.items) {
    Fields fields(item, "noise level");
    fields.also({"name", "effects"}).finish();
    NoiseLevel level;
    level.name = fields.text("name");
    if (level.name.empty()) throw InputError(item.where, "the name of a noise level is empty");
    const Value& effects = fields.require("effects");
    for (const MountedSensor& sensor : pipeline.sensors) {
      level.effects.push_back(
          std::make_shared<const Effects>(readSensorEffects(effects, EffectClasses(pipeline), sensor)));
    }
    if (std::ranges::find(levels, level.name, &NoiseLevel::name) != levels.end())
      throw InputError(item.where, "two noise levels are named '{}'", level.name);
    levels.push_back(std::move(level));
  }
  return levels;
}

std::size_t readReference(const Value& value, const std::vector<NoiseLevel>& levels) {
  const std::string name = readText(value, "repeatability.reference");
  const auto level = std::ranges::find(levels, name, &NoiseLevel::name);
  if (level != levels.end()) return static_cast<std::size_t>(level - levels.begin());
  throw InputError(value.where, "repeatability.reference: unknown noise level '{}'{}", name,
                   suggestion(name, namesOf(levels)));
}

}  // namespace

RepeatabilityChoice readRepeatabilityChoice(const Pipeline& pipeline) {
  RepeatabilityChoice choice;
  Fields fields(pipeline.root.valueOf("repeatability"), "repeatability");
  fields.also({"scans", "noise", "reference", "methods", "object", "margin_m", "icp"}).finish();
  choice.scans = static_cast<std::uint32_t>(fields.integer("scans", 2, kMostScans, choice.scans));
  if (const Value* levels = fields.find("noise")) {
    choice.levels = readLevels(*levels, pipeline);
  } else {
    NoiseLevel& level = choice.levels.emplace_back();
    level.name = "the pipeline's effects";
    level.fromPipeline = true;
    for (const MountedSensor& sensor : pipeline.sensors) level.effects.push_back(sensor.effects);
  }
  if (const Value* reference = fields.find("reference")) choice.reference = readReference(*reference, choice.levels);
  if (const Value* methods = fields.find("methods")) {
    choice.methods = readSettings(*methods, "repeatability.methods");
  } else {
    const std::string name(pipeline.method.entry->name);
    const Value& options = pipeline.method.options;
    choice.methods = {{{settingName(name, options), name, flowText(options)}, pipeline.method}};
  }
  choice.object = fields.text("object", "");
  choice.margin = fields.number("margin_m", {0, 1000}, choice.margin);
  if (const Value* icp = fields.find("icp")) {
    Fields icpFields(*icp, "icp");
    choice.icpIterations = static_cast<int>(icpFields.integer("iterations", 1, 100'000, choice.icpIterations));
    icpFields.finish();
  }
  return choice;
}

Channels repeatabilityChannels(const Pipeline& pipeline) {
  Channels channels = Channel::Range;
  for (const NoiseLevel& level : readRepeatabilityChoice(pipeline).levels) {
    for (const auto& effects : level.effects) channels |= channelsFor(*effects, kRepeatabilityLayout.columns);
  }
  return channels;
}

double BoxedObject::distance(const Vec3d& worldPoint) const {
  const Vec3d p = meshFromWorld * worldPoint;
  const Vec3d nearestInBox{std::clamp(p.x, box.low.x, box.high.x), std::clamp(p.y, box.low.y, box.high.y),
                           std::clamp(p.z, box.low.z, box.high.z)};
  return length(worldFromMesh.linear * (p - nearestInBox));
}

}  // namespace scanmill
