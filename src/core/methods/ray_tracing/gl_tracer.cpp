#include "methods/ray_tracing/gl_tracer.h"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <list>
#include <mutex>
#include <span>
#include <string>
#include <utility>

#include "base/parallel.h"
#include "gpu/compute.h"
#include "methods/device/device_beams.h"

namespace scanmill {

namespace {

using enum ComputeTable::Texel;

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

// Some rings of a shot, whose hits a thread waits for.
struct Slice {
  const std::shared_ptr<const World>& world;
  const Shot& shot;
  const ShotFrame& frame;
  Channels channels;
  std::uint32_t firstRing, rings;
  float farthest, coplanar;

  std::size_t rays() const { return std::size_t{rings} * shot.beams->columns; }
  std::size_t firstRay() const { return std::size_t{firstRing} * shot.beams->columns; }
  // One dispatch does both.
  bool goesWith(const Slice& o) const {
    return world == o.world && shot.beams == o.shot.beams && channels == o.channels && firstRing == o.firstRing &&
           rings == o.rings && farthest == o.farthest && shot.worldFromSensor.size() == o.shot.worldFromSensor.size();
  }
};

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
      const Slice slice{world,    shot,    frame, hits.channels, first, std::min(rings, beams.rings - first),
                        farthest, coplanar};
      traceSlice(slice, hits, undecided, clock);
    }
  }

  std::string device() const { return device_.name(); }
  std::uint64_t mostTableBytes() const { return std::min(most_, device_.mostTableTexels() * sizeof(DeviceWord)); }

 private:
  // Dispatches whose hits the device makes, or the processor copies. While so many are, shots queue up, and then go
  // together.
  static constexpr std::size_t kInFlight = 3;
  static constexpr float kSplitDoubt = 0x1p-22f;                                 // Embree rounds the corners of parts
  static constexpr std::uint64_t kMostBytesTogether = std::uint64_t{256} << 20;  // of hits

  // Shots of one dispatch.
  struct Batch {
    explicit Batch(ComputeReadbacks& readbacks) : hits(readbacks) {}
    ComputeReadbacks::Lease hits;
    std::size_t rays = 0;
  };

  // What a thread waits for.
  struct Waiting {
    const Slice& slice;
    std::shared_ptr<Batch> batch;  // once the device has it
    std::size_t from = 0;          // ray of the batch
    std::exception_ptr failure;
  };

  std::uint32_t ringsAtOnce(const BeamTable& beams, Channels channels) const {
    const std::uint64_t bytes = std::min(most_, device_.mostBufferBytes());
    const std::uint64_t ray = std::max(DeviceBeams::kBytesPerRay, DeviceResolver::bytesPerRay(channels));
    const std::uint64_t rings = bytes / (ray * beams.columns);
    if (rings == 0) device_.fail("a ring of the sensor does not fit into a buffer");
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(rings, beams.rings));
  }

  void traceSlice(const Slice& slice, Hits& hits, std::vector<UndecidedRay>& undecided, StageClock& clock) {
    Waiting mine{slice, nullptr, 0, nullptr};
    std::span<const std::byte> columns;
    {
      const StageTimer timer(clock, "trace");
      submit(mine);
      columns = mine.batch->hits->wait();
    }
    const StageTimer timer(clock, "read_back");
    DeviceResolver::take(columns, {mine.batch->rays, mine.from, slice.rays()}, slice.firstRay(), hits, undecided);
  }

  // One thread after the other gives the device work: its own and what others wait for.
  void submit(Waiting& mine) {
    std::unique_lock lock(queueMutex_);
    queue_.push_back(&mine);
    while (mine.batch == nullptr && !mine.failure) {
      if (leading_) {
        changed_.wait(lock);
        continue;
      }
      leading_ = true;
      lock.unlock();
      std::shared_ptr<Batch> batch;
      std::vector<Waiting*> together;
      std::exception_ptr failure;
      try {
        batch = std::make_shared<Batch>(readbacks_);
        lock.lock();
        together = takeTogether();
        lock.unlock();
        isolated([&] { run(together, *batch); });
      } catch (...) {
        failure = std::current_exception();
      }
      if (!lock.owns_lock()) lock.lock();
      if (together.empty()) together = takeTogether();  // they fail, too
      for (Waiting* waiting : together) {
        waiting->failure = failure;
        if (!failure) waiting->batch = batch;
      }
      leading_ = false;
      changed_.notify_all();
    }
    if (mine.failure) std::rethrow_exception(mine.failure);
  }

  // The first in the queue, and what one dispatch can do besides.
  std::vector<Waiting*> takeTogether() {
    const Slice& first = queue_.front()->slice;
    const std::uint64_t bytes = std::max(DeviceResolver::bytesPerRay(first.channels), kFoundBytes) * first.rays();
    const std::uint64_t most =
        std::max<std::uint64_t>(std::min({most_, device_.mostBufferBytes(), kMostBytesTogether}) / bytes, 1);
    std::vector<Waiting*> together;
    together.reserve(queue_.size());
    for (auto it = queue_.begin(); it != queue_.end() && together.size() < most;) {
      if ((*it)->slice.goesWith(first)) {
        together.push_back(*it);
        it = queue_.erase(it);
      } else {
        ++it;
      }
    }
    return together;
  }

  void run(const std::vector<Waiting*>& together, Batch& batch) {
    const Slice& slice = together.front()->slice;
    DeviceBeams::Shots shots;
    float coplanar = 0;
    for (Waiting* waiting : together) {
      waiting->from = batch.rays;
      batch.rays += slice.rays();
      shots.shots.push_back(&waiting->slice.shot);
      shots.frames.push_back(&waiting->slice.frame);
      coplanar = std::max(coplanar, waiting->slice.coplanar);
    }
    holdWorld(slice.world);
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
    block.meshRoot = meshRoot_;
    block.placesRoot = placesRoot_;
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
                {{&nodes_, Uint32x4},
                 {&triangles_, Uint32x4},
                 {&cutouts_, Uint32x4},
                 {&holes_, Uint32},
                 {&placeNodes_, Uint32x4},
                 {&places_, Uint32x4}});
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

  // Meshes that revolutions share stay; where they stand is told anew for each, without waiting for the one before.
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
      device_.finish();
      if (!baked) shared_ = world->shared->number;
    }
    const DevicePlaces places = devicePlaces(embree_.get(), *world, meshes_);
    hold(placeNodes_, Uint32x4, std::span<const WideNode>(places.nodes), "hierarchy of placed meshes");
    hold(places_, Uint32x4, std::span<const DeviceWord>(places.places), "placed meshes");
    resolver_.holdPlaces(*world);
    meshRoot_ = baked ? meshes_.blocks.at(&world->baked).root : kNoRoot;
    placesRoot_ = places.nodes.empty() ? kNoRoot : 0;
    world_ = world;
  }

  template <class T>
  void hold(ComputeBuffer& buffer, ComputeTable::Texel texel, std::span<const T> array, const char* what) {
    holdTable(device_, buffer, texel, std::as_bytes(array), most_, std::string("scene's ") + what);
  }

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

  std::mutex queueMutex_;
  std::condition_variable changed_;
  std::list<Waiting*> queue_;
  bool leading_ = false;  // some thread gives the device work: it alone touches what the device holds
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
