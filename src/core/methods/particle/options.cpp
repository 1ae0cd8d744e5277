#include "methods/particle/options.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "base/error.h"
#include "config/named_options.h"

namespace scanmill {

namespace {

// Diameter in voxels of the smallest ball that is hit by every beam through its centre; see smallestSeen().
constexpr double kSmallestBall = 2;
constexpr Range kVoxelRange{1e-3, 10};  // m, limits of the key voxel_m
constexpr std::uint32_t kMostVoxels = 1024;
constexpr std::uint32_t kMarginVoxels = kHalfBrick + 1;

using Backend = ParticleOptions::Backend;
using Refine = ParticleOptions::Refine;

constexpr std::pair<const char*, Backend> kBackends[] = {{"cpu", Backend::Cpu}, {"gl", Backend::Gl}};
constexpr std::pair<const char*, Refine> kRefines[] = {{"none", Refine::None}, {"triangle", Refine::ByTriangle}};

std::uint32_t readVoxels(Fields& fields, std::uint32_t fallback) {
  const auto voxels = static_cast<std::uint32_t>(fields.integer("voxels", kFewestVoxels, kMostVoxels, fallback));
  if (voxels % kVoxelsStep != 0) {
    throw InputError(fields.require("voxels").where,
                     fmt::format("voxels must be a multiple of {}: {} or {}, not {}", kVoxelsStep,
                                 voxels / kVoxelsStep * kVoxelsStep, (voxels / kVoxelsStep + 1) * kVoxelsStep, voxels));
  }
  return voxels;
}

// Returns the distance from the sensor (m) up to which `level` and finer levels are used, in all directions. The sensor
// is up to half a brick of level 0 away from the field's centre along each axis.
double servedRange(const ParticleOptions& options, std::uint32_t level) {
  return levelReach(options, level) - kHalfBrick * options.voxel;
}

}  // namespace

ParticleOptions readParticleOptions(Fields& fields) {
  ParticleOptions options;
  options.voxel = fields.number("voxel_m", kVoxelRange, options.voxel);
  options.voxels = readVoxels(fields, options.voxels);
  const Value* levels = fields.find("levels");
  if (levels != nullptr && levels->text != "auto") {
    options.levels = static_cast<std::uint32_t>(fields.integer("levels", 1, kMaxLevels));
  }
  options.refine = namedChoice(fields, "refine", kRefines, options.refine).second;
  options.steps = static_cast<std::uint32_t>(fields.integer("steps", 16, 65535, options.steps));
  options.backend = namedChoice(fields, "backend", kBackends, options.backend).second;
  fields.finish();
  const Value* voxel = fields.find("voxel_m");
  options.where = voxel != nullptr ? voxel->where : fields.where();
  return options;
}

double levelReach(const ParticleOptions& options, std::uint32_t level) {
  return (0.5 * options.voxels - kMarginVoxels) * std::ldexp(options.voxel, static_cast<int>(level));
}

double levelBytes(double voxels, bool lists) {
  // Number of a level's full bricks in a street scene, divided by the square of the number of bricks along its edge.
  constexpr double kFullBricks = 3.0;
  constexpr double kBytes = kBrickStride * 6.0;  // bytes of a full brick: distances and words
  constexpr double kListBytes = 3000;            // bytes of a full brick's lists
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
  const std::uint32_t most = options.levels == 0 ? kMaxLevels : options.levels;
  for (std::uint32_t level = 0; level < most; ++level) {
    if (servedRange(options, level) < range) continue;
    return all ? 0 : kSmallestBall * std::ldexp(options.voxel, static_cast<int>(level));
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace scanmill
