#pragma once

// Fields without a builder, from a closed-form distance and a list of triangles; and particles to fly through them.

#include <array>
#include <bit>
#include <functional>
#include <numeric>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "base/random.h"
#include "methods/field/distance_field.h"
#include "methods/field/facet.h"
#include "methods/particle/options.h"
#include "methods/particle/particles.h"
#include "methods/world/world.h"

namespace scanmill {

using DistanceFunction = std::function<double(const Vec3d&)>;  // m -> m
using LooseTriangles = std::vector<std::array<Vec3d, 3>>;      // m, relative to the world's origin

// What particles read of triangles.
inline TriangleBlock blockOfTriangles(const LooseTriangles& triangles) {
  TriangleBlock block;
  for (const auto& corners : triangles) {
    const auto first = static_cast<std::uint32_t>(block.vertices.size());
    for (const Vec3d& corner : corners) block.vertices.push_back(Vec3f(corner));
    block.corners.push_back({first, first + 1, first + 2});
  }
  block.vertices.emplace_back();
  block.firstAlpha = static_cast<std::uint32_t>(block.corners.size());
  return block;
}

inline FieldShape levelsAround(const Vec3d& middle, double voxel, std::uint32_t voxels, std::uint32_t levels,
                               bool lists) {
  ParticleOptions options;
  options.voxel = voxel;
  options.voxels = voxels;
  options.levels = levels;
  options.refine = lists ? ParticleOptions::Refine::ByTriangle : ParticleOptions::Refine::None;
  const Box everything{middle - Vec3d{1, 1, 1} * 1e9, middle + Vec3d{1, 1, 1} * 1e9};
  return shapeOf(options, middle, everything, 1e6);
}

// What a corner of a full brick knows, from triangles at these squared distances (voxels of the level).
inline std::uint32_t cornerWord(const FieldShape& shape, const std::vector<double>& distance2, double distance,
                                std::vector<std::uint32_t>& lists) {
  if (distance > kNearestLimit) return kNoTriangle;
  if (distance2.empty()) return shape.lists ? kNoTriangle : 0;
  const auto nearest =
      static_cast<std::uint32_t>(std::min_element(distance2.begin(), distance2.end()) - distance2.begin());
  if (!shape.lists) return nearest;
  const auto begin = static_cast<std::uint32_t>(lists.size());
  for (std::uint32_t t = 0; t < distance2.size(); ++t) {
    if (distance2[t] <= kListLimit * kListLimit) lists.push_back(t);
  }
  if (lists.size() == begin) lists.push_back(nearest);
  lists.back() |= kLastOfList;
  return begin;
}

// Gives a field bricks that no builder made.
inline void setBricks(DistanceField& field, const std::vector<std::uint16_t>& distance,
                      const std::vector<std::uint32_t>& word, const std::vector<std::uint32_t>& lists) {
  field.pool = std::make_shared<BrickPool>(0);
  field.pool->distance.assign(distance.begin(), distance.end());
  field.pool->triangleOrList.assign(word.begin(), word.end());
  field.pool->lists.assign(lists.begin(), lists.end());
  field.distance = field.pool->distance;
  field.triangleOrList = field.pool->triangleOrList;
  field.lists = field.pool->lists;
}

// The field of surfaces that are so far away; the triangles, which approximate the surfaces, are named.
inline DistanceField fieldOf(const FieldShape& shape, const DistanceFunction& distance,
                             const LooseTriangles& triangles) {
  DistanceField field;
  field.shape = shape;
  field.levels = fieldLevels(shape);
  std::vector<Facet<double>> facets;
  for (const auto& t : triangles) facets.push_back(facetOf(t[0], t[1], t[2]));
  std::vector<double> distance2(triangles.size());
  std::vector<std::uint16_t> distances;
  std::vector<std::uint32_t> words;
  std::vector<std::uint32_t> lists;
  for (std::size_t l = 0; l < shape.levels.size(); ++l) {
    const LevelBox& box = shape.levels[l];
    const double voxel = std::ldexp(shape.voxel, static_cast<int>(l));
    for (std::uint64_t b = 0; b < box.size(); ++b) {
      const std::uint64_t at[3] = {b % box.bricks[0], b / box.bricks[0] % box.bricks[1],
                                   b / box.bricks[0] / box.bricks[1]};
      std::int64_t first[3];
      for (int k = 0; k < 3; ++k) first[k] = (box.firstBrick[k] + static_cast<std::int64_t>(at[k])) * kBrickVoxels;
      const auto corner = [&](double x, double y, double z) {
        return Vec3d{double(first[0]) + x, double(first[1]) + y, double(first[2]) + z} * voxel;
      };
      const double half = kBrickVoxels / 2.0;
      const double free = distance(corner(half, half, half)) / voxel;
      if (free >= kEmptyBrick + 1e-3) {
        field.table.push_back(std::bit_cast<std::uint32_t>(std::nextafter(static_cast<float>(free), 0.0f)));
        continue;
      }
      field.table.push_back(kFullBrick + static_cast<std::uint32_t>(words.size() / kBrickStride));
      for (int i = 0; i < kCornersPerBrick; ++i) {
        const Vec3d p =
            corner(i % kBrickCorners, i / kBrickCorners % kBrickCorners, double(i / (kBrickCorners * kBrickCorners)));
        const double away = distance(p) / voxel;
        const bool named = away <= kNearestLimit;
        for (std::size_t t = 0; named && t < facets.size(); ++t) {
          distance2[t] = facets[t].distance2(p.x, p.y, p.z) / (voxel * voxel);
        }
        distances.push_back(static_cast<std::uint16_t>(std::min(away / kDistanceStep, 65535.0)));
        words.push_back(cornerWord(shape, distance2, away, lists));
      }
      distances.push_back(0);
      words.push_back(kNoTriangle);
    }
  }
  setBricks(field, distances, words, lists);
  return field;
}

// `begin` and `end`: m along the direction; the field may end the way earlier.
inline void addParticle(const DistanceField& field, const Vec3d& origin, const Vec3d& direction, double begin,
                        double end, Particles& particles) {
  const double voxel = field.shape.voxel;
  const Box box = marchBox(field.shape);
  const auto inverse = [](double d) { return 1 / (std::fabs(d) < 1e-12 ? 1e-12 : d); };
  const auto cut = [&](double low, double high, double from, double along) {
    if (along != 0) end = std::min(end, ((along > 0 ? high : low) - from) / along);
  };
  cut(box.low.x, box.high.x, origin.x, direction.x);
  cut(box.low.y, box.high.y, origin.y, direction.y);
  cut(box.low.z, box.high.z, origin.z, direction.z);
  const auto put = [](std::vector<float>& column, double value) { column.push_back(static_cast<float>(value)); };
  const Vec3d place = (origin - field.shape.centre) * (1 / voxel);
  put(particles.origin[0], place.x);
  put(particles.origin[1], place.y);
  put(particles.origin[2], place.z);
  put(particles.direction[0], direction.x);
  put(particles.direction[1], direction.y);
  put(particles.direction[2], direction.z);
  put(particles.begin, begin / voxel);
  put(particles.end, end / voxel);
  if (!field.shape.lists) return;
  put(particles.worldOrigin[0], origin.x);
  put(particles.worldOrigin[1], origin.y);
  put(particles.worldOrigin[2], origin.z);
  put(particles.inverse[0], inverse(direction.x));
  put(particles.inverse[1], inverse(direction.y));
  put(particles.inverse[2], inverse(direction.z));
}

// By marchCpu(), over all threads.
inline HitRecords flown(const DistanceField& field, const TriangleBlock& triangles, std::uint32_t steps,
                        const Particles& particles) {
  HitRecords records;
  records.reset(particles.size());
  std::vector<std::uint32_t> all(particles.size());
  std::iota(all.begin(), all.end(), 0u);
  parallelFor(particles.size(), 1000, [&](std::size_t first, std::size_t last) {
    marchCpu(field, triangles, steps, particles, std::span(all).subspan(first, last - first), records);
  });
  return records;
}

struct HitRecord {
  float travelled;
  std::uint32_t triangle;
  Outcome outcome;
  std::uint32_t steps;

  bool operator==(const HitRecord&) const = default;
};

inline HitRecord recordOf(const HitRecords& records, std::size_t i) {
  return {records.travelled[i], records.triangle[i], records.outcomeOf(i), records.stepsOf(i)};
}

// Particle i alone.
inline HitRecord flownAlone(const DistanceField& field, const TriangleBlock& triangles, std::uint32_t steps,
                            const Particles& particles, std::size_t i) {
  HitRecords records;
  records.reset(particles.size());
  const auto which = static_cast<std::uint32_t>(i);
  marchCpu(field, triangles, steps, particles, std::span(&which, 1), records);
  return recordOf(records, i);
}

// Evenly over the sphere; case i of a stream.
inline Vec3d anyDirection(std::uint32_t stream, std::uint32_t i) {
  const RandomBlock r = randomBlock({.seed = 31, .frame = stream, .beam = i});
  const double z = 2 * uniform(r[0]) - 1;
  const double azimuth = 2 * kPi * uniform(r[1]);
  return {std::sqrt(1 - z * z) * std::cos(azimuth), std::sqrt(1 - z * z) * std::sin(azimuth), z};
}

// In [-1, 1]^3.
inline Vec3d anyPoint(std::uint32_t stream, std::uint32_t i) {
  const RandomBlock r = randomBlock({.seed = 32, .frame = stream, .beam = i});
  return {2 * uniform(r[0]) - 1, 2 * uniform(r[1]) - 1, 2 * uniform(r[2]) - 1};
}

}  // namespace scanmill
