#include "methods/ray_tracing/gl_tracer.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <span>
#include <string>
#include <utility>

#include "gpu/compute.h"
#include "methods/device_beams.h"

namespace scanmill {

namespace {

using enum ComputeTable::Texel;

const ComputeErrorWords kWords{"rays cannot be traced by OpenGL", "'backend: cpu' does without it"};

constexpr std::uint32_t kTileColumns = 8;  // of the shader
constexpr std::uint32_t kTileRings = 4;

// As the shader declares it, by the rules of std140.
struct TraceBlock {
  std::uint32_t columns, sliceRings, meshRoot, placesRoot, withOrigins;
  float duration, farthest, coplanar;
};
static_assert(sizeof(TraceBlock) == 32);

}  // namespace

void FoundTriangles::resize(std::size_t rays) {
  triangle.resize(rays);
  place.resize(rays);
}

class GlTracer::Inside {
 public:
  explicit Inside(const GlTracerLimits& limits) : device_(kWords), most_(limits.bytes) {
    // Buffers without storage cannot be read from.
    for (ComputeBuffer* buffer : {&nodes_, &triangles_, &cutouts_, &holes_, &placeNodes_, &places_})
      buffer->reserve(16);
    embree_ = makeDevice();
  }

  void trace(const std::shared_ptr<const World>& world, const Shot& shot, const ShotFrame& frame, float farthest,
             float coplanar, FoundTriangles& found, StageClock& clock) {
    const std::scoped_lock lock(mutex_);
    const BeamTable& beams = *shot.beams;
    found.resize(beams.size());
    TraceBlock block{};
    {
      const StageTimer timer(clock, "upload");
      holdWorld(world);
    }
    block.columns = beams.columns;
    block.meshRoot = meshRoot_;
    block.placesRoot = placesRoot_;
    block.withOrigins = beams.origin.empty() ? 0 : 1;
    block.duration = static_cast<float>(world->duration);
    block.farthest = farthest;
    block.coplanar = coplanar;
    const std::uint32_t rings = ringsAtOnce(beams);
    for (std::uint32_t first = 0; first < beams.rings; first += rings) {
      block.sliceRings = std::min(rings, beams.rings - first);
      traceSlice(shot, frame, first, block, world->duration > 0, found, clock);
    }
  }

  std::string device() const { return device_.name(); }

 private:
  std::uint32_t ringsAtOnce(const BeamTable& beams) const {
    const std::uint64_t bytes = std::min(most_, device_.mostBufferBytes());
    const std::uint64_t rings = bytes / (DeviceBeams::kBytesPerRay * beams.columns);
    if (rings == 0) device_.fail("a ring of the sensor does not fit into a buffer");
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(rings, beams.rings));
  }

  void traceSlice(const Shot& shot, const ShotFrame& frame, std::uint32_t firstRing, const TraceBlock& block,
                  bool moves, FoundTriangles& found, StageClock& clock) {
    const std::size_t first = std::size_t{firstRing} * block.columns;
    const std::size_t count = std::size_t{block.sliceRings} * block.columns;
    {
      const StageTimer timer(clock, "upload");
      beams_.hold(shot, frame, first, count, moves);
      found_.reserve(2 * count * sizeof(std::uint32_t));
    }
    {
      const StageTimer timer(clock, "trace");
      const std::uint64_t tiles = std::uint64_t{(block.columns + kTileColumns - 1) / kTileColumns} *
                                  ((block.sliceRings + kTileRings - 1) / kTileRings);
      program_.run(
          tiles * kTileColumns * kTileRings,
          {&beams_.directions(), &beams_.origins(), &beams_.times(), &beams_.poses(), &beams_.steps(), &found_},
          std::as_bytes(std::span(&block, 1)),
          {{&nodes_, Uint32x4},
           {&triangles_, Uint32x4},
           {&cutouts_, Uint32x4},
           {&holes_, Uint32},
           {&placeNodes_, Uint32x4},
           {&places_, Uint32x4}});
      device_.finish();
    }
    const StageTimer timer(clock, "read_back");
    const auto part = [&](auto& column) { return std::as_writable_bytes(std::span(column).subspan(first, count)); };
    const std::uint64_t bytes = count * sizeof(std::uint32_t);
    const ComputeBuffer::Target targets[]{{0, part(found.triangle)}, {bytes, part(found.place)}};
    found_.read(targets);
  }

  // Meshes that revolutions share stay; where they stand is told anew for each.
  void holdWorld(const std::shared_ptr<const World>& world) {
    if (world_.lock() == world) return;
    world_.reset();
    const bool baked = !world->baked.triangles.empty();
    if (baked || world->shared->number != shared_) {
      shared_ = 0;
      meshes_ = deviceMeshes(embree_.get(), *world);
      hold(nodes_, Uint32x4, std::span<const WideNode>(meshes_.nodes), "hierarchies");
      hold(triangles_, Uint32x4, std::span<const DeviceWord>(meshes_.triangles), "triangles");
      hold(cutouts_, Uint32x4, std::span<const DeviceWord>(meshes_.cutouts), "cut-out triangles");
      hold(holes_, Uint32, std::span<const std::uint32_t>(meshes_.holes), "cut-outs");
      DeviceMeshes kept;
      kept.blocks = std::move(meshes_.blocks);
      meshes_ = std::move(kept);
      if (!baked) shared_ = world->shared->number;
    }
    const DevicePlaces places = devicePlaces(embree_.get(), *world, meshes_);
    hold(placeNodes_, Uint32x4, std::span<const WideNode>(places.nodes), "hierarchy of placed meshes");
    hold(places_, Uint32x4, std::span<const DeviceWord>(places.places), "placed meshes");
    meshRoot_ = baked ? meshes_.blocks.at(&world->baked).root : kNoRoot;
    placesRoot_ = places.nodes.empty() ? kNoRoot : 0;
    device_.finish();
    world_ = world;
  }

  template <class T>
  void hold(ComputeBuffer& buffer, ComputeTable::Texel texel, std::span<const T> array, const char* what) {
    holdTable(device_, buffer, texel, std::as_bytes(array), most_, std::string("scene's ") + what);
  }

  std::mutex mutex_;
  DeviceHandle embree_;
  ComputeDevice device_;
  const std::uint64_t most_;
  ComputeProgram program_{device_, "ray tracing", traceShader()};
  DeviceBeams beams_{device_};
  ComputeBuffer found_{device_};
  ComputeBuffer nodes_{device_}, triangles_{device_}, cutouts_{device_}, holes_{device_};
  ComputeBuffer placeNodes_{device_}, places_{device_};
  std::weak_ptr<const World> world_;  // whose data the buffers hold
  std::uint64_t shared_ = 0;          // likewise: the number of the shared meshes, if nothing is baked besides
  DeviceMeshes meshes_;               // their blocks alone
  std::uint32_t meshRoot_ = kNoRoot;
  std::uint32_t placesRoot_ = kNoRoot;
};

GlTracer::GlTracer(const GlTracerLimits& limits) : inside_(std::make_unique<Inside>(limits)) {}

GlTracer::~GlTracer() = default;

void GlTracer::trace(const std::shared_ptr<const World>& world, const Shot& shot, const ShotFrame& frame,
                     float farthest, float coplanar, FoundTriangles& found, StageClock& clock) {
  inside_->trace(world, shot, frame, farthest, coplanar, found, clock);
}

std::string GlTracer::device() const {
  return inside_->device();
}

}  // namespace scanmill
