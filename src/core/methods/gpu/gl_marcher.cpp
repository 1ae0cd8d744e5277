// Launches particles, marches them and computes their hits, all on a device, in slices of limited size.

#include "methods/gpu/gl_marcher.h"

#include <algorithm>
#include <array>
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

ParticleParameters particleParameters(const MarchJob& job, Channels channels, std::size_t rays) {
  const BeamTable& beams = *job.shot.beams;
  const FieldShape& shape = job.field().shape;
  const Box& box = job.around.box;
  ParticleParameters block{};
  block.common = DeviceResolver::block(beams, channels, rays);
  block.rings = beams.rings;
  block.columns = beams.columns;
  block.withOrigins = beams.origin.empty() ? 0 : 1;
  block.shotParticles = static_cast<std::uint32_t>(job.size());
  block.shotRays = static_cast<std::uint32_t>(beams.size());
  block.shotPoses = static_cast<std::uint32_t>(job.shot.worldFromSensor.size());
  block.firstAlpha = job.triangles().firstAlpha;
  block.coversScene = job.around.coversScene ? 1 : 0;
  block.lastLevel = static_cast<std::int32_t>(job.field().levels.size()) - 1;
  block.reach = shape.reach;
  block.metres = static_cast<float>(shape.voxel);
  block.voxel = shape.voxel;
  block.pathLength = job.pathLength();
  std::copy_n(std::array{box.low.x, box.low.y, box.low.z}.begin(), 3, block.low);
  std::copy_n(std::array{box.high.x, box.high.y, box.high.z}.begin(), 3, block.high);
  std::copy_n(std::array{shape.centre.x, shape.centre.y, shape.centre.z, 1 / shape.voxel}.begin(), 4, block.centre);
  block.rangeErrorBound = kRangeErrorBound;
  block.layerLookupOffset = kLayerLookupOffset;
  block.layerThickness = kLayerThickness;
  block.layerMinCosine = kLayerMinCosine;
  return block;
}

}  // namespace

bool GlMarcher::ShotWork::canShareDispatch(const ShotWork& other) const {
  const MarchJob& a = job;
  const MarchJob& b = other.job;
  return a.around.field == b.around.field && a.around.world == b.around.world && a.maxSteps == b.maxSteps &&
         channels == other.channels && a.shot.beams == b.shot.beams &&
         a.shot.worldFromSensor.size() == b.shot.worldFromSensor.size();
}

GlMarcher::GlMarcher(const GlMarcherLimits& limits)
    : device_({"particles cannot march by OpenGL", "`backend: cpu` does not need it"}, limits.device),
      slice_(std::min<std::uint64_t>(device_.limits().bufferBytes / (DeviceMarch::kMostColumns * sizeof(float)),
                                     limits.particles)) {}

void GlMarcher::march(const MarchJob& job, Hits& hits, std::vector<UnresolvedRay>& undecided, StageClock& clock) {
  const ShotWork flight{job, hits.channels};
  const WallTimer timer;
  const Queue::Given given = queue_.give(flight);
  const std::span<const std::byte> columns = given.batch->hits.wait();
  clock.add("upload", flight.upload);
  clock.add("march", timer.seconds() - flight.upload);
  const StageTimer copying(clock, "read_back", StageTimer::Kind::Wall);
  DeviceResolver::take(columns, {given.batch->rays, given.from, flight.rays()}, hits, undecided);
}

void GlMarcher::run(const std::vector<const ShotWork*>& together, Queue::Batch& batch) {
  const ShotWork& flight = *together.front();
  const WallTimer timer;
  march_.hold(flight.job.around.field, flight.job.around.world);
  holdLabels(flight.job.around.world);
  flight.upload = timer.seconds();
  if (std::max(flight.bytes(), DeviceBeams::kBytesPerRay * flight.rays()) > device_.limits().bufferBytes) {
    device_.fail("the sensor has too many beams for a buffer of the graphics card");
  }
  DeviceBeams::Shots shots;
  for (const ShotWork* one : together) {
    shots.shots.push_back(&one->job.shot);
    shots.frames.push_back(&one->job.frame);
  }
  device_.atOnce([&] {
    beams_.hold(shots);
    resolver_.reserve(flight.channels, batch.rays);
    const std::size_t particles = flight.job.size() * together.size();
    for (std::size_t first = 0; first < particles; first += slice_) {
      fly(flight, batch.rays, first, std::min<std::size_t>(slice_, particles - first));
    }
    batch.hits.start(resolver_.columns(), DeviceResolver::bytesPerRay(flight.channels) * batch.rays);
  });
}

// Launches `count` particles, marches them and computes their hits. The particles of all shots are numbered in
// sequence, and `first` is the number of the first launched particle. `rays`: number of rays of all shots of the
// dispatch.
void GlMarcher::fly(const ShotWork& flight, std::size_t rays, std::size_t first, std::size_t count) {
  const DistanceField& field = flight.job.field();
  const TriangleBlock& triangles = flight.job.triangles();
  const bool lists = field.shape.lists;
  const bool holes = lists && triangles.firstAlpha < triangles.triangles.size();
  ParticleParameters block = particleParameters(flight.job, flight.channels, rays);
  block.first = static_cast<std::uint32_t>(first);
  block.count = static_cast<std::uint32_t>(count);
  const auto parameters = std::as_bytes(std::span(&block, 1));
  march_.reserve(lists, count);
  launchers_.of(lists).run(
      count, {&beams_.directions(), &beams_.origins(), &beams_.poses(), &beams_.steps(), &march_.particles()},
      parameters);
  for (std::uint32_t hole = 0; hole <= (holes ? kMostHoles : 0); ++hole) {
    march_.run(field, flight.job.maxSteps, count, hole > 0);
    block.last = hole == kMostHoles || !holes ? 1 : 0;
    resolvers_.of(lists).run(count,
                             {&beams_.directions(), &beams_.origins(), &beams_.poses(), &beams_.steps(),
                              &march_.records(), &resolver_.columns(), &march_.particles()},
                             parameters,
                             {resolver_.table(0), resolver_.table(1), resolver_.table(2), resolver_.table(3),
                              march_.fields().levels(), march_.fields().table(), march_.fields().words()});
  }
}

void GlMarcher::holdLabels(const std::shared_ptr<const World>& world) {
  if (labelled_.lock() == world) return;
  labelled_.reset();
  resolver_.holdMeshes(*world);
  labelled_ = world;
}

}  // namespace scanmill
