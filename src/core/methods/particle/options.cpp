#include "methods/particle/options.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/short_text.h"
#include "config/fields.h"

namespace scanmill {

namespace {

constexpr Range kVoxelRange{1e-3, 10};  // m, limits of the key voxel_m
constexpr std::uint32_t kMostVoxels = 1024;

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

constexpr std::uint32_t kUsualLevels = 5;  // assumed for `levels: auto`; enough for ranges of 120 to 200 m
constexpr double kFarthestBrick = 1e15;    // largest lattice coordinate of a brick: its corners are exact in double

std::array<double, 3> axes(const Vec3d& v) {
  return {v.x, v.y, v.z};
}

// Returns the corner with the smallest coordinates of a brick of level 0 (m, relative to the world's origin).
Vec3d placeOf(const Corner& brick, double voxel) {
  const double size = kBrickVoxels * voxel;
  return {static_cast<double>(brick[0]) * size, static_cast<double>(brick[1]) * size,
          static_cast<double>(brick[2]) * size};
}

Corner nearestBrick(const Vec3d& point, double voxel) {
  Corner brick;
  const std::array<double, 3> p = axes(point);
  for (std::size_t k = 0; k < 3; ++k) {
    const double index = std::floor(p[k] / (kBrickVoxels * voxel) + 0.5);
    if (!(std::fabs(index) < kFarthestBrick)) {
      throw Error(
          fmt::format("particle: a sensor is {:g} m from the scene's origin, too far for voxels of {:g} m: take larger "
                      "voxels (voxel_m)",
                      p[k], voxel));
    }
    brick[k] = static_cast<std::int64_t>(index);
  }
  return brick;
}

// Returns the largest absolute coordinate of the box's corners relative to `centre` (m).
double reachOf(const Box& box, const Vec3d& centre) {
  if (box.empty()) return 0;
  double most = 0;
  for (const Vec3d& corner : {box.low - centre, box.high - centre}) {
    for (const double x : axes(corner)) most = std::max(most, std::fabs(x));
  }
  return most;
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

FieldShape shapeOf(const ParticleOptions& options, const Vec3d& sensor, const Box& scene, double range) {
  FieldShape shape;
  shape.voxel = options.voxel;
  const Corner centre = nearestBrick(sensor, options.voxel);
  shape.centre = placeOf(centre, options.voxel);
  // The middle of a coarse level's box may be half a brick away from the centre; one more voxel is a margin.
  shape.reach = 0.5f * static_cast<float>(options.voxels) - (kHalfBrick + 1);
  std::uint32_t levels = options.levels;
  if (levels == 0) {
    const double need = std::min(range + kBrickVoxels * options.voxel, reachOf(scene, shape.centre));
    levels = 1;
    while (levels < kMaxLevels && std::ldexp(double{shape.reach} * options.voxel, int(levels) - 1) < need) ++levels;
  }
  const std::uint32_t across = options.voxels / kBrickVoxels;
  for (std::uint32_t l = 0; l < std::min(levels, kMaxLevels); ++l) {
    LevelBox box;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int64_t half = (std::int64_t{1} << l) >> 1;
      box.firstBrick[k] = ((centre[k] + half) >> l) - across / 2;
      box.bricks[k] = across;
    }
    shape.levels.push_back(box);
  }
  shape.lists = options.refine == ParticleOptions::Refine::ByTriangle;
  return shape;
}

double fieldBytes(const ParticleOptions& options) {
  // Number of a level's full bricks in a street scene, divided by the square of the number of bricks along its edge.
  constexpr double kFullBricks = 3.0;
  constexpr double kBytes = kBrickStride * 6.0;  // bytes of a full brick: distances and words
  constexpr double kListBytes = 3000;            // bytes of a full brick's lists
  const double across = static_cast<double>(options.voxels) / kBrickVoxels;
  const double perBrick = kBytes + (options.refine == Refine::ByTriangle ? kListBytes : 0);
  const double perLevel = across * across * kFullBricks * perBrick + across * across * across * 4;
  return perLevel * (options.levels > 0 ? options.levels : kUsualLevels);
}

void checkField(const ParticleOptions& options, double memory) {
  constexpr double kTolerance = 2;
  const double bytes = fieldBytes(options);
  if (bytes <= kTolerance * memory) return;
  const auto most = static_cast<std::uint32_t>(options.voxels / std::sqrt(bytes / memory));
  throw InputError(
      options.where,
      fmt::format("particle: the distance field would take about {}, but this process may take {}: choose "
                  "`voxels: {}` or fewer",
                  shortBytes(bytes), shortBytes(memory), std::max(most, kFewestVoxels) / kVoxelsStep * kVoxelsStep));
}

Box marchBox(const FieldShape& shape) {
  const LevelBox& last = shape.levels.back();
  const double voxel = std::ldexp(shape.voxel, int(shape.levels.size()) - 1);
  const auto corner = [&](double shift, bool high) {
    std::array<double, 3> p;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int64_t brick = last.firstBrick[k] + (high ? std::int64_t{last.bricks[k]} : 0);
      p[k] = (static_cast<double>(brick * kBrickVoxels) + shift) * voxel;
    }
    return Vec3d{p[0], p[1], p[2]};
  };
  return {corner(1, false), corner(-1, true)};
}

}  // namespace scanmill
