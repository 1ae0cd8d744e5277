#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <set>

#include "base/error.h"
#include "base/terminal.h"
#include "pipeline/read/pipeline.h"
#include "scene/scene.h"
#include "scenefile/scene_file.h"
#include "sensors/trajectory.h"

namespace scanmill {

namespace {

using Trajectories = std::vector<std::shared_ptr<const Trajectory>>;

// Reads a list of trajectories. `period`: duration of the slowest sensor's revolution (s). `lanes`: lanes of the
// scene's town; may be null if no trajectory follows a lane. `seed`: the scene's seed, which determines the sway of the
// vehicle.
Trajectories readTrajectories(const Value& list, double period, const SceneLanes* lanes = nullptr,
                              std::uint64_t seed = 0) {
  const std::vector<Value>& items = readList(list, "trajectories");
  Trajectories trajectories;
  std::map<std::string, std::string> nameByKeyPart;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const std::uint32_t drives = countDrives(items[i]);
    for (std::uint32_t drive = 0; drive < drives; ++drive) {
      const auto& trajectory = trajectories.emplace_back(std::make_shared<const Trajectory>(
          readTrajectory(items[i], fmt::format("t{}", i), period, lanes, seed, drive)));
      if (trajectory->name().empty()) {
        throw InputError(items[i].where, "a trajectory's name becomes part of file names, so it must not be empty");
      }
      const auto [entry, isNew] = nameByKeyPart.emplace(keyPart(trajectory->name()), trajectory->name());
      if (isNew) continue;
      throw InputError(items[i].where,
                       "two trajectories are named '{}' and '{}', both '{}' in file names: give one another name",
                       entry->second, trajectory->name(), entry->first);
    }
  }
  return trajectories;
}

// Reads a seed or a list of seeds without repetitions; returns {1} if `value` is null.
std::vector<std::uint64_t> readSeeds(const Value* value) {
  if (value == nullptr) return {1};
  constexpr std::int64_t kLargestSeed = 1'000'000'000'000;
  const std::vector<PlacedInteger> placedSeeds =
      value->kind == Value::Kind::Sequence
          ? readIntegers(*value, "seeds", 0, kLargestSeed)
          : std::vector<PlacedInteger>{{readInteger(*value, "seeds", 0, kLargestSeed), value->where}};
  std::vector<std::uint64_t> seeds;
  std::set<std::int64_t> distinctSeeds;
  for (const PlacedInteger& seed : placedSeeds) {
    if (!distinctSeeds.insert(seed.value).second) {
      throw InputError(seed.where, "seed {} is listed twice: both sequences would be the same", seed.value);
    }
    seeds.push_back(static_cast<std::uint64_t>(seed.value));
  }
  if (seeds.empty()) throw InputError(value->where, "seeds must name at least one seed");
  return seeds;
}

bool sameItems(const std::vector<Value>& a, const std::vector<Value>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Value& x, const Value& y) { return flowText(x) == flowText(y); });
}

// Returns the items of the key `without`, as takeOut() needs them; none if `value` is null.
std::vector<Value> readWithout(const Value* value) {
  if (value == nullptr || value->kind == Value::Kind::Null) return {};
  const bool isListOfScalars =
      value->kind == Value::Kind::Sequence &&
      std::ranges::all_of(value->items, [](const Value& item) { return item.kind == Value::Kind::Scalar; });
  if (!isListOfScalars) {
    throw InputError(value->where,
                     "without must be a list of classes, names of objects and instance ids, such as "
                     "[car, 17]; each value of a sweep is such a list: [[], [car]]");
  }
  return value->items;
}

// Returns a lower bound of the number of frames that a list of trajectories has for one seed: the sum of the stated
// numbers, and 1 for each trajectory without a number.
std::uint64_t leastFrames(const Value& list) {
  std::uint64_t least = 0;
  for (const Value& trajectory : list.items) {
    const Value* const frames = trajectory.find("frames");
    std::uint64_t stated = 1;
    if (frames != nullptr) std::from_chars(frames->text.data(), frames->text.data() + frames->text.size(), stated);
    least += stated;
  }
  return least;
}

constexpr double kTimeRounding = 1e-6;  // revolutions; exceeds the rounding errors of times

// Returns how many revolutions of a sensor have ended by `time` (s).
std::uint64_t endedRevolutions(double time, double period) {
  return static_cast<std::uint64_t>(time / period + kTimeRounding);
}

}  // namespace

std::string keyPart(std::string_view text) {
  std::string key;
  for (std::size_t index = 0; index < text.size();) {
    const Utf8Character character = utf8At(text, index);
    if (character.code < 0x80) {
      const int byte = static_cast<int>(character.code);
      key += std::isalnum(byte) != 0 || byte == '-' ? static_cast<char>(std::tolower(byte)) : '_';
    } else {
      key += character.code == kNoCharacter ? "_" : fmt::format("u{:04x}", static_cast<std::uint32_t>(character.code));
    }
    index += character.bytes;
  }
  return key;
}

std::vector<Sequence> readSequences(Fields& fields, double period,
                                    const std::function<void(std::uint64_t)>& checkFrames) {
  const Value* sharedTrajectories = fields.find("trajectories");
  // Reports errors in the list even if no scene uses it. A list with `along` can be read only with a scene's lanes.
  if (sharedTrajectories != nullptr && sharedTrajectories->findInItems("along") == nullptr)
    readTrajectories(*sharedTrajectories, period);
  std::vector<Sequence> sequences;
  std::set<std::string> keys;
  std::uint64_t frames = 0;
  for (const Value& item : readList(fields.require("scenes"), "scenes")) {
    Fields scene(item, "scene");
    scene.also({"scene", "seeds", "moving", "without", "trajectories"}).finish();
    const std::filesystem::path file = scene.resource("scene", "scenes");
    const std::vector<std::uint64_t> seeds = readSeeds(scene.find("seeds"));
    const bool moving = scene.boolean("moving", true);
    const std::vector<Value> without = readWithout(scene.find("without"));
    const Value* sceneTrajectories = scene.find("trajectories");
    const Value* list = sceneTrajectories == nullptr ? sharedTrajectories : sceneTrajectories;
    if (list == nullptr)
      throw InputError(item.where, "no trajectories: give the scene or the pipeline the key `trajectories`");
    const Value* along = list->findInItems("along");
    Trajectories trajectories = along != nullptr ? Trajectories{} : readTrajectories(*list, period);
    checkFrames(frames + seeds.size() * leastFrames(*list));
    for (const std::uint64_t seed : seeds) {
      if (along != nullptr) {
        const std::optional<SceneLanes> lanes = readSceneLanes(file, seed);
        if (!lanes) {
          throw InputError(along->where, "`along` follows the lanes of a town, but {} has no town: give waypoints",
                           file.string());
        }
        trajectories = readTrajectories(*list, period, &*lanes, seed);
      }
      checkFrames(frames);
      for (const auto& trajectory : trajectories) {
        sequences.push_back({.scene = keyPart(file.stem().string()),
                             .sceneFile = file,
                             .sceneSeed = seed,
                             .trajectory = trajectory,
                             .trajectoryName = trajectory->name(),
                             .frames = trajectory->frames(),
                             .moving = moving,
                             .without = without});
        frames += trajectory->frames();
        if (!keys.insert(sequences.back().key()).second) {
          throw InputError(item.where,
                           "two sequences have the key '{}': list the scene once, or give one scene file another name",
                           sequences.back().key());
        }
      }
    }
  }
  return sequences;
}

std::vector<Sequence> recordedSequences(const Recording& recording, Fields& fields) {
  std::vector<Sequence> sequences;
  for (const RecordedSequence& s : recording.sequences) {
    const std::string without = fmt::format("[{}]", fmt::join(s.without, ", "));
    sequences.push_back({.scene = s.scene,
                         .sceneFile = {},
                         .sceneSeed = s.seed,
                         .trajectory = nullptr,
                         .trajectoryName = s.trajectory,
                         .frames = s.frames,
                         .without = parseYaml(without, recording.folder.string()).items});
  }
  // Objects cannot be removed from recorded hits: `without` must be as in the recording.
  const Value* scenes = fields.find("scenes");
  if (scenes == nullptr) return sequences;
  for (const Value& scene : scenes->items) {
    const Value* value = scene.find("without");
    const std::vector<Value> requestedItems = readWithout(value);
    const Value* name = scene.find("scene");
    for (const Sequence& s : sequences) {
      const bool isSameScene = name != nullptr && keyPart(std::filesystem::path(name->text).stem().string()) == s.scene;
      if (value == nullptr || !isSameScene || sameItems(requestedItems, s.without)) continue;
      throw InputError(
          value->where,
          fmt::format("{} was recorded with {}, and recorded hits cannot be changed: leave out `without`",
                      recording.folder.string(), s.without.empty() ? "all objects" : "other objects removed"));
    }
  }
  return sequences;
}

bool Sequence::turnsWithoutBreak(const Periods& periods) const {
  if (periods.shortest == periods.longest || trajectory == nullptr || !trajectory->regular()) return false;
  const double interval = trajectory->interval();
  return interval >= periods.shortest * (1 - kTimeRounding) && interval <= periods.longest * (1 + kTimeRounding);
}

std::vector<double> Sequence::revolutions(std::uint32_t frame, double period, const Periods& periods) const {
  std::vector<double> begins;
  if (!turnsWithoutBreak(periods)) {
    for (std::uint32_t revolution = 0; revolution < mostRevolutions(period, periods); ++revolution)
      begins.push_back(revolution * period);
    return begins;
  }
  const double start = trajectory->frameTime(frame);
  const std::uint64_t lastRevolution = endedRevolutions(start + trajectory->interval(), period);
  for (std::uint64_t revolution = endedRevolutions(start, period); revolution < lastRevolution; ++revolution) {
    begins.push_back(static_cast<double>(revolution) * period - start);
  }
  return begins;
}

double Sequence::totalRevolutions(double period, const Periods& periods) const {
  if (turnsWithoutBreak(periods)) return static_cast<double>(endedRevolutions(frames * trajectory->interval(), period));
  return static_cast<double>(frames) * mostRevolutions(period, periods);
}

std::uint32_t Sequence::mostRevolutions(double period, const Periods& periods) const {
  if (turnsWithoutBreak(periods)) {
    return static_cast<std::uint32_t>(std::ceil(trajectory->interval() / period - kTimeRounding));
  }
  const bool framesOverlap = trajectory != nullptr && trajectory->interval() < periods.longest * (1 - kTimeRounding);
  return framesOverlap ? 1 : static_cast<std::uint32_t>(endedRevolutions(periods.longest, period));
}

bool Sequence::sameScene(const Sequence& other) const {
  return scene == other.scene && sceneFile == other.sceneFile && sceneSeed == other.sceneSeed &&
         moving == other.moving && sameItems(without, other.without);
}

std::vector<std::uint32_t> Sequence::spreadFrames(std::uint32_t most) const {
  std::vector<std::uint32_t> spread;
  const std::uint64_t count = std::min(most, frames);
  for (std::uint64_t i = 0; i < count; ++i) {
    spread.push_back(static_cast<std::uint32_t>((i * 2 + 1) * frames / (count * 2)));
  }
  return spread;
}

std::string Sequence::key() const {
  return fmt::format("{}-{}", sceneName(), keyPart(trajectoryName));
}

}  // namespace scanmill
