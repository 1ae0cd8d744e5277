// Ray tracing with Embree: the reference of all methods.
//
// The scene is rebased to an origin near the sensor and traced in float32, 16 beams at a time; the range is recomputed
// in double from the triangle that was hit. Where a device of OpenGL is asked for, or is faster, it finds the triangles
// of most rays, and Embree those of which rounding leaves a doubt (gl_tracer.h): with the same bytes.

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
      : gl(std::move(tracer)), choice(asked, gl != nullptr, "rays are traced") {}
};

// One that may be faster than the processor; null where there is none, or none that works.
std::unique_ptr<GlTracer> findTracer() {
  try {
    return mayHaveCard() ? std::make_unique<GlTracer>() : nullptr;
  } catch (const Error&) {
    return nullptr;
  }
}

// That of all scenes of a run, since a choice costs four scans. A device is opened for the first shot, which plans and
// reports have none of, and never closed: the driver may be gone by the time that the program ends.
TracingBackend& automaticBackend() {
  static auto* const one = std::make_unique<TracingBackend>(BackendChoice::Asked::Auto, findTracer()).release();
  return *one;
}

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
    TracingBackend& backend = asked_ != nullptr ? *asked_ : automaticBackend();
    StageClock clock;
    const auto onProcessor = [&](Hits& made, StageClock& stages) {
      const WallTimer timer;
      traceAll(job, channels, made);
      if (backend.gl != nullptr) stages.add("trace", timer.seconds());  // else it is the only stage
    };
    const auto onDevice = [&](Hits& made, StageClock& stages) {
      FoundTriangles found;
      backend.gl->trace(world, shot, frame, searchDistance(*shot.beams), job.coplanarFloor, found, stages);
      PacketJob rest = job;
      rest.found = &found;
      const StageTimer timer(stages, "resolve");
      traceAll(rest, channels, made);
    };
    backend.choice.trace(onDevice, onProcessor, hits, clock);
    return {clock.seconds(), {}};
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

  void traceAll(const PacketJob& job, Channels channels, Hits& hits) const {
    const BeamTable& beams = *job.shot.beams;
    hits.reset(beams.rings, beams.columns, channels);
    const std::uint32_t width = tileColumns(beams);
    const std::uint32_t rows = kPacket / width;
    const std::uint32_t across = (beams.columns + width - 1) / width;
    const std::uint32_t down = (beams.rings + rows - 1) / rows;
    parallelFor(std::size_t{across} * down, 128, [&](std::size_t first, std::size_t last) {
      std::vector<Tile> tiles;
      tiles.reserve(last - first);
      for (std::size_t i = first; i < last; ++i) {
        const auto ring = static_cast<std::uint32_t>(i / across) * rows;
        const auto column = static_cast<std::uint32_t>(i % across) * width;
        tiles.push_back({ring, column, std::min(rows, beams.rings - ring), std::min(width, beams.columns - column)});
      }
      tracePackets(job, tiles, hits);
    });
  }

  // The same on every machine, unless the pipeline asks for a device.
  std::string backendLine() const {
    switch (options_.backend) {
      case BackendChoice::Asked::Cpu:
        return "rays meet triangles on the processor";
      case BackendChoice::Asked::Auto:
        return "rays meet triangles on the processor or a graphics card, whichever takes the first scan faster: both "
               "give the same bytes";
      case BackendChoice::Asked::Gl:
        break;
    }
    constexpr double kMebibyte = 1024.0 * 1024;
    return fmt::format(
        "rays meet triangles on {}, which take about {:.0f} MiB there, and on the processor where "
        "rounding leaves a doubt",
        asked_->gl->device(), static_cast<double>(worlds_.triangles() * kDeviceBytesPerTriangle) / kMebibyte);
  }

  // Columns of a packet's tile: as square as possible in angle, since packets trace best when their beams stay
  // together.
  std::uint32_t tileColumns(const BeamTable& beams) const {
    if (options_.tileColumns != 0) return static_cast<std::uint32_t>(options_.tileColumns);
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
