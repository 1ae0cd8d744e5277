// Marches particles by a compute shader. Fields and triangles stay on the device between calls; particles go there and
// hit records come back, a slice at a time.

#include "methods/march/march_gl.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "gpu/compute.h"
#include "gpu/device.h"
#include "methods/device/device_beams.h"
#include "methods/device/device_resolver.h"
#include "methods/device/shot_queue.h"
#include "methods/march/device_fields.h"
#include "methods/march/march_rule.h"

namespace scanmill {

namespace {

const ComputeErrorWords kWords{"particles cannot fly by OpenGL", "'backend: cpu' does without it"};

// As the shader declares it, by the rules of std140.
struct MarchBlock {
  std::int32_t lastLevel;
  float perReach;
  float metres;
  std::uint32_t steps;
  std::uint32_t count;
  std::uint32_t again;
  std::uint32_t unused[2];
};
static_assert(sizeof(MarchBlock) == 32);

// Likewise.
struct LaunchBlock {
  double low[4], high[4], centre[4];
  double farthest;
  std::uint32_t rings, columns, first, count, withOrigins, shotParticles, shotPoses;
  std::uint32_t unused[3];
};
static_assert(sizeof(LaunchBlock) == 144);

// Likewise.
struct HitsBlock {
  ResolverBlock common;
  std::uint32_t rings, columns, first, count, withOrigins, shotParticles, shotRays, shotPoses;
  std::uint32_t firstAlpha, corrected, whole, last;
  std::int32_t lastLevel;
  float reach, metres;
  std::uint32_t unused;
  double voxel, ends, unusedToo[3];
  double low[4], high[4], centre[4];
  double trust, aside, layer, alike, trusted, there;
  double unusedNeither[2];
};
static_assert(sizeof(HitsBlock) == 288);

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
  block.corrected = launch.corrected ? 1 : 0;
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
  block.trusted = double{kTrusted};
  block.there = double{kThere};
  return block;
}

MarchBlock marchBlock(const DistanceField& field, std::uint32_t steps, std::size_t count) {
  MarchBlock block{};
  block.lastLevel = static_cast<std::int32_t>(field.levels.size()) - 1;
  block.perReach = 1.0f / field.shape.reach;
  block.metres = static_cast<float>(field.shape.voxel);
  block.steps = steps;
  block.count = static_cast<std::uint32_t>(count);
  return block;
}

using Columns = std::vector<const std::vector<float>*>;

Columns columnsOf(const Particles& p, bool lists) {
  if (!lists) return {&p.ox, &p.oy, &p.oz, &p.dx, &p.dy, &p.dz, &p.begin, &p.end};
  return {&p.ox, &p.oy, &p.oz, &p.dx, &p.dy, &p.dz, &p.begin, &p.end, &p.wx, &p.wy, &p.wz, &p.ix, &p.iy, &p.iz};
}

// A corner and the two edges from it.
using DeviceTriangle = std::array<std::array<float, 4>, 3>;

std::vector<DeviceTriangle> deviceTriangles(const TriangleBlock& block) {
  std::vector<DeviceTriangle> made(block.corners.size());
  parallelFor(made.size(), 16384, [&](std::size_t first, std::size_t last) {
    for (std::size_t t = first; t < last; ++t) {
      const Triangle& corners = block.corners[t];
      const Vec3f a = block.vertices[corners[0]];
      const Vec3f ab = block.vertices[corners[1]] - a;
      const Vec3f ac = block.vertices[corners[2]] - a;
      made[t] = {{{a.x, a.y, a.z, 0}, {ab.x, ab.y, ab.z, 0}, {ac.x, ac.y, ac.z, 0}}};
    }
  });
  return made;
}

// A shot's particles, of launch to hits.
struct Flight {
  const std::shared_ptr<const DistanceField>& field;
  const std::shared_ptr<const World>& world;
  std::uint32_t steps;
  const ParticleLaunch* launch;
  Channels channels;
  mutable double upload = 0;  // s, where this thread gave it to the device

  std::size_t rays() const { return launch->shot->beams->size(); }
  std::uint64_t bytes() const { return DeviceResolver::bytesPerRay(channels) * rays(); }
  bool goesWith(const Flight& o) const {
    const ParticleLaunch& a = *launch;
    const ParticleLaunch& b = *o.launch;
    return field == o.field && world == o.world && steps == o.steps && channels == o.channels &&
           a.shot->beams == b.shot->beams && a.shot->worldFromSensor.size() == b.shot->worldFromSensor.size() &&
           a.box.low == b.box.low && a.box.high == b.box.high && a.farthest == b.farthest && a.whole == b.whole &&
           a.corrected == b.corrected;
  }
};

class ComputeMarcher : public GlMarcher {
 public:
  explicit ComputeMarcher(const GlMarcherLimits& limits)
      : device_(kWords),
        mostTableBytes_(limits.tableBytes),
        slice_(std::min<std::uint64_t>(device_.mostBufferBytes() / (kMostColumns * sizeof(float)), limits.particles)) {
    triangles_.reserve(16);  // buffers without storage cannot be read from
  }

  void march(std::shared_ptr<const DistanceField> field, std::shared_ptr<const World> world, std::uint32_t steps,
             const Particles& particles, HitRecords& records, StageClock& clock) override {
    const std::scoped_lock lock(mutex_);
    {
      const StageTimer timer(clock, "upload");
      upload(field, world);
    }
    const Columns columns = columnsOf(particles, field->shape.lists);
    marchAll(*field, steps, particles.size(), records, clock, [&](std::size_t first, std::size_t count) {
      std::vector<ComputeBuffer::Source> pieces;
      for (std::size_t k = 0; k < columns.size(); ++k) {
        pieces.push_back({k * count * sizeof(float), std::as_bytes(std::span(*columns[k]).subspan(first, count))});
      }
      particles_.write(pieces);
    });
  }

  void march(std::shared_ptr<const DistanceField> field, std::shared_ptr<const World> world, std::uint32_t steps,
             const ParticleLaunch& launch, Hits& hits, std::vector<UndecidedRay>& undecided,
             StageClock& clock) override {
    const Flight flight{field, world, steps, &launch, hits.channels};
    const WallTimer timer;
    const Queue::Given given = queue_.give(flight);
    const std::span<const std::byte> columns = given.batch->hits->wait();
    clock.add("upload", flight.upload);
    clock.add("march", timer.seconds() - flight.upload);
    const StageTimer copying(clock, "read_back");
    DeviceResolver::take(columns, {given.batch->rays, given.from, flight.rays()}, 0, hits, undecided);
  }

  std::string device() const override { return device_.name(); }

 private:
  static constexpr std::uint64_t kMostColumns = 14;  // of particles, for fields with lists
  static constexpr std::uint64_t kFewestColumns = 8;
  // In a row, that a particle passes on the device; what passes more is left to the processor.
  static constexpr std::uint32_t kMostHoles = 6;

  using Queue = ShotQueue<Flight>;
  using Programs = std::array<std::unique_ptr<ComputeProgram>, 2>;  // without lists and with, made when first needed

  ComputeProgram& programOf(Programs& programs, const char* name, std::string (*shader)(bool), bool lists) {
    std::unique_ptr<ComputeProgram>& program = programs[lists ? 1 : 0];
    if (program == nullptr) program = std::make_unique<ComputeProgram>(device_, name, shader(lists));
    return *program;
  }

  void run(const std::vector<const Flight*>& together, Queue::Batch& batch) {
    const Flight& flight = *together.front();
    const std::scoped_lock lock(mutex_);
    const WallTimer timer;
    upload(flight.field, flight.world);
    holdLabels(flight.world);
    flight.upload = timer.seconds();
    if (std::max(flight.bytes(), DeviceBeams::kBytesPerRay * flight.rays()) > mostBytes()) {
      device_.fail("the sensor's beams do not fit into a buffer");
    }
    DeviceBeams::Shots shots;
    for (const Flight* one : together) {
      shots.shots.push_back(one->launch->shot);
      shots.frames.push_back(one->launch->frame);
    }
    device_.atOnce([&] {
      beams_.hold(shots, 0, flight.rays(), 0);
      resolver_.reserve(flight.channels, batch.rays);
      const std::size_t particles = flight.launch->size() * together.size();
      for (std::size_t first = 0; first < particles; first += slice_) {
        fly(flight, batch.rays, first, std::min<std::size_t>(slice_, particles - first));
      }
      batch.hits->start(resolver_.columns(), DeviceResolver::bytesPerRay(flight.channels) * batch.rays);
    });
  }

  std::uint64_t mostBytes() const { return std::min(mostTableBytes_, device_.mostBufferBytes()); }

  // Launches `count` particles from `first` on, counted shot after shot, marches them and makes their hits, which are
  // of `rays` in all.
  void fly(const Flight& flight, std::size_t rays, std::size_t first, std::size_t count) {
    const DistanceField& field = *flight.field;
    const World& world = *flight.world;
    const bool lists = field.shape.lists;
    reserve(lists, count);
    LaunchBlock block = launchBlock(field, *flight.launch);
    block.first = static_cast<std::uint32_t>(first);
    block.count = static_cast<std::uint32_t>(count);
    programOf(launchers_, "launch", launchShader, lists)
        .run(count,
             {&beams_.directions(), &beams_.origins(), &beams_.parts(), &beams_.poses(), &beams_.steps(), &particles_},
             std::as_bytes(std::span(&block, 1)));
    HitsBlock hits = hitsBlock(field, world, block, *flight.launch, flight.channels, rays);
    const bool holes = lists && world.baked.firstAlpha < world.baked.triangles.size();
    for (std::uint32_t hole = 0; hole <= (holes ? kMostHoles : 0); ++hole) {
      runMarch(field, flight.steps, count, hole > 0);
      hits.last = hole == kMostHoles || !holes ? 1 : 0;
      programOf(resolvers_, "particles' hits", particleHitsShader, lists)
          .run(count,
               {&beams_.directions(), &beams_.origins(), &beams_.parts(), &beams_.poses(), &beams_.steps(), &records_,
                &resolver_.columns(), &particles_},
               std::as_bytes(std::span(&hits, 1)),
               {resolver_.table(0), resolver_.table(1), resolver_.table(2), resolver_.table(3), resolver_.table(4),
                fields_.levels(), fields_.table(), fields_.distances(), fields_.words()});
    }
  }

  void reserve(bool lists, std::size_t count) {
    particles_.reserve((lists ? kMostColumns : kFewestColumns) * count * sizeof(float));
    records_.reserve(5 * count * sizeof(float));
  }

  // `fill` brings particles into their buffer.
  template <class Fill>
  void marchAll(const DistanceField& field, std::uint32_t steps, std::size_t size, HitRecords& records,
                StageClock& clock, const Fill& fill) {
    records.reset(size);
    for (std::size_t first = 0; first < size; first += slice_) {
      const std::size_t count = std::min<std::size_t>(slice_, size - first);
      {
        const StageTimer timer(clock, "march");
        reserve(field.shape.lists, count);
        fill(first, count);
        runMarch(field, steps, count, false);
        device_.finish();
      }
      const StageTimer timer(clock, "read_back");
      readRecords(field, records, first, count);
    }
  }

  void upload(const std::shared_ptr<const DistanceField>& field, const std::shared_ptr<const World>& world) {
    fields_.hold(field);
    if (field->shape.lists && world_.lock() != world) {
      world_.reset();
      const std::vector<DeviceTriangle> triangles = deviceTriangles(world->baked);
      holdTable(device_, triangles_, ComputeTable::Texel::Float32x4, std::as_bytes(std::span(triangles)),
                mostTableBytes_, "scene's triangles", ": take 'refine: normal', which does not look at them");
      world_ = world;
    }
  }

  void holdLabels(const std::shared_ptr<const World>& world) {
    if (labelled_.lock() == world) return;
    labelled_.reset();
    resolver_.holdMeshes(*world);
    resolver_.holdPlaces(standsOf(*world));
    labelled_ = world;
  }

  // `again`: those alone that go on behind a hole.
  void runMarch(const DistanceField& field, std::uint32_t steps, std::size_t count, bool again) {
    MarchBlock block = marchBlock(field, steps, count);
    block.again = again ? 1 : 0;
    programOf(marchers_, "particle", marchShader, field.shape.lists)
        .run(count, {&particles_, &records_}, std::as_bytes(std::span(&block, 1)),
             {fields_.levels(),
              fields_.table(),
              fields_.distances(),
              fields_.words(),
              fields_.lists(),
              {&triangles_, ComputeTable::Texel::Float32x4}});
  }

  void readRecords(const DistanceField& field, HitRecords& records, std::size_t first, std::size_t count) {
    const std::size_t bytes = count * sizeof(float);
    const auto part = [&](auto& column) { return std::as_writable_bytes(std::span(column).subspan(first, count)); };
    std::vector<ComputeBuffer::Target> pieces{
        {0, part(records.way)}, {bytes, part(records.triangle)}, {2 * bytes, part(records.outcome)}};
    if (field.shape.lists) {
      numerator_.resize(count);
      denominator_.resize(count);
      pieces.push_back({3 * bytes, std::as_writable_bytes(std::span(numerator_))});
      pieces.push_back({4 * bytes, std::as_writable_bytes(std::span(denominator_))});
    }
    records_.read(pieces);
    if (!field.shape.lists) return;
    const auto metres = static_cast<float>(field.shape.voxel);
    parallelFor(count, 65536, [&](std::size_t from, std::size_t to) {
      for (std::size_t i = from; i < to; ++i) {
        if (records.outcomeOf(first + i) != Outcome::Hit) continue;
        records.way[first + i] += numerator_[i] / (denominator_[i] * metres);
      }
    });
  }

  std::mutex mutex_;
  ComputeDevice device_;
  const std::uint64_t mostTableBytes_;
  const std::uint64_t slice_;
  Programs launchers_, marchers_, resolvers_;
  DeviceBeams beams_{device_};
  ComputeBuffer particles_{device_};
  DeviceFields fields_{device_, mostTableBytes_};
  ComputeBuffer triangles_{device_};
  ComputeBuffer records_{device_};
  DeviceResolver resolver_{device_, mostTableBytes_};
  std::weak_ptr<const World> world_;     // whose triangles
  std::weak_ptr<const World> labelled_;  // whose planes and labels
  std::vector<float> numerator_;         // of the slice
  std::vector<float> denominator_;
  Queue queue_{device_, mostBytes(),
               [this](const std::vector<const Flight*>& together, Queue::Batch& batch) { run(together, batch); }};
};

}  // namespace

std::unique_ptr<GlMarcher> makeGlMarcher(const GlMarcherLimits& limits) {
  return std::make_unique<ComputeMarcher>(limits);
}

std::unique_ptr<GlMarcher> makeGlMarcher() {
  return makeGlMarcher(GlMarcherLimits{});
}

std::unique_ptr<GlMarcher> findGlMarcher() {
  try {
    return mayHaveCard() ? makeGlMarcher() : nullptr;
  } catch (const Error& error) {
    if (!namedDevice().empty()) warn(fmt::format("particles fly on the processor: {}", error.what()));
    return nullptr;
  }
}

}  // namespace scanmill
