#include "methods/particle/shape.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/memory.h"

namespace scanmill {

namespace {

constexpr double kMostBricks = 268'435'456;   // 2^28; the table of this many bricks takes 1 GiB
constexpr double kMostBricksAcross = 65'536;  // bricks along an axis: 2^19 voxels; float32 resolves 1/32 voxel there
constexpr std::uint32_t kUsualLevels = 5;     // assumed for `levels: auto`; enough for ranges of 120 to 200 m
constexpr double kFarthestBrick = 1e15;       // largest lattice coordinate of a brick: its corners are exact in double

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

FieldShape aroundSensor(const ParticleOptions& options, const Vec3d& sensor, const Box& scene, double range) {
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
  if (levels * std::pow(across, 3) > kMostBricks) {
    throw InputError(options.where, fmt::format("particle: {} levels of {} voxels across give a table of more than "
                                                "{:g} bricks: choose fewer voxels across, such as `voxels: 512`",
                                                levels, options.voxels, kMostBricks));
  }
  for (std::uint32_t l = 0; l < std::min(levels, kMaxLevels); ++l) {
    LevelBox box;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int64_t half = (std::int64_t{1} << l) >> 1;
      box.firstBrick[k] = ((centre[k] + half) >> l) - across / 2;
      box.bricks[k] = across;
    }
    shape.levels.push_back(box);
  }
  return shape;
}

struct Span {
  std::array<double, 3> first{}, bricks{};

  // Returns the factor by which voxels must be larger so that bricks are few enough and not too far from the origin; at
  // most 1 if they already are. NaN if the factor cannot be computed.
  double excess() const {
    double all = 1;
    double most = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      most = std::max({most, std::fabs(first[k]) / kFarthestBrick, bricks[k] / kMostBricksAcross});
      all *= bricks[k];
    }
    return std::max(std::cbrt(all / kMostBricks), most);
  }
};

// Returns the bricks that cover a box, with one more brick on each side.
Span spanOf(const Box& box, double voxel) {
  Span span;
  const std::array<double, 3> low = axes(box.low);
  const std::array<double, 3> high = axes(box.high);
  for (std::size_t k = 0; k < 3; ++k) {
    span.first[k] = std::floor(low[k] / (kBrickVoxels * voxel)) - 1;
    span.bricks[k] = std::floor(high[k] / (kBrickVoxels * voxel)) + 2 - span.first[k];
  }
  return span;
}

// Returns advice for a message about a field that is too large. `times`: factor by which the voxels of a field of the
// scene are too small, or by which a field around a sensor has too many voxels across.
std::string adviceFor(const ParticleOptions& options, double times) {
  if (options.extent == ParticleOptions::Extent::Sensor) {
    const auto most = static_cast<std::uint32_t>(std::max(options.voxels / times, double{kFewestVoxels}));
    return fmt::format("choose `voxels: {}` or fewer", most / kVoxelsStep * kVoxelsStep);
  }
  const double voxel = options.voxel * times * 1.03;  // 3 % more, for the bricks around the scene
  if (!(voxel <= kLargestVoxel)) return "choose `field: sensor`";
  const double unit = std::pow(10.0, std::floor(std::log10(voxel)) - 1);
  return fmt::format("choose `voxel_m: {:g}` or more, or `field: sensor`", std::ceil(voxel / unit) * unit);
}

// Returns the bricks of a field of the complete scene. Throws InputError if there would be too many bricks; the advice
// in its message considers `memory`, the bytes that the field may take.
Span sceneSpan(const ParticleOptions& options, const Box& box, double memory) {
  const Span span = spanOf(box, options.voxel);
  const double excess = span.excess();
  if (excess <= 1) return span;
  const Vec3d size = box.high - box.low;
  throw InputError(options.where,
                   fmt::format("particle: a field of the complete scene, {:.4g} x {:.4g} x {:.4g} m, would have too "
                               "many bricks with voxels of {:g} m: {}",
                               size.x, size.y, size.z, options.voxel,
                               adviceFor(options, std::max(excess, std::sqrt(fieldBytes(options, box) / memory)))));
}

FieldShape aroundScene(const ParticleOptions& options, const Box& box) {
  const Span span = sceneSpan(options, box, static_cast<double>(memoryLimitBytes()));
  FieldShape shape;
  shape.voxel = options.voxel;
  LevelBox level;
  Corner centre;
  for (std::size_t k = 0; k < 3; ++k) {
    level.firstBrick[k] = static_cast<std::int64_t>(span.first[k]);
    level.bricks[k] = static_cast<std::uint32_t>(span.bricks[k]);
    centre[k] = level.firstBrick[k] + level.bricks[k] / 2;
  }
  shape.centre = placeOf(centre, options.voxel);
  shape.reach = static_cast<float>(kBrickVoxels * *std::max_element(level.bricks.begin(), level.bricks.end()));
  shape.levels = {level};
  return shape;
}

}  // namespace

FieldShape shapeOf(const ParticleOptions& options, const Vec3d& sensor, const Box& scene, double range) {
  FieldShape shape;
  if (options.extent == ParticleOptions::Extent::Scene) {
    shape = aroundScene(options, scene.empty() ? Box{sensor, sensor} : scene);
  } else {
    shape = aroundSensor(options, sensor, scene, range);
  }
  shape.lists = options.refine == ParticleOptions::Refine::ByTriangle;
  return shape;
}

double fieldBytes(const ParticleOptions& options, const Box& scene) {
  const bool lists = options.refine == ParticleOptions::Refine::ByTriangle;
  if (options.extent == ParticleOptions::Extent::Sensor) {
    return levelBytes(options.voxels, lists) * (options.levels > 0 ? options.levels : kUsualLevels);
  }
  const Vec3d size = scene.empty() ? Vec3d{} : scene.high - scene.low;
  const double across = std::sqrt(std::max({size.x * size.y, size.y * size.z, size.z * size.x})) / options.voxel;
  // The table of bricks grows with the volume of the scene's box, all other arrays with the area of the box's sides.
  return levelBytes(across, lists) - std::pow(across / kBrickVoxels, 3) * 4 +
         size.x * size.y * size.z / std::pow(kBrickVoxels * options.voxel, 3) * 4;
}

void checkField(const ParticleOptions& options, const Box& scene, double memory) {
  constexpr double kTolerance = 2;
  if (options.extent == ParticleOptions::Extent::Scene && !scene.empty()) {
    // Fields are relative to a world's origin: the scene's centre, or another point of the grid of origins around it.
    sceneSpan(options, {scene.low - scene.center(), scene.high - scene.center()}, memory);
  }
  const double bytes = fieldBytes(options, scene);
  if (bytes <= kTolerance * memory) return;
  throw InputError(options.where,
                   fmt::format("particle: the distance field would take about {}, but this process may take {}: "
                               "{}",
                               memoryText(bytes), memoryText(memory), adviceFor(options, std::sqrt(bytes / memory))));
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
