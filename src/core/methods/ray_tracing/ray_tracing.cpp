// Ray tracing with Embree: the reference of all methods.
//
// The scene is rebased to an origin near the sensor and traced in float32, 16 beams at a time; the range is recomputed
// in double from the triangle that was hit. Where a device of OpenGL is asked for, or is faster, it makes the hits of
// most rays, and the processor those of which rounding leaves a doubt (gl_tracer.h): with the same bytes.

#include "methods/ray_tracing/ray_tracing.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "base/parallel.h"
#include "base/stage_clock.h"
#include "gpu/device.h"
#include "methods/backend_choice.h"
#include "methods/device/device_tables.h"
#include "methods/ray_tracing/gl_tracer.h"
#include "methods/ray_tracing/options.h"
#include "methods/ray_tracing/packet.h"
#include "methods/ray_tracing/unobstructed.h"
#include "methods/world/worlds.h"
#include "scene/simplify.h"

namespace scanmill {

namespace {

constexpr double kRingWeight = 3.5;
constexpr std::uint64_t kBytesPerSceneTriangle = 40;  // measured: the scene's own mesh

// A device, and whether it takes the shots.
struct TracingBackend {
  std::unique_ptr<GlTracer> gl;  // null: none
  BackendChoice choice;

  TracingBackend(BackendChoice::Asked asked, std::unique_ptr<GlTracer> tracer)
      : gl(std::move(tracer)), choice(asked, gl != nullptr ? gl->device() : "", "rays are traced") {}
};

// One that may be faster than the processor; null where there is none, or none that works. Who names one is told why it
// does not.
std::unique_ptr<GlTracer> findTracer() {
  try {
    return mayHaveCard() ? std::make_unique<GlTracer>() : nullptr;
  } catch (const Error& error) {
    if (!namedDevice().empty()) warn(fmt::format("rays are traced on the processor: {}", error.what()));
    return nullptr;
  }
}

// That of all scenes of a run, since a choice costs four scans. A device is opened for the first shot, which plans and
// reports have none of, and never closed: the driver may be gone by the time that the program ends.
TracingBackend& automaticBackend() {
  static auto* const one = std::make_unique<TracingBackend>(BackendChoice::Asked::Auto, findTracer()).release();
  return *one;
}

// Columns of a packet's tile: as square as possible in angle, since packets trace best when their beams stay together.
std::uint32_t bestTileColumns(const BeamTable& beams) {
  if (beams.rings < 2 || beams.raysPerBeam > 1) return kPacket;
  const auto [low, high] = std::minmax_element(beams.elevation.begin(), beams.elevation.end());
  const double down = beams.elevation.empty() ? 0 : (*high - *low) / (beams.rings - 1);
  const double across = 2 * kPi / beams.columns;
  std::uint32_t best = kPacket;
  double bestSpread = INFINITY;
  for (std::uint32_t width = kPacket; width >= 1; width /= 2) {
    const std::uint32_t rings = kPacket / width;
    const double spread = std::max(across * width, kRingWeight * down * rings);
    if (spread < bestSpread) {
      bestSpread = spread;
      best = width;
    }
  }
  return best;
}

// How a table's rays are split into packets.
class Tiling {
 public:
  // `columns` of a packet; 0: what is best.
  Tiling(const BeamTable& beams, int columns)
      : beams_(beams),
        width_(columns != 0 ? static_cast<std::uint32_t>(columns) : bestTileColumns(beams)),
        rows_(kPacket / width_),
        across_((beams.columns + width_ - 1) / width_) {}

  std::size_t size() const { return std::size_t{across_} * ((beams_.rings + rows_ - 1) / rows_); }

  Tile tile(std::size_t i) const {
    const auto ring = static_cast<std::uint32_t>(i / across_) * rows_;
    const auto column = static_cast<std::uint32_t>(i % across_) * width_;
    return {ring, column, std::min(rows_, beams_.rings - ring), std::min(width_, beams_.columns - column)};
  }

  // Numbers of the packets that hold these rays. What Embree finds on an edge that two triangles share depends on which
  // rays travel together.
  std::vector<std::size_t> of(std::span<const UndecidedRay> rays) const {
    std::vector<std::size_t> numbers;
    for (const UndecidedRay& undecided : rays) {
      const std::uint32_t ring = undecided.ray / beams_.columns;
      numbers.push_back(std::size_t{ring / rows_} * across_ + undecided.ray % beams_.columns / width_);
    }
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
    return numbers;
  }

 private:
  const BeamTable& beams_;
  std::uint32_t width_, rows_, across_;
};

HierarchyOptions hierarchy(const RayTracingOptions& options) {
  return {options.robust, options.quality, tieFilter, alphaTieFilter, thingFilter};
}

class RayTracing : public Method {
 public:
  RayTracing(const Scene& scene, const RayTracingOptions& options)
      : original_(scene),
        simplified_(options.simplify < 1 ? std::make_unique<const Scene>(simplified(scene, options.simplify))
                                         : nullptr),
        scene_(simplified_ ? *simplified_ : scene),
        options_(options),
        worlds_(scene_, options.instancing, hierarchy(options)),
        materials_(compactMaterials(scene_)),
        asked_(options.backend == BackendChoice::Asked::Auto
                   ? nullptr
                   : std::make_unique<TracingBackend>(options.backend, options.backend == BackendChoice::Asked::Gl
                                                                           ? std::make_unique<GlTracer>()
                                                                           : nullptr)) {}

  TraceAccount prepare(const Shot& shot) const override {
    worldOf(shot);
    return {};
  }

  TraceAccount trace(const Shot& shot, Channels channels, Hits& hits) const override {
    const std::shared_ptr<const World> world = worldOf(shot);
    const ShotFrame frame = frameOf(shot, world->origin);
    const PacketJob job{*world, materials_,      shot,
                        frame,  options_.packet, coplanarFloor(static_cast<float>(length(frame.position.front())))};
    StageClock clock;
    if (asked_ == nullptr && shot.beams->size() < BackendChoice::kFewRays) {  // no device is opened for it
      traceOnProcessor(job, channels, hits);
      return {};
    }
    TracingBackend& backend = asked_ != nullptr ? *asked_ : automaticBackend();
    const auto onProcessor = [&](Hits& made, StageClock& stages) {
      const WallTimer timer;
      traceOnProcessor(job, channels, made);
      if (backend.gl != nullptr) stages.add("trace", timer.seconds());  // else it is the only stage
    };
    const auto onDevice = [&](Hits& made, StageClock& stages) {
      made.reset(shot.beams->rings, shot.beams->columns, channels);
      std::vector<UndecidedRay> open;
      backend.gl->trace(world, shot, frame, searchDistance(*shot.beams), job.coplanarFloor, made, open, stages);
      const StageTimer timer(stages, "undecided");
      const Tiling tiling(*shot.beams, options_.tileColumns);
      const std::vector<std::size_t> numbers = tiling.of(open);
      traceTiles(
          job, numbers.size(), [&](std::size_t i) { return tiling.tile(numbers[i]); }, made);
    };
    backend.choice.trace(shot.beams->size(), onDevice, onProcessor, hits, clock);
    TraceAccount account{clock.seconds(), {}};
    if (const std::string by = backend.choice.outcome(); !by.empty()) account.backends.insert("rays: " + by);
    return account;
  }

  std::vector<std::string> modelled() const override {
    std::uint64_t instancedCount = 0;
    for (const Instance& i : scene_.instances) instancedCount += worlds_.instanced(i.mesh) ? 1 : 0;
    const bool alpha =
        std::any_of(scene_.materials.begin(), scene_.materials.end(), [](const Material& m) { return m.alphaTested; });
    const bool textured = std::any_of(materials_.begin(), materials_.end(),
                                      [](const CompactMaterial& m) { return m.texture != nullptr; });
    return {
        fmt::format("geometry: {}, one hit per ray{}",
                    simplified_ ? fmt::format("simplified meshes, {} of {} placed triangles", scene_.placedTriangles(),
                                              original_.placedTriangles())
                                : std::string("exact triangles"),
                    options_.robust ? ", watertight" : ""),
        instancedCount > 0 ? fmt::format("instancing: {} placed objects share their meshes", instancedCount)
                           : std::string("instancing: left out, the scene is small enough to be flattened"),
        alpha ? "alpha cut-outs: modelled, some materials have them" : "alpha cut-outs: left out, no material has one",
        textured ? "reflectance textures: modelled" : "reflectance textures: left out, no material has one",
        worlds_.moves()
            ? "motion of objects: every beam meets them where they are when it fires; shapes change from turn to turn"
            : "motion of objects: left out, none moves",
        backendLine(),
    };
  }

  std::uint64_t memoryBytes() const override {
    const std::uint64_t inScenes = original_.triangles() + (simplified_ ? scene_.triangles() : 0);
    return worlds_.memoryBytes() + inScenes * kBytesPerSceneTriangle;
  }

  const Worlds* worlds() const override { return simplified_ ? nullptr : &worlds_; }

 private:
  std::shared_ptr<const World> worldOf(const Shot& shot) const {
    return worlds_.near(shot.worldFromSensor.front().translation, shot.time, shot.duration);
  }

  void traceOnProcessor(const PacketJob& job, Channels channels, Hits& hits) const {
    const BeamTable& beams = *job.shot.beams;
    hits.reset(beams.rings, beams.columns, channels);
    const Tiling tiling(beams, options_.tileColumns);
    traceTiles(
        job, tiling.size(), [&](std::size_t i) { return tiling.tile(i); }, hits);
  }

  template <class TileAt>
  static void traceTiles(const PacketJob& job, std::size_t count, const TileAt& tileAt, Hits& hits) {
    parallelFor(count, 128, [&](std::size_t first, std::size_t last) {
      std::vector<Tile> tiles;
      tiles.reserve(last - first);
      for (std::size_t i = first; i < last; ++i) tiles.push_back(tileAt(i));
      tracePackets(job, tiles, hits);
    });
  }

  // The same on every machine, but where the device that is asked for holds too little.
  std::string backendLine() const {
    switch (options_.backend) {
      case BackendChoice::Asked::Cpu:
        return "rays meet triangles on the processor";
      case BackendChoice::Asked::Auto:
        return fmt::format(
            "rays meet triangles on the processor or, where there is one, a graphics card (about {:.0f} MiB there for "
            "the scene), "
            "whichever takes the first scan faster: both give the same bytes",
            deviceMebibytes());
      case BackendChoice::Asked::Gl:
        break;
    }
    const bool fits = worlds_.triangles() * kResolverBytesPerTriangle <= asked_->gl->mostTableBytes();
    return fmt::format(
        "rays meet triangles by OpenGL on {} (about {:.0f} MiB there for the scene), and by Embree where "
        "rounding leaves a "
        "doubt{}",
        asked_->gl->device(), deviceMebibytes(),
        fits ? "" : "; their planes and labels are more than a table there holds: take backend: cpu");
  }

  double deviceMebibytes() const {
    constexpr double kMebibyte = 1024.0 * 1024;
    const std::uint64_t meshes = worlds_.triangles() * (kDeviceBytesPerTriangle + kResolverBytesPerTriangle);
    return static_cast<double>(meshes + texelTableBytes(scene_)) / kMebibyte;
  }

  const Scene& original_;
  std::unique_ptr<const Scene> simplified_;  // null: the original is traced
  const Scene& scene_;                       // that is traced
  RayTracingOptions options_;
  Worlds worlds_;
  std::vector<CompactMaterial> materials_;
  std::unique_ptr<TracingBackend> asked_;  // null: automaticBackend()
};

}  // namespace

std::unique_ptr<Method> makeRayTracing(const Scene& scene, Fields& options) {
  return std::make_unique<RayTracing>(scene, readRayTracingOptions(options));
}

}  // namespace scanmill
