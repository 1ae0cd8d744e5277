// Ray tracing with Embree: the reference of all methods.
//
// The scene is shifted to an origin near the sensor and traced in float32, 16 beams at a time; the range is then
// recomputed in double from the triangle that was hit.

#include "methods/ray_tracing/ray_tracing.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "base/parallel.h"
#include "config/fields.h"
#include "methods/ray_tracing/packet.h"
#include "methods/ray_tracing/unobstructed.h"
#include "methods/world/worlds.h"

namespace scanmill {

namespace {

// Weight of angles between rings, relative to angles between columns, when the shape of tiles is chosen: on the ground,
// hits of rings are farther apart than hits of columns. Affects only the speed; the value was not measured.
constexpr double kRingWeight = 3.5;

// All values of `instancing` give the same hits, up to float32 rounding.
constexpr std::pair<const char*, Instancing> kInstancings[] = {
    {"auto", Instancing::Auto}, {"always", Instancing::Always}, {"never", Instancing::Never}};

// Returns the number of columns for which a packet's tile spans the smallest angle, where angles between rings count
// kRingWeight times: packets trace fastest when their beams are close together.
std::uint32_t bestTileColumns(const BeamTable& beams) {
  if (beams.rings < 2 || beams.raysPerBeam > 1) return kPacket;
  const auto [low, high] = std::ranges::minmax_element(beams.elevation);
  const double ringSpacing = beams.elevation.empty() ? 0 : (*high - *low) / (beams.rings - 1);  // rad, mean
  const double columnSpacing = 2 * kPi / beams.columns;                                         // rad
  const auto spread = [&](std::uint32_t columns) {
    return std::max(columnSpacing * columns, kRingWeight * ringSpacing * (kPacket / columns));
  };
  return std::ranges::min({16u, 8u, 4u, 2u, 1u}, {}, spread);
}

// Returns the packets of a table's rays.
std::vector<Tile> packetsOf(const BeamTable& beams) {
  const std::uint32_t width = bestTileColumns(beams);
  const std::uint32_t rows = kPacket / width;
  std::vector<Tile> tiles;
  for (std::uint32_t ring = 0; ring < beams.rings; ring += rows) {
    for (std::uint32_t column = 0; column < beams.columns; column += width) {
      tiles.push_back({.ring = ring,
                       .column = column,
                       .rows = std::min(rows, beams.rings - ring),
                       .width = std::min(width, beams.columns - column)});
    }
  }
  return tiles;
}

class RayTracing : public Method {
 public:
  // `simplify`: fraction of each mesh's triangles that is kept; 1: all.
  RayTracing(const Scene& scene, Instancing instancing, double simplify)
      : original_(scene),
        simplified_(simplify < 1 ? std::make_unique<const Scene>(simplified(scene, simplify)) : nullptr),
        scene_(simplified_ ? *simplified_ : scene),
        worlds_(scene_, instancing, {tieFilter, alphaTieFilter, thingFilter}),
        materials_(compactMaterials(scene_)) {}

  TraceAccount prepare(const Shot& shot) const override {
    worldOf(shot);
    return {};
  }

  TraceAccount trace(const Shot& shot, Channels channels, Hits& hits) const override {
    const std::shared_ptr<const World> world = worldOf(shot);
    const ShotFrame frame = frameOf(shot, world->origin, world->revolution.duration);
    const PacketJob job{*world, materials_, shot, frame,
                        coplanarFloor(static_cast<float>(length(frame.position.front())))};
    const BeamTable& beams = *shot.beams;
    hits.reset(beams.rings, beams.columns, channels);
    const std::vector<Tile> tiles = packetsOf(beams);
    constexpr std::size_t kGrain = 128;  // tiles per task
    parallelFor(tiles.size(), kGrain, [&](std::size_t first, std::size_t end) {
      tracePackets(job, std::span(tiles).subspan(first, end - first), hits);
    });
    return {};
  }

  std::vector<ModelledItem> modelled() const override {
    const bool instanced =
        std::ranges::any_of(scene_.instances, [&](const Instance& i) { return worlds_.instanced(i.mesh); });
    const std::string meshes = simplified_ ? fmt::format("simplified meshes, {} of {} placed triangles",
                                                         scene_.placedTriangles(), original_.placedTriangles())
                                           : "exact triangles";
    return {
        {"geometry", meshes + ", one hit per ray, watertight"},
        {"instancing",
         instanced ? "placed objects share meshes" : "since the scene is small enough for a copy of each mesh",
         !instanced},
        cutOutItem(scene_),
        textureItem(scene_),
        {"motion of objects",
         worlds_.moves()
             ? "every beam sees them where they are when it fires; their shapes change only between revolutions"
             : "no object moves",
         !worlds_.moves()},
        {"rays", fmt::format("traced by Embree {}", worlds_.embree())},
    };
  }

  std::uint64_t memoryBytes() const override {
    const std::uint64_t inScenes = original_.triangles() + (simplified_ ? scene_.triangles() : 0);
    return worlds_.memoryBytes() + inScenes * kBytesPerSceneTriangle;
  }

  const Worlds* worlds() const override { return simplified_ ? nullptr : &worlds_; }

 private:
  std::shared_ptr<const World> worldOf(const Shot& shot) const {
    const double reach = worlds_.moves() ? farthestEnd(shot) : INFINITY;
    return worlds_.near(shot.worldFromSensor.front().translation, reach, shot.time, shot.duration, shot.placed);
  }

  const Scene& original_;
  std::unique_ptr<const Scene> simplified_;  // null: the original scene is traced
  const Scene& scene_;                       // the scene that is traced
  Worlds worlds_;
  std::vector<CompactMaterial> materials_;
};

}  // namespace

std::unique_ptr<Method> makeRayTracing(const Scene& scene, Fields& options) {
  const Instancing instancing = namedChoice(options, "instancing", kInstancings, Instancing::Auto).second;
  const double simplify = options.number("simplify", {0.01, 1}, 1);
  options.finish();
  return std::make_unique<RayTracing>(scene, instancing, simplify);
}

}  // namespace scanmill
