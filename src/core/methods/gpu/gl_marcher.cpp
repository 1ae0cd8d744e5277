// Launches particles, marches them and computes their hits, all on a device, in slices of limited size.

#include "methods/gpu/gl_marcher.h"

#include <algorithm>
#include <span>

#include "methods/field/march_rule.h"

namespace scanmill {

namespace {

// Largest number of holes that a particle passes on the device; a particle that passes more is left to the CPU.
constexpr std::uint32_t kMostHoles = 6;

// The parameters of launchShader() and resolveShader(), in std140 layout: see shaders/particles.glsl.
struct ParticleParameters {
  ResolverParameters common;
  std::uint32_t rings, columns, first, count, withOrigins, shotParticles, shotRays, shotPoses;
  std::uint32_t firstAlpha, coversScene, last;
  std::int32_t lastLevel;
  float reach, metres;
  double voxel, pathLength;
  double low[4], high[4], centre[4];
  double rangeErrorBound, layerLookupOffset, layerThickness, layerMinCosine;
};
static_assert(sizeof(ParticleParameters) == 224);

// Returns the parameters of a slice of particles: [first, first + count). `rays`: number of rays of the dispatch.
ParticleParameters particleParameters(const MarchJob& job, Channels channels, std::size_t rays, std::size_t first,
                                      std::size_t count) {
  const BeamTable& beams = *job.shot.beams;
  const FieldShape& shape = job.field().shape;
  const Box& box = job.sensorField.box;
  return {.common = DeviceResolver::parameters(beams, channels, rays),
          .rings = beams.rings,
          .columns = beams.columns,
          .first = static_cast<std::uint32_t>(first),
          .count = static_cast<std::uint32_t>(count),
          .withOrigins = beams.origin.empty() ? 0u : 1u,
          .shotParticles = static_cast<std::uint32_t>(job.size()),
          .shotRays = static_cast<std::uint32_t>(beams.size()),
          .shotPoses = static_cast<std::uint32_t>(job.shot.worldFromSensor.size()),
          .firstAlpha = job.triangles().firstAlpha,
          .coversScene = job.sensorField.coversScene ? 1u : 0u,
          .last = 0,
          .lastLevel = static_cast<std::int32_t>(job.field().levels.size()) - 1,
          .reach = shape.reach,
          .metres = static_cast<float>(shape.voxel),
          .voxel = shape.voxel,
          .pathLength = job.pathLength(),
          .low = {box.low.x, box.low.y, box.low.z},
          .high = {box.high.x, box.high.y, box.high.z},
          .centre = {shape.centre.x, shape.centre.y, shape.centre.z, 1 / shape.voxel},
          .rangeErrorBound = kRangeErrorBound,
          .layerLookupOffset = kLayerLookupOffset,
          .layerThickness = kLayerThickness,
          .layerMinCosine = kLayerMinCosine};
}

}  // namespace

bool GlMarcher::ShotWork::canShareDispatch(const ShotWork& other) const {
  const MarchJob& a = job;
  const MarchJob& b = other.job;
  return a.sensorField.field == b.sensorField.field && a.sensorField.world == b.sensorField.world &&
         a.maxSteps == b.maxSteps && channels == other.channels && a.shot.beams == b.shot.beams &&
         a.shot.worldFromSensor.size() == b.shot.worldFromSensor.size();
}

GlMarcher::GlMarcher(const GlMarcherLimits& limits)
    : device_({"particles cannot march by OpenGL", "`backend: cpu` does not need it"}, limits.device),
      particlesAtOnce_(std::min<std::uint64_t>(
          device_.limits().bufferBytes / (DeviceMarch::kMostColumns * sizeof(float)), limits.particles)) {}

void GlMarcher::march(const MarchJob& job, Hits& hits, std::vector<UnresolvedRay>& unresolved, StageClock& clock) {
  const ShotWork work{job, hits.channels};
  const WallTimer timer;
  const Queue::Submitted submitted = queue_.submit(work);
  const std::span<const std::byte> columns = submitted.batch->hits.wait();
  clock.add("upload", work.upload);
  clock.add("march", timer.seconds() - work.upload);
  const StageTimer copying(clock, "read_back", StageTimer::Kind::Wall);
  DeviceResolver::copyHits(columns, {submitted.batch->rays, submitted.firstRay, work.rays()}, hits, unresolved);
}

// Submits the works of a batch, and starts the copy of their hits: see ShotQueue::Dispatch. All works have equal beams,
// fields and channels, which are read from the first work. ShotQueue keeps the total size within the device's limit,
// which only a single work can exceed.
void GlMarcher::dispatch(const std::vector<const ShotWork*>& together, Queue::Batch& batch) {
  const ShotWork& work = *together.front();
  const WallTimer timer;
  const std::shared_ptr<const World>& world = work.job.sensorField.world;
  march_.ensureUploaded(work.job.sensorField.field, world);
  if (worldWithLabels_.lock() != world) {
    worldWithLabels_.reset();
    resolver_.uploadMeshes(*world);
    worldWithLabels_ = world;
  }
  work.upload = timer.seconds();
  if (std::max(work.bytes(), DeviceBeams::kBytesPerRay * work.rays()) > device_.limits().bufferBytes) {
    device_.fail("the sensor has too many beams for a buffer of the graphics card");
  }
  DeviceBeams::Shots shots;
  for (const ShotWork* shotWork : together) {
    shots.shots.push_back(&shotWork->job.shot);
    shots.frames.push_back(&shotWork->job.frame);
  }
  device_.atOnce([&] {
    beams_.ensureUploaded(shots);
    resolver_.reserve(work.channels, batch.rays);
    // There are more particles than rays, since columns are padded to groups.
    const std::size_t particles = work.job.size() * together.size();
    for (std::size_t first = 0; first < particles; first += particlesAtOnce_) {
      marchSlice(work, batch.rays, first, std::min<std::size_t>(particlesAtOnce_, particles - first));
    }
    batch.hits.start(resolver_.columns(), DeviceResolver::bytesPerRay(work.channels) * batch.rays);
  });
}

// Launches `count` particles, marches them and computes their hits. `first`: index of the first of these particles
// among the particles of all shots of the dispatch. `rays`: number of rays of all these shots.
void GlMarcher::marchSlice(const ShotWork& work, std::size_t rays, std::size_t first, std::size_t count) {
  const DistanceField& field = work.job.field();
  const TriangleBlock& triangles = work.job.triangles();
  const bool lists = field.shape.lists;
  const std::uint32_t mostHoles = lists && triangles.firstAlpha < triangles.triangles.size() ? kMostHoles : 0;
  ParticleParameters parameters = particleParameters(work.job, work.channels, rays, first, count);
  const auto parameterBytes = std::as_bytes(std::span(&parameters, 1));
  march_.reserve(lists, count);
  launchers_.of(lists).run(
      count, {&beams_.directions(), &beams_.origins(), &beams_.poses(), &beams_.steps(), &march_.particles()},
      parameterBytes);
  for (std::uint32_t hole = 0; hole <= mostHoles; ++hole) {
    march_.run(field, work.job.maxSteps, count,
               hole > 0 ? DeviceMarch::Marching::BehindHoles : DeviceMarch::Marching::All);
    parameters.last = hole == mostHoles ? 1 : 0;  // run() reads the value through parameterBytes
    resolvers_.of(lists).run(count,
                             {&beams_.directions(), &beams_.origins(), &beams_.poses(), &beams_.steps(),
                              &march_.records(), &resolver_.columns(), &march_.particles()},
                             parameterBytes,
                             {resolver_.table(0), resolver_.table(1), resolver_.table(2), resolver_.table(3),
                              march_.fields().levels(), march_.fields().table(), march_.fields().trianglesOrLists()});
  }
}

}  // namespace scanmill
