#include "methods/ray_tracing/gl_tracer.h"

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

// As the shaders declare them, by the rules of std140.
struct TraceBlock {
  std::uint32_t columns, sliceRings, meshRoot, placesRoot, withOrigins, moves;
  float farthest, coplanar;
};
static_assert(sizeof(TraceBlock) == 32);
struct ResolveBlock {
  ResolverBlock common;
  std::uint32_t columns, withOrigins, moves;
  std::uint32_t unused[3];
};
static_assert(sizeof(ResolveBlock) == 48);

}  // namespace

class GlTracer::Inside {
 public:
  explicit Inside(const GlTracerLimits& limits) : device_(kWords), most_(limits.bytes) {
    // Buffers without storage cannot be read from.
    for (ComputeBuffer* buffer : {&nodes_, &triangles_, &cutouts_, &holes_, &placeNodes_, &places_})
      buffer->reserve(16);
    embree_ = makeDevice();
  }

  void trace(const std::shared_ptr<const World>& world, const Shot& shot, const ShotFrame& frame, float farthest,
             float coplanar, Hits& hits, std::vector<UndecidedRay>& undecided, StageClock& clock) {
    const BeamTable& beams = *shot.beams;
    const std::uint32_t rings = ringsAtOnce(beams, hits.channels);
    for (std::uint32_t first = 0; first < beams.rings; first += rings) {
      TraceBlock block{};
      block.columns = beams.columns;
      block.sliceRings = std::min(rings, beams.rings - first);
      block.withOrigins = beams.origin.empty() ? 0 : 1;
      block.moves = world->duration > 0 ? 1 : 0;
      block.farthest = farthest;
      block.coplanar = coplanar;
      const Slice slice{world, shot, frame, std::size_t{first} * beams.columns, hits.channels};
      traceSlice(slice, block, hits, undecided, clock);
    }
  }

  std::string device() const { return device_.name(); }

 private:
  // Of shots whose hits the device makes, or the processor copies.
  static constexpr std::size_t kInFlight = 3;

  struct Slice {
    const std::shared_ptr<const World>& world;
    const Shot& shot;
    const ShotFrame& frame;
    std::size_t firstRay;
    Channels channels;
  };

  std::uint32_t ringsAtOnce(const BeamTable& beams, Channels channels) const {
    const std::uint64_t bytes = std::min(most_, device_.mostBufferBytes());
    const std::uint64_t ray = std::max(DeviceBeams::kBytesPerRay, DeviceResolver::bytesPerRay(channels));
    const std::uint64_t rings = bytes / (ray * beams.columns);
    if (rings == 0) device_.fail("a ring of the sensor does not fit into a buffer");
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(rings, beams.rings));
  }

  void traceSlice(const Slice& slice, TraceBlock& block, Hits& hits, std::vector<UndecidedRay>& undecided,
                  StageClock& clock) {
    const std::size_t count = std::size_t{block.sliceRings} * block.columns;
    const ComputeReadbacks::Lease readback(readbacks_);
    {
      const std::scoped_lock lock(mutex_);
      const StageTimer timer(clock, "upload");
      holdWorld(slice.world);
      block.meshRoot = meshRoot_;
      block.placesRoot = placesRoot_;
      device_.atOnce([&] {
        beams_.hold(slice.shot, slice.frame, slice.firstRay, count, slice.world->duration);
        found_.reserve(2 * count * sizeof(std::uint32_t));
        resolver_.reserve(slice.channels, count);
        run(slice, block, count);
        readback->start(resolver_.columns(), DeviceResolver::bytesPerRay(slice.channels) * count);
      });
    }
    std::span<const std::byte> columns;
    {
      const StageTimer timer(clock, "trace");
      columns = readback->wait();
    }
    const StageTimer timer(clock, "read_back");
    DeviceResolver::take(columns, slice.firstRay, count, hits, undecided);
  }

  void run(const Slice& slice, const TraceBlock& block, std::size_t count) {
    const std::uint64_t tiles = std::uint64_t{(block.columns + kTileColumns - 1) / kTileColumns} *
                                ((block.sliceRings + kTileRings - 1) / kTileRings);
    tracer_.run(tiles * kTileColumns * kTileRings,
                {&beams_.directions(), &beams_.origins(), &beams_.parts(), &beams_.poses(), &beams_.steps(), &found_},
                std::as_bytes(std::span(&block, 1)),
                {{&nodes_, Uint32x4},
                 {&triangles_, Uint32x4},
                 {&cutouts_, Uint32x4},
                 {&holes_, Uint32},
                 {&placeNodes_, Uint32x4},
                 {&places_, Uint32x4}});
    const ResolveBlock resolve{DeviceResolver::block(*slice.shot.beams, slice.channels, count),
                               block.columns,
                               block.withOrigins,
                               block.moves,
                               {}};
    resolve_.run(count,
                 {&beams_.directions(), &beams_.origins(), &beams_.parts(), &beams_.poses(), &beams_.steps(), &found_,
                  &resolver_.columns()},
                 std::as_bytes(std::span(&resolve, 1)),
                 {resolver_.table(0), resolver_.table(1), resolver_.table(2), resolver_.table(3), resolver_.table(4)});
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
      resolver_.holdMeshes(*world);
      if (!baked) shared_ = world->shared->number;
    }
    const DevicePlaces places = devicePlaces(embree_.get(), *world, meshes_);
    hold(placeNodes_, Uint32x4, std::span<const WideNode>(places.nodes), "hierarchy of placed meshes");
    hold(places_, Uint32x4, std::span<const DeviceWord>(places.places), "placed meshes");
    resolver_.holdPlaces(*world);
    meshRoot_ = baked ? meshes_.blocks.at(&world->baked).root : kNoRoot;
    placesRoot_ = places.nodes.empty() ? kNoRoot : 0;
    device_.finish();
    world_ = world;
  }

  template <class T>
  void hold(ComputeBuffer& buffer, ComputeTable::Texel texel, std::span<const T> array, const char* what) {
    holdTable(device_, buffer, texel, std::as_bytes(array), most_, std::string("scene's ") + what);
  }

  std::mutex mutex_;  // of the device and what it holds
  DeviceHandle embree_;
  ComputeDevice device_;
  const std::uint64_t most_;
  ComputeProgram tracer_{device_, "ray tracing", traceShader()};
  ComputeProgram resolve_{device_, "resolving", resolveShader()};
  DeviceBeams beams_{device_};
  DeviceResolver resolver_{device_, most_};
  ComputeBuffer found_{device_};
  ComputeBuffer nodes_{device_}, triangles_{device_}, cutouts_{device_}, holes_{device_};
  ComputeBuffer placeNodes_{device_}, places_{device_};
  std::weak_ptr<const World> world_;  // whose data the buffers hold
  std::uint64_t shared_ = 0;          // likewise: the number of the shared meshes, if nothing is baked besides
  DeviceMeshes meshes_;               // their blocks alone
  std::uint32_t meshRoot_ = kNoRoot;
  std::uint32_t placesRoot_ = kNoRoot;
  ComputeReadbacks readbacks_{device_, kInFlight};
};

GlTracer::GlTracer(const GlTracerLimits& limits) : inside_(std::make_unique<Inside>(limits)) {}

GlTracer::~GlTracer() = default;

void GlTracer::trace(const std::shared_ptr<const World>& world, const Shot& shot, const ShotFrame& frame,
                     float farthest, float coplanar, Hits& hits, std::vector<UndecidedRay>& undecided,
                     StageClock& clock) {
  inside_->trace(world, shot, frame, farthest, coplanar, hits, undecided, clock);
}

std::string GlTracer::device() const {
  return inside_->device();
}

}  // namespace scanmill
