// Launches particles, marches them and computes their hits, all on a device, in slices of limited size.

#include "methods/gpu/gl_marcher.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>

#include "gpu/compute.h"
#include "methods/field/march_rule.h"
#include "methods/gpu/device_beams.h"
#include "methods/gpu/device_march.h"
#include "methods/gpu/shot_queue.h"

namespace scanmill {

namespace {

const ComputeErrorWords kWords{"particles cannot march by OpenGL", "`backend: cpu` does not need it"};

// The parameters of launchShader(), in std140 layout.
struct LaunchBlock {
  double low[4], high[4], centre[4];
  double farthest;
  std::uint32_t rings, columns, first, count, withOrigins, shotParticles, shotPoses;
  std::uint32_t unused[3];
};
static_assert(sizeof(LaunchBlock) == 144);

// The parameters of particleHitsShader(), in std140 layout.
struct HitsBlock {
  ResolverBlock common;
  std::uint32_t rings, columns, first, count, withOrigins, shotParticles, shotRays, shotPoses;
  std::uint32_t firstAlpha, whole, last;
  std::int32_t lastLevel;
  float reach, metres;
  double voxel, ends;
  double low[4], high[4], centre[4];
  double trust, aside, layer, alike;
};
static_assert(sizeof(HitsBlock) == 224);

LaunchBlock launchBlock(const DistanceField& field, const ParticleLaunch& launch) {
  const Box& box = launch.box;
  const Vec3d& centre = field.shape.centre;
  LaunchBlock block{};
  std::copy_n(std::array{box.low.x, box.low.y, box.low.z}.begin(), 3, block.low);
  std::copy_n(std::array{box.high.x, box.high.y, box.high.z}.begin(), 3, block.high);
  std::copy_n(std::array{centre.x, centre.y, centre.z, 1 / field.shape.voxel}.begin(), 4, block.centre);
  block.farthest = launch.farthest;
  block.rings = launch.shot->beams->rings;
  block.columns = launch.shot->beams->columns;
  block.withOrigins = launch.shot->beams->origin.empty() ? 0 : 1;
  block.shotParticles = static_cast<std::uint32_t>(launch.size());
  block.shotPoses = static_cast<std::uint32_t>(launch.shot->worldFromSensor.size());
  return block;
}

HitsBlock hitsBlock(const DistanceField& field, const World& world, const LaunchBlock& launched,
                    const ParticleLaunch& launch, Channels channels, std::size_t rays) {
  const BeamTable& beams = *launch.shot->beams;
  HitsBlock block{};
  block.common = DeviceResolver::block(beams, channels, rays);
  block.rings = launched.rings;
  block.columns = launched.columns;
  block.first = launched.first;
  block.count = launched.count;
  block.withOrigins = launched.withOrigins;
  block.shotParticles = launched.shotParticles;
  block.shotRays = static_cast<std::uint32_t>(beams.size());
  block.shotPoses = launched.shotPoses;
  block.firstAlpha = world.baked.firstAlpha;
  block.whole = launch.whole ? 1 : 0;
  block.lastLevel = static_cast<std::int32_t>(field.levels.size()) - 1;
  block.reach = field.shape.reach;
  block.metres = static_cast<float>(field.shape.voxel);
  block.voxel = field.shape.voxel;
  block.ends = launch.farthest;
  std::copy_n(launched.low, 4, block.low);
  std::copy_n(launched.high, 4, block.high);
  std::copy_n(launched.centre, 4, block.centre);
  block.trust = kTrust;
  block.aside = kAside;
  block.layer = kLayer;
  block.alike = kAlike;
  return block;
}

// The work on the particles of one shot, from launch to hits.
struct Flight {
  const std::shared_ptr<const DistanceField>& field;
  const std::shared_ptr<const World>& world;
  std::uint32_t steps;
  const ParticleLaunch* launch;
  Channels channels;
  mutable double upload = 0;  // s, time to upload field and scene; set for a dispatch's first shot

  std::size_t rays() const { return launch->shot->beams->size(); }
  std::uint64_t bytes() const { return DeviceResolver::bytesPerRay(channels) * rays(); }
  bool goesWith(const Flight& o) const {
    const ParticleLaunch& a = *launch;
    const ParticleLaunch& b = *o.launch;
    return field == o.field && world == o.world && steps == o.steps && channels == o.channels &&
           a.shot->beams == b.shot->beams && a.shot->worldFromSensor.size() == b.shot->worldFromSensor.size() &&
           a.box.low == b.box.low && a.box.high == b.box.high && a.farthest == b.farthest && a.whole == b.whole;
  }
};

class ComputeMarcher : public GlMarcher {
 public:
  explicit ComputeMarcher(const GlMarcherLimits& limits)
      : device_(kWords),
        mostTableBytes_(limits.tableBytes),
        slice_(std::min<std::uint64_t>(device_.mostBufferBytes() / (DeviceMarch::kMostColumns * sizeof(float)),
                                       limits.particles)) {}

  void march(std::shared_ptr<const DistanceField> field, std::shared_ptr<const World> world, std::uint32_t steps,
             const ParticleLaunch& launch, Hits& hits, std::vector<UndecidedRay>& undecided,
             StageClock& clock) override {
    const Flight flight{field, world, steps, &launch, hits.channels};
    const WallTimer timer;
    const Queue::Given given = queue_.give(flight);
    const std::span<const std::byte> columns = given.batch->hits->wait();
    clock.add("upload", flight.upload);
    clock.add("march", timer.seconds() - flight.upload);
    const StageTimer copying(clock, "read_back", StageTimer::Kind::Wall);
    DeviceResolver::take(columns, {given.batch->rays, given.from, flight.rays()}, 0, hits, undecided);
  }

  std::string device() const override { return device_.nameAndPlace(); }

 private:
  // Largest number of holes that a particle passes on the device; a particle that passes more is left to the processor.
  static constexpr std::uint32_t kMostHoles = 6;

  using Queue = ShotQueue<Flight>;

  void run(const std::vector<const Flight*>& together, Queue::Batch& batch) {
    const Flight& flight = *together.front();
    const WallTimer timer;
    march_.hold(flight.field, flight.world);
    holdLabels(flight.world);
    flight.upload = timer.seconds();
    if (std::max(flight.bytes(), DeviceBeams::kBytesPerRay * flight.rays()) > mostBytes()) {
      device_.fail("the sensor has too many beams for a buffer of the graphics card");
    }
    DeviceBeams::Shots shots;
    for (const Flight* one : together) {
      shots.shots.push_back(one->launch->shot);
      shots.frames.push_back(one->launch->frame);
    }
    device_.atOnce([&] {
      beams_.hold(shots);
      resolver_.reserve(flight.channels, batch.rays);
      const std::size_t particles = flight.launch->size() * together.size();
      for (std::size_t first = 0; first < particles; first += slice_) {
        fly(flight, batch.rays, first, std::min<std::size_t>(slice_, particles - first));
      }
      batch.hits->start(resolver_.columns(), DeviceResolver::bytesPerRay(flight.channels) * batch.rays);
    });
  }

  std::uint64_t mostBytes() const { return std::min(mostTableBytes_, device_.mostBufferBytes()); }

  // Launches `count` particles, marches them and computes their hits. The particles of all shots are numbered in
  // sequence, and `first` is the number of the first launched particle. `rays`: number of rays of all shots of the
  // dispatch.
  void fly(const Flight& flight, std::size_t rays, std::size_t first, std::size_t count) {
    const DistanceField& field = *flight.field;
    const World& world = *flight.world;
    const bool lists = field.shape.lists;
    march_.reserve(lists, count);
    LaunchBlock block = launchBlock(field, *flight.launch);
    block.first = static_cast<std::uint32_t>(first);
    block.count = static_cast<std::uint32_t>(count);
    launchers_.of(lists).run(
        count, {&beams_.directions(), &beams_.origins(), &beams_.poses(), &beams_.steps(), &march_.particles()},
        std::as_bytes(std::span(&block, 1)));
    HitsBlock hits = hitsBlock(field, world, block, *flight.launch, flight.channels, rays);
    const bool holes = lists && world.baked.firstAlpha < world.baked.triangles.size();
    for (std::uint32_t hole = 0; hole <= (holes ? kMostHoles : 0); ++hole) {
      march_.run(field, flight.steps, count, hole > 0);
      hits.last = hole == kMostHoles || !holes ? 1 : 0;
      resolvers_.of(lists).run(count,
                               {&beams_.directions(), &beams_.origins(), &beams_.poses(), &beams_.steps(),
                                &march_.records(), &resolver_.columns(), &march_.particles()},
                               std::as_bytes(std::span(&hits, 1)),
                               {resolver_.table(0), resolver_.table(1), resolver_.table(2), resolver_.table(3),
                                march_.fields().levels(), march_.fields().table(), march_.fields().words()});
    }
  }

  void holdLabels(const std::shared_ptr<const World>& world) {
    if (labelled_.lock() == world) return;
    labelled_.reset();
    resolver_.holdMeshes(*world);
    labelled_ = world;
  }

  ComputeDevice device_;
  const std::uint64_t mostTableBytes_;
  const std::uint64_t slice_;
  MarchPrograms launchers_{device_, "launch", launchShader};
  MarchPrograms resolvers_{device_, "particles' hits", particleHitsShader};
  DeviceBeams beams_{device_};
  DeviceMarch march_{device_, mostTableBytes_};
  DeviceResolver resolver_{device_, mostTableBytes_};
  std::weak_ptr<const World> labelled_;  // the world whose planes and labels are uploaded
  Queue queue_{device_, mostBytes(),
               [this](const std::vector<const Flight*>& together, Queue::Batch& batch) { run(together, batch); }};
};

}  // namespace

std::unique_ptr<GlMarcher> makeGlMarcher(const GlMarcherLimits& limits) {
  return std::make_unique<ComputeMarcher>(limits);
}

}  // namespace scanmill
