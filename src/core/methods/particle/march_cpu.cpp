// Marches particles in the SIMD lanes of the CPU. The code between HWY_BEFORE_NAMESPACE() and HWY_AFTER_NAMESPACE() is
// compiled for each instruction set that Highway knows for this kind of CPU; the machine's best instruction set is
// used.

#ifdef __AVX2__  // a build for this machine's CPU compiles only the CPU's instruction set
#define HWY_COMPILE_ONLY_STATIC
#endif
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "methods/particle/march_cpu.cpp"
#include <hwy/foreach_target.h>

#if HWY_TARGET == HWY_SCALAR
#error "Highway knows no lanes of this processor: for x86 without SSSE3 it takes g++ 12.3 or later"
#endif

#include "methods/particle/march_stream.h"
#include "methods/particle/particles.h"

HWY_BEFORE_NAMESPACE();
namespace scanmill::HWY_NAMESPACE {

void marchInLanes(const DistanceField& field, const TriangleBlock& triangles, std::uint32_t maxSteps,
                  const Particles& particles, std::span<const std::uint32_t> indices, HitRecords& records) {
  if (field.shape.lists) {
    ParticleStream<true>(field, triangles, maxSteps, particles, indices, records).run();
  } else {
    ParticleStream<false>(field, triangles, maxSteps, particles, indices, records).run();
  }
}

}  // namespace scanmill::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace scanmill {

namespace {

HWY_EXPORT(marchInLanes);

}  // namespace

void marchCpu(const DistanceField& field, const TriangleBlock& triangles, std::uint32_t maxSteps,
              const Particles& particles, std::span<const std::uint32_t> indices, HitRecords& records) {
  HWY_DYNAMIC_DISPATCH(marchInLanes)(field, triangles, maxSteps, particles, indices, records);
  if (field.shape.lists) return;
  // Replaces the corners in the records by the triangles of these corners, for all particles together, because the
  // entries of field.triangleOrList are scattered in memory.
  for (const std::uint32_t i : indices) {
    if (records.outcomeOf(i) == Outcome::Hit) records.triangle[i] = field.triangleOrList[records.triangle[i]];
  }
}

}  // namespace scanmill

#endif
