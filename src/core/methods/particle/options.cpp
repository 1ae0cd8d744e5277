#include "methods/particle/options.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/short_text.h"

namespace scanmill {

namespace {

constexpr Range kVoxelRange{1e-3, 10};  // m, limits of the key voxel_m
constexpr std::uint32_t kMostVoxels = 1024;

using Backend = ParticleOptions::Backend;
using Refine = ParticleOptions::Refine;

constexpr std::pair<const char*, Backend> kBackends[] = {{"cpu", Backend::Cpu}, {"gl", Backend::Gl}};
constexpr std::pair<const char*, Refine> kRefines[] = {{"none", Refine::None}, {"triangle", Refine::ByTriangle}};

constexpr std::uint32_t kUsualLevels = 5;  // assumed for `levels: auto`; enough for ranges of 120 to 200 m
constexpr double kFarthestBrick = 1e15;    // largest lattice coordinate of a brick: its corners are exact in double

// Returns the point (m) with the lattice coordinates `corner`, whose unit is `size` (m).
Vec3d pointOf(const Corner& corner, double size) {
  return {static_cast<double>(corner[0]) * size, static_cast<double>(corner[1]) * size,
          static_cast<double>(corner[2]) * size};
}

// Returns the corner of level 0's brick grid that is nearest to a point (m, relative to the world's origin).
Corner nearestBrickCorner(const Vec3d& point, double voxel) {
  const auto nearest = [&](double coordinate) {
    const double index = std::floor(coordinate / (kBrickVoxels * voxel) + 0.5);
    if (std::fabs(index) < kFarthestBrick) return static_cast<std::int64_t>(index);
    throw Error(
        "particle: a sensor is {:g} m from the scene's origin, too far for voxels of {:g} m: take larger "
        "voxels (voxel_m)",
        coordinate, voxel);
  };
  return {nearest(point.x), nearest(point.y), nearest(point.z)};
}

// Returns the largest absolute coordinate of the box's corners relative to `centre` (m); 0 for an empty box.
double largestCoordinate(const Box& box, const Vec3d& centre) {
  if (box.empty()) return 0;
  const Vec3d low = box.low - centre;
  const Vec3d high = box.high - centre;
  return std::max(
      {std::fabs(low.x), std::fabs(low.y), std::fabs(low.z), std::fabs(high.x), std::fabs(high.y), std::fabs(high.z)});
}

}  // namespace

ParticleOptions readParticleOptions(Fields& fields) {
  ParticleOptions options;
  options.voxel = fields.number("voxel_m", kVoxelRange, options.voxel);
  const auto voxels = static_cast<std::uint32_t>(fields.integer("voxels", kFewestVoxels, kMostVoxels, options.voxels));
  if (voxels % kVoxelsStep != 0) {
    throw InputError(fields.require("voxels").where, "voxels must be a multiple of {}: {} or {}, not {}", kVoxelsStep,
                     voxels / kVoxelsStep * kVoxelsStep, (voxels / kVoxelsStep + 1) * kVoxelsStep, voxels);
  }
  options.voxels = voxels;
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
  const Corner centre = nearestBrickCorner(sensor, options.voxel);
  shape.centre = pointOf(centre, kBrickVoxels * options.voxel);
  // The reach (voxels of the level) is half the level's width minus half a brick minus one voxel: the middle of a
  // coarse level's box may be half a brick away from the field's centre, and the voxel is a margin.
  shape.reach = 0.5f * static_cast<float>(options.voxels) - (kHalfBrick + 1);
  std::uint32_t levels = options.levels;
  if (levels == 0) {
    // Reach (m) from the field's centre, which is up to half a brick away from the sensor along each axis.
    const double neededReach = std::min(range + kBrickVoxels * options.voxel, largestCoordinate(scene, shape.centre));
    const auto reachOfLevel = [&](std::uint32_t l) { return std::ldexp(double{shape.reach} * options.voxel, int(l)); };
    levels = 1;
    while (levels < kMaxLevels && reachOfLevel(levels - 1) < neededReach) ++levels;
  }
  const std::uint32_t bricks = options.voxels / kBrickVoxels;  // number of bricks along an edge of a level
  for (std::uint32_t l = 0; l < std::min(levels, kMaxLevels); ++l) {
    LevelBox box{.firstBrick = {}, .bricks = {bricks, bricks, bricks}};
    const std::int64_t half = (std::int64_t{1} << l) >> 1;  // so that the shift rounds to the nearest brick
    for (std::size_t k = 0; k < 3; ++k) box.firstBrick[k] = ((centre[k] + half) >> l) - bricks / 2;
    shape.levels.push_back(box);
  }
  shape.lists = options.refine == ParticleOptions::Refine::ByTriangle;
  return shape;
}

double fieldBytes(const ParticleOptions& options) {
  // Number of a level's full bricks in a street scene, divided by the square of the number of bricks along an edge.
  constexpr double kFullBricks = 3.0;
  constexpr double kCornerBytes = sizeof(std::uint16_t) + sizeof(std::uint32_t);  // distance, and triangle or list
  constexpr double kListBytes = 3000;  // bytes of a full brick's lists, measured in that scene
  constexpr double kEntryBytes = 4;    // bytes of a brick's table entry
  const double bricks = static_cast<double>(options.voxels) / kBrickVoxels;  // number along an edge
  const double bytesPerFullBrick =
      kBrickStride * kCornerBytes + (options.refine == Refine::ByTriangle ? kListBytes : 0);
  const double bytesPerLevel =
      bricks * bricks * kFullBricks * bytesPerFullBrick + bricks * bricks * bricks * kEntryBytes;
  return bytesPerLevel * (options.levels > 0 ? options.levels : kUsualLevels);
}

void checkField(const ParticleOptions& options, double memory) {
  constexpr double kTolerance = 2;
  const double bytes = fieldBytes(options);
  if (bytes <= kTolerance * memory) return;
  const auto mostVoxels = static_cast<std::uint32_t>(options.voxels / std::sqrt(bytes / memory));
  throw InputError(options.where,
                   "particle: the distance field would take about {}, but this process may take {}: choose "
                   "`voxels: {}` or fewer",
                   shortBytes(bytes), shortBytes(memory),
                   std::max(mostVoxels, kFewestVoxels) / kVoxelsStep * kVoxelsStep);
}

Box marchBox(const FieldShape& shape) {
  const LevelBox& outermost = shape.levels.back();
  const double voxel = std::ldexp(shape.voxel, int(shape.levels.size()) - 1);
  Corner low, high;  // in voxels of the outermost level
  for (std::size_t k = 0; k < 3; ++k) {
    low[k] = outermost.firstBrick[k] * kBrickVoxels + 1;
    high[k] = (outermost.firstBrick[k] + outermost.bricks[k]) * kBrickVoxels - 1;
  }
  return {pointOf(low, voxel), pointOf(high, voxel)};
}

}  // namespace scanmill
