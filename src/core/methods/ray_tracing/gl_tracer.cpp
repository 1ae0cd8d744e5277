#include "methods/ray_tracing/gl_tracer.h"

#include <algorithm>
#include <span>
#include <string>

#include "gpu/compute.h"
#include "methods/device/device_beams.h"
#include "methods/device/shot_queue.h"
#include "methods/ray_tracing/held_world.h"

namespace scanmill {

namespace {

const ComputeErrorWords kWords{"rays cannot be traced by OpenGL", "'backend: cpu' does without it"};

constexpr std::uint32_t kTileColumns = 8;  // of the shader
constexpr std::uint32_t kTileRings = 4;
constexpr std::uint64_t kFoundBytes = 8;  // of a ray

// As the shaders declare them, by the rules of std140.
struct TraceBlock {
  std::uint32_t columns, sliceRings, shotRays, shotPoses, rays, meshRoot, placesRoot, withOrigins, moves;
  float farthest, coplanar, splitDoubt;
};
static_assert(sizeof(TraceBlock) == 48);
struct ResolveBlock {
  ResolverBlock common;
  std::uint32_t columns, shotRays, shotPoses, withOrigins, moves;
  std::uint32_t unused;
};
static_assert(sizeof(ResolveBlock) == 48);

// Some rings of a shot.
struct Slice {
  const std::shared_ptr<const World>& world;
  std::shared_ptr<const WorldPlaces> places;  // of the world; or null
  const Shot& shot;
  const ShotFrame& frame;
  Channels channels;
  std::uint32_t firstRing, rings;
  float farthest, coplanar;

  std::size_t rays() const { return std::size_t{rings} * shot.beams->columns; }
  std::size_t firstRay() const { return std::size_t{firstRing} * shot.beams->columns; }
  std::uint64_t bytes() const { return std::max(DeviceResolver::bytesPerRay(channels), kFoundBytes) * rays(); }
  bool goesWith(const Slice& o) const {
    return world == o.world && shot.beams == o.shot.beams && channels == o.channels && firstRing == o.firstRing &&
           rings == o.rings && farthest == o.farthest && shot.worldFromSensor.size() == o.shot.worldFromSensor.size();
  }
};

}  // namespace

class GlTracer::Inside {
 public:
  explicit Inside(const GlTracerLimits& limits) : device_(kWords), most_(limits.bytes) {}

  void trace(const std::shared_ptr<const World>& world, const Shot& shot, const ShotFrame& frame, float farthest,
             float coplanar, Hits& hits, std::vector<UndecidedRay>& undecided, StageClock& clock) {
    const BeamTable& beams = *shot.beams;
    const std::uint32_t rings = ringsAtOnce(beams, hits.channels);
    for (std::uint32_t first = 0; first < beams.rings; first += rings) {
      const Slice slice{world,    nullptr, shot, frame, hits.channels, first, std::min(rings, beams.rings - first),
                        farthest, coplanar};
      traceSlice(slice, hits, undecided, clock);
    }
  }

  std::string device() const { return device_.nameAndPlace(); }
  std::uint64_t mostTableBytes() const { return std::min(most_, device_.mostTableTexels() * sizeof(DeviceWord)); }

 private:
  using Queue = ShotQueue<Slice>;
  static constexpr float kSplitDoubt = 0x1p-22f;  // Embree rounds the corners of parts

  std::uint32_t ringsAtOnce(const BeamTable& beams, Channels channels) const {
    const std::uint64_t bytes = std::min(most_, device_.mostBufferBytes());
    const std::uint64_t ray = std::max(DeviceBeams::kBytesPerRay, DeviceResolver::bytesPerRay(channels));
    const std::uint64_t rings = bytes / (ray * beams.columns);
    if (rings == 0) device_.fail("a ring of the sensor does not fit into a buffer");
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(rings, beams.rings));
  }

  void traceSlice(Slice slice, Hits& hits, std::vector<UndecidedRay>& undecided, StageClock& clock) {
    Queue::Given given;
    std::span<const std::byte> columns;
    {
      const StageTimer timer(clock, "trace");
      slice.places = held_.placesOf(slice.world);
      given = queue_.give(slice);
      columns = given.batch->hits->wait();
    }
    const StageTimer timer(clock, "read_back");
    DeviceResolver::take(columns, {given.batch->rays, given.from, slice.rays()}, slice.firstRay(), hits, undecided);
  }

  void run(const std::vector<const Slice*>& together, Queue::Batch& batch) {
    const Slice& slice = *together.front();
    DeviceBeams::Shots shots;
    float coplanar = 0;
    for (const Slice* one : together) {
      shots.shots.push_back(&one->shot);
      shots.frames.push_back(&one->frame);
      coplanar = std::max(coplanar, one->coplanar);
    }
    held_.hold(slice.world, slice.places, resolver_);
    device_.atOnce([&] {
      beams_.hold(shots, slice.firstRay(), slice.rays(), slice.world->duration);
      found_.reserve(kFoundBytes * batch.rays);
      resolver_.reserve(slice.channels, batch.rays);
      runTrace(slice, together.size(), coplanar, batch.rays);
      runResolve(slice, batch.rays);
      batch.hits->start(resolver_.columns(), DeviceResolver::bytesPerRay(slice.channels) * batch.rays);
    });
  }

  void runTrace(const Slice& slice, std::size_t shots, float coplanar, std::size_t rays) {
    const BeamTable& beams = *slice.shot.beams;
    TraceBlock block{};
    block.columns = beams.columns;
    block.sliceRings = slice.rings;
    block.shotRays = static_cast<std::uint32_t>(slice.rays());
    block.shotPoses = static_cast<std::uint32_t>(slice.shot.worldFromSensor.size());
    block.rays = static_cast<std::uint32_t>(rays);
    block.meshRoot = held_.meshRoot();
    block.placesRoot = held_.placesRoot();
    block.withOrigins = beams.origin.empty() ? 0 : 1;
    block.moves = slice.world->duration > 0 ? 1 : 0;
    block.farthest = slice.farthest;
    block.coplanar = coplanar;
    block.splitDoubt = slice.world->splits ? kSplitDoubt : 0;
    const std::uint64_t tiles = std::uint64_t{(beams.columns + kTileColumns - 1) / kTileColumns} *
                                ((slice.rings + kTileRings - 1) / kTileRings);
    tracer_.run(shots * tiles * kTileColumns * kTileRings,
                {&beams_.directions(), &beams_.origins(), &beams_.parts(), &beams_.poses(), &beams_.steps(), &found_},
                std::as_bytes(std::span(&block, 1)),
                {held_.table(0), held_.table(1), held_.table(2), held_.table(3), held_.table(4), held_.table(5)});
  }

  void runResolve(const Slice& slice, std::size_t rays) {
    const BeamTable& beams = *slice.shot.beams;
    ResolveBlock block{};
    block.common = DeviceResolver::block(beams, slice.channels, rays);
    block.columns = beams.columns;
    block.shotRays = static_cast<std::uint32_t>(slice.rays());
    block.shotPoses = static_cast<std::uint32_t>(slice.shot.worldFromSensor.size());
    block.withOrigins = beams.origin.empty() ? 0 : 1;
    block.moves = slice.world->duration > 0 ? 1 : 0;
    resolve_.run(rays,
                 {&beams_.directions(), &beams_.origins(), &beams_.parts(), &beams_.poses(), &beams_.steps(), &found_,
                  &resolver_.columns()},
                 std::as_bytes(std::span(&block, 1)),
                 {resolver_.table(0), resolver_.table(1), resolver_.table(2), resolver_.table(3), resolver_.table(4)});
  }

  ComputeDevice device_;
  const std::uint64_t most_;
  ComputeProgram tracer_{device_, "ray tracing", traceShader()};
  ComputeProgram resolve_{device_, "resolving", resolveShader()};
  DeviceBeams beams_{device_};
  DeviceResolver resolver_{device_, most_};
  ComputeBuffer found_{device_};
  HeldWorld held_{device_, most_};
  Queue queue_{device_, std::min(most_, device_.mostBufferBytes()),
               [this](const std::vector<const Slice*>& together, Queue::Batch& batch) { run(together, batch); }};
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

std::uint64_t GlTracer::mostTableBytes() const {
  return inside_->mostTableBytes();
}

}  // namespace scanmill
