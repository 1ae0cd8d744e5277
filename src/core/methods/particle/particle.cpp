// The particle method (LiDAR-GEIL): one particle per beam, sphere-traced through a distance field.
//
// The field is built around the sensor and moves with it (distance_field.h). Particles march in float32, on the CPU or
// in a compute shader, with the same steps (particles.h). The particles' hits are resolved in double precision from the
// triangles that the field stores, so that labels and normals need no further tracing.

#include "methods/particle/particle.h"

#include <fmt/core.h>

#include <algorithm>
#include <mutex>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/memory.h"
#include "base/parallel.h"
#include "base/stage_clock.h"
#include "methods/field/march_job.h"
#include "methods/gpu/device_resolver.h"
#include "methods/gpu/gl_marcher.h"
#include "methods/particle/field_store.h"
#include "methods/particle/options.h"
#include "methods/particle/particles.h"

namespace scanmill {

namespace {

constexpr std::size_t kTilesAtOnce = 128;  // largest number of tiles of a work item, whose hits stay in the L2 cache
constexpr std::size_t kFewestPieces = 64;  // least number of work items, to keep cores busy; fewer if tiles are fewer

// Returns the tile of a ring that begins at `column`: kPacket columns, or fewer at the end of the ring.
Tile tileAt(std::uint32_t ring, std::uint32_t column, std::uint32_t columns) {
  return {.ring = ring, .column = column, .rows = 1, .width = std::min<std::uint32_t>(kPacket, columns - column)};
}

// Divides the beams into tiles of kPacket columns of one ring. Returns the tiles of all rings for the first columns,
// then for the next, so that particles that march together stay close to each other and read nearby parts of the field.
std::vector<Tile> tilesOf(const BeamTable& beams) {
  std::vector<Tile> tiles;
  for (std::uint32_t column = 0; column < beams.columns; column += kPacket) {
    for (std::uint32_t ring = 0; ring < beams.rings; ++ring) {
      tiles.push_back(tileAt(ring, column, beams.columns));
    }
  }
  return tiles;
}

class ParticleMethod : public Method {
 public:
  ParticleMethod(const Scene& scene, ParticleOptions options)
      : scene_(scene),
        options_(std::move(options)),
        fields_(scene, options_),
        materials_(compactMaterials(scene)),
        gl_(options_.backend == ParticleOptions::Backend::Gl ? std::make_unique<GlMarcher>() : nullptr) {}

  TraceAccount prepare(const Shot& shot) const override {
    StageClock clock;
    fieldAround(shot, clock);
    return {clock.seconds(), {}};
  }

  TraceAccount trace(const Shot& shot, Channels channels, Hits& hits) const override {
    StageClock clock({"launch", "march", "resolve"});
    const SensorField around = fieldAround(shot, clock);
    const ShotFrame frame = frameOf(shot, around.world->origin);
    const MarchJob job{shot, frame, around, options_.steps};
    hits.reset(shot.beams->rings, shot.beams->columns, channels);
    const UnreliableBeams counts =
        gl_ != nullptr ? marchOnDevice(job, hits, clock) : marchOnCpu(job, tilesOf(*shot.beams), hits, clock);
    std::sort(hits.unresolved.begin(), hits.unresolved.end());
    return account(clock, shot, counts);
  }

  std::vector<ModelledItem> modelled() const override {
    const bool isExact = options_.refine == ParticleOptions::Refine::ByTriangle;
    std::vector<ModelledItem> items{
        {"distance field",
         fmt::format(
             "levels of {} voxels across around the sensor, voxels of {:g} m in the finest level, twice as large "
             "in each next level",
             options_.voxels, options_.voxel)},
        {"geometry", isExact ? "exact triangles, from the lists of the voxels that a beam passes, one hit per ray"
                             : "within half a voxel of the distance field, one hit per ray"}};
    items.push_back(cutOutItem(scene_));
    if (!isExact && !items.back().leftOut) {
      items.back() = {"alpha cut-outs", "since distance fields treat them as solid (`refine: triangle` models them)",
                      true};
    }
    items.push_back(textureItem(scene_));
    items.push_back({"backend", gl_ == nullptr ? "particles march on the processor"
                                               : fmt::format("particles march by OpenGL on {}", gl_->device())});
    items.push_back({"transmission through glass, mirror images, motion of objects", "", true});
    return items;
  }

  std::uint64_t memoryBytes() const override {
    return static_cast<std::uint64_t>(fieldBytes(options_)) * FieldStore::kFewestFields +
           scene_.placedTriangles() * kBytesPerPlacedTriangle + scene_.triangles() * kBytesPerSceneTriangle;
  }

 private:
  static constexpr std::uint64_t kBytesPerPlacedTriangle = 190;  // memory of the flattened scene, measured

  SensorField fieldAround(const Shot& shot, StageClock& clock) const {
    return fields_.around(shot.worldFromSensor.front().translation, shot.beams->maxRange, clock);
  }

  // Launches, marches and resolves the particles of tiles, in pieces of several tiles on all threads.
  UnreliableBeams marchOnCpu(const MarchJob& job, std::span<const Tile> tiles, Hits& hits, StageClock& clock) const {
    UnreliableBeams counts;
    std::mutex mutex;  // guards `counts` and `hits.unresolved`
    const std::size_t tilesOfPiece = std::clamp(tiles.size() / kFewestPieces, std::size_t{1}, kTilesAtOnce);
    const std::size_t pieces = (tiles.size() + tilesOfPiece - 1) / tilesOfPiece;
    parallelFor(pieces, 1, [&](std::size_t first, std::size_t last) {
      Particles particles;
      HitRecords records;
      std::vector<std::uint32_t> indices;  // indices of all particles of a piece
      UnreliableBeams countsOfThread;
      std::vector<std::uint32_t> unresolved;
      for (std::size_t p = first; p < last; ++p) {
        const auto piece = tiles.subspan(p * tilesOfPiece, std::min(tilesOfPiece, tiles.size() - p * tilesOfPiece));
        {
          const StageTimer timer(clock, "launch");
          launch(job, piece, particles);
          records.reset(particles.size());
          indices.resize(particles.size());
          std::iota(indices.begin(), indices.end(), 0u);
        }
        {
          const StageTimer timer(clock, "march");
          marchCpu(job.field(), job.triangles(), job.maxSteps, particles, indices, records);
        }
        const StageTimer timer(clock, "resolve");
        countsOfThread.add(resolve(job, materials_, piece, particles, records, hits, unresolved));
      }
      const std::scoped_lock lock(mutex);
      counts.add(countsOfThread);
      hits.unresolved.insert(hits.unresolved.end(), unresolved.begin(), unresolved.end());
    });
    return counts;
  }

  // Marches on the device. Where rounding could change the result of a ray, the CPU then marches the ray's whole tile.
  UnreliableBeams marchOnDevice(const MarchJob& job, Hits& hits, StageClock& clock) const {
    std::vector<UnresolvedRay> unresolved;
    gl_->march(job, hits, unresolved, clock);
    const StageTimer timer(clock, "undecided");
    const auto tileOf = [&](std::uint32_t ray) {
      const std::uint32_t column = ray % hits.columns / kPacket * kPacket;
      return tileAt(ray / hits.columns, column, hits.columns);
    };
    const auto firstRayOf = [&](const Tile& tile) { return tile.ring * hits.columns + tile.column; };
    std::vector<Tile> cpuTiles;  // in ascending order, because the rays are in ascending order
    for (const UnresolvedRay& ray : unresolved) {
      if (ray.reason != UnresolvedReason::Rounding) continue;
      const Tile tile = tileOf(ray.ray);
      if (cpuTiles.empty() || firstRayOf(cpuTiles.back()) != firstRayOf(tile)) cpuTiles.push_back(tile);
    }
    UnreliableBeams counts;
    for (const UnresolvedRay& ray : unresolved) {
      if (std::ranges::binary_search(cpuTiles, firstRayOf(tileOf(ray.ray)), {}, firstRayOf)) continue;
      ++(ray.reason == UnresolvedReason::StepsUsedUp ? counts.exhausted : counts.leftField);
      hits.range[ray.ray] = kMiss;
      hits.unresolved.push_back(ray.ray);
    }
    StageClock ignored;
    counts.add(marchOnCpu(job, cpuTiles, hits, ignored));
    return counts;
  }

  // Returns a shot's stage times, with a warning for each kind of unreliable beam.
  TraceAccount account(const StageClock& clock, const Shot& shot, const UnreliableBeams& counts) const {
    TraceAccount account{clock.seconds(), {}};
    const auto warn = [&](unsigned kind, std::uint64_t count, const std::string& problem) {
      if (count == 0) return;
      account.warn({.sensor = shot.sensorName,
                    .kind = kind,
                    .count = count,
                    .text = fmt::format("up to {} of a scan's {} beams of '{}' {}", count, shot.beams->size(),
                                        shot.sensorName, problem)});
    };
    warn(0, counts.exhausted,
         fmt::format("ran out of their {} steps and count neither as hits nor as misses: raise `steps`",
                     options_.steps));
    warn(1, counts.leftField,
         "left the distance field, which does not cover the scene to the sensor's range, and count neither as hits nor "
         "as misses: take `levels: auto`");
    warn(2, counts.touching,
         "start within half a voxel of a surface and end there: take smaller voxels (voxel_m), or `refine: triangle`");
    return account;
  }

  const Scene& scene_;
  ParticleOptions options_;
  FieldStore fields_;
  std::vector<CompactMaterial> materials_;
  std::unique_ptr<GlMarcher> gl_;  // null: particles march on the CPU
};

}  // namespace

std::unique_ptr<Method> makeParticle(const Scene& scene, Fields& options) {
  ParticleOptions particle = readParticleOptions(options);
  checkField(particle, static_cast<double>(memoryLimitBytes()));  // now, so that planning finds the error
  return std::make_unique<ParticleMethod>(scene, std::move(particle));
}

}  // namespace scanmill
