#include "methods/particle/options.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "config/text.h"

namespace scanmill {

namespace {

// Diameter of the smallest ball that every beam through its middle meets, in voxels; see smallestSeen().
constexpr double kSmallestBall = 0.5;
constexpr double kSlack = 1 + 1e-12;               // 0.3 / 0.5 must not fall short of 0.6
constexpr Range kVoxelRange{1e-3, kLargestVoxel};  // m
constexpr std::uint32_t kMostVoxels = 1024;
constexpr Range kWithinRange{0.1, 1e4};  // m
constexpr std::uint32_t kMarginVoxels = kHalfBrick + 1;

// Reads the name of one of the values, the first where there is none.
template <class T, std::size_t n>
T named(Fields& fields, std::string_view key, const std::pair<const char*, T> (&values)[n], T fallback) {
  std::vector<std::string> names;
  std::string_view usual;
  for (const auto& [name, value] : values) {
    names.emplace_back(name);
    if (value == fallback) usual = name;
  }
  const std::string chosen = fields.choice(key, names, usual);
  const auto found =
      std::find_if(std::begin(values), std::end(values), [&](const auto& v) { return chosen == v.first; });
  return found->second;
}

using Backend = ParticleOptions::Backend;
using Extent = ParticleOptions::Extent;
using Refine = ParticleOptions::Refine;

constexpr std::pair<const char*, Backend> kBackends[] = {
    {"auto", Backend::Auto}, {"cpu", Backend::Cpu}, {"gl", Backend::Gl}};
constexpr std::pair<const char*, Extent> kExtents[] = {{"sensor", Extent::Sensor}, {"scene", Extent::Scene}};
constexpr std::pair<const char*, Refine> kRefines[] = {
    {"none", Refine::None}, {"normal", Refine::ByNormal}, {"triangle", Refine::ByTriangle}};

bool isWord(const Value* value, std::string_view word) {
  return value != nullptr && value->kind == Value::Kind::Scalar && value->text == word;
}

std::uint32_t readVoxels(Fields& fields, std::uint32_t fallback) {
  const auto voxels = static_cast<std::uint32_t>(fields.integer("voxels", kFewestVoxels, kMostVoxels, fallback));
  if (voxels % kVoxelsStep != 0) {
    throw InputError(fields.require("voxels").where,
                     fmt::format("voxels must be a multiple of {}: {} or {}, not {}", kVoxelsStep,
                                 voxels / kVoxelsStep * kVoxelsStep, (voxels / kVoxelsStep + 1) * kVoxelsStep, voxels));
  }
  return voxels;
}

// How many levels there may be.
std::uint32_t mostLevels(const ParticleOptions& options) {
  return options.levels == 0 ? kMaxLevels : options.levels;
}

// The coarsest level whose voxels are at most `largest`, which those of level 0 are.
std::uint32_t coarsestLevel(const ParticleOptions& options, double largest) {
  std::uint32_t level = 0;
  while (level + 1 < mostLevels(options) && std::ldexp(options.voxel, static_cast<int>(level) + 1) <= largest * kSlack)
    ++level;
  return level;
}

// m, how far the sensor is off the field's centre, along each axis: half a brick of level 0.
double offCentre(const ParticleOptions& options) {
  return kHalfBrick * options.voxel;
}

// m from the sensor: so far do `level` and finer ones serve in all directions.
double servedRange(const ParticleOptions& options, std::uint32_t level) {
  return levelReach(options, level) - offCentre(options);
}

// The fewest voxels across with which `level` reaches `range`; more than kMostVoxels where that many do not.
std::uint32_t voxelsFor(ParticleOptions options, std::uint32_t level, double range) {
  options.voxels = kFewestVoxels;
  while (options.voxels <= kMostVoxels && servedRange(options, level) < range) options.voxels += kVoxelsStep;
  return options.voxels;
}

// "about 12 MiB a level"
std::string levelMemory(double voxels) {
  return fmt::format("about {} a level", memoryText(levelBytes(voxels, false)));
}

// What the user asks to see, and what else was given.
struct Wish {
  double smallest = 0;  // m
  double within = 0;    // m; infinite: everywhere
  bool voxelGiven = false;
  bool voxelsGiven = false;
  Location where;

  // m, voxels at `within` may have.
  double largestVoxel() const { return smallest / kSmallestBall; }
  std::string text() const {
    return fmt::format("the smallest ball that every beam through its middle meets shall be one of {:g} m{}, which",
                       smallest, std::isinf(within) ? std::string() : fmt::format(" within {:g} m", within));
  }
};

// Chooses voxel and voxels for a field without lists.
void grant(const Wish& wish, ParticleOptions& options) {
  const double largest = wish.largestVoxel();
  if (options.voxel > largest * kSlack) {
    if (wish.voxelGiven) {
      throw InputError(wish.where, fmt::format("{} takes voxels of at most {:.4g} m: voxel_m is {:g}", wish.text(),
                                               largest, options.voxel));
    }
    options.voxel = largest;
  }
  if (options.extent == Extent::Scene) return;  // its voxels are alike everywhere
  std::uint32_t level = coarsestLevel(options, largest);
  if (!wish.voxelGiven && servedRange(options, level) < wish.within) {
    // Voxels that double to the largest allowed reach farthest.
    while (level + 1 < mostLevels(options) && std::ldexp(largest, -static_cast<int>(level)) > options.voxel * kSlack)
      ++level;
    options.voxel = std::min(std::ldexp(largest, -static_cast<int>(level)), kVoxelRange.high);
  }
  if (servedRange(options, level) >= wish.within) return;
  const std::uint32_t voxels = voxelsFor(options, level, wish.within);
  const double outThere = std::ldexp(options.voxel, static_cast<int>(level));
  if (voxels <= kMostVoxels && !wish.voxelsGiven) {
    options.voxels = voxels;
    return;
  }
  const double exact = 2 * ((wish.within + offCentre(options)) / outThere + kMarginVoxels);
  const std::uint32_t most = wish.voxelsGiven ? options.voxels : kMostVoxels;
  const double reach = outThere * (0.5 * most - kMarginVoxels) - offCentre(options);
  throw InputError(
      wish.where,
      fmt::format("{} takes voxels of {:.4g} m out there, and {:.0f} of them across each level ({}), but {}; give "
                  "{}a larger smallest_m, or refine: triangle without smallest_m, which sees objects of any size",
                  wish.text(), outThere, std::ceil(exact / kVoxelsStep) * kVoxelsStep, levelMemory(exact),
                  wish.voxelsGiven ? fmt::format("voxels is {}", most) : fmt::format("at most {} are possible", most),
                  reach < kWithinRange.low
                      ? std::string()
                      : fmt::format("smallest_within_m up to {:.4g}, ", std::floor(reach * 1000) / 1000)));
}

// Keys of a field around the sensor mean nothing to one of the whole scene.
void refuseForScene(const Value* value, std::string_view key, std::string_view why) {
  if (value == nullptr) return;
  throw InputError(value->where, fmt::format("{}: {}: leave {} out, or take field: sensor", key, why, key));
}

void refuseForTriangles(const Value* value, std::string_view key, std::string_view why) {
  if (value == nullptr) return;
  throw InputError(value->where,
                   fmt::format("{}: refine: triangle {}: leave {} out, or take refine: normal or none", key, why, key));
}

}  // namespace

ParticleOptions readParticleOptions(Fields& fields) {
  ParticleOptions options;
  options.extent = named(fields, "field", kExtents, options.extent);
  Wish wish;
  wish.voxelGiven = fields.has("voxel_m");
  wish.voxelsGiven = fields.has("voxels");
  options.voxel = fields.number("voxel_m", kVoxelRange, options.voxel);
  options.voxels = readVoxels(fields, options.voxels);
  const Value* levels = fields.find("levels");
  if (levels != nullptr && !isWord(levels, "auto")) {
    options.levels = static_cast<std::uint32_t>(fields.integer("levels", 1, kMaxLevels));
    if (options.extent == Extent::Scene && options.levels > 1) {
      throw InputError(levels->where,
                       "levels: a field of the whole scene (field: scene) has one level: leave levels "
                       "out, or take field: sensor");
    }
  }
  options.refine = named(fields, "refine", kRefines, options.refine);
  options.cone = fields.number("cone_mrad", {0, 20}, 0) * 1e-3;
  options.steps = static_cast<std::uint32_t>(fields.integer("steps", 16, 65535, options.steps));
  options.backend = named(fields, "backend", kBackends, options.backend);
  const Value* smallest = fields.find("smallest_m");
  const Value* within = fields.find("smallest_within_m");
  wish.smallest = fields.number("smallest_m", {1e-3, 100}, 0);
  wish.within = fields.number("smallest_within_m", kWithinRange, 30);
  fields.finish();
  if (options.extent == Extent::Scene) {
    refuseForScene(fields.find("voxels"), "voxels",
                   "a field of the whole scene (field: scene) has as many voxels across as the scene takes");
    refuseForScene(within, "smallest_within_m", "a field of the whole scene (field: scene) is as fine everywhere");
    wish.within = std::numeric_limits<double>::infinity();
  }
  if (options.refine == Refine::ByTriangle) {
    refuseForTriangles(smallest, "smallest_m", "sees objects of any size");
    refuseForTriangles(within, "smallest_within_m", "sees objects of any size");
    if (options.cone > 0) refuseForTriangles(fields.find("cone_mrad"), "cone_mrad", "meets triangles exactly");
  }
  if (within != nullptr && smallest == nullptr) {
    throw InputError(within->where,
                     "smallest_within_m says how far from the sensor objects of smallest_m must be seen: "
                     "give smallest_m too");
  }
  const Value* voxel = fields.find("voxel_m");
  options.where = voxel != nullptr ? voxel->where : smallest != nullptr ? smallest->where : fields.where();
  if (smallest != nullptr) {
    wish.where = smallest->where;
    options.smallest = wish.smallest;
    grant(wish, options);
  }
  return options;
}

double levelReach(const ParticleOptions& options, std::uint32_t level) {
  return (0.5 * options.voxels - kMarginVoxels) * std::ldexp(options.voxel, static_cast<int>(level));
}

double levelBytes(double voxels, bool lists) {
  constexpr double kFullBricks = 3.0;            // of a street's level, in units of (bricks across)^2
  constexpr double kBytes = kBrickStride * 6.0;  // of a full brick: distances and words
  constexpr double kListBytes = 3000;            // and of its lists
  const double across = voxels / kBrickVoxels;
  return across * across * kFullBricks * (kBytes + (lists ? kListBytes : 0)) + across * across * across * 4;
}

std::string memoryText(double bytes) {
  constexpr double kMebibyte = 1024.0 * 1024;
  if (bytes >= 1024 * kMebibyte) return fmt::format("{:.1f} GiB", bytes / (1024 * kMebibyte));
  return fmt::format("{:.0f} MiB", std::max(1.0, bytes / kMebibyte));
}

double smallestSeen(const ParticleOptions& options, double range) {
  const bool all = options.refine == Refine::ByTriangle;
  if (options.extent == Extent::Scene) return all ? 0 : kSmallestBall * options.voxel;
  for (std::uint32_t level = 0; level < mostLevels(options); ++level) {
    if (servedRange(options, level) < range) continue;
    return all ? 0 : kSmallestBall * std::ldexp(options.voxel, static_cast<int>(level));
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace scanmill
