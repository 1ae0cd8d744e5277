// Particles in the lanes of the processor. What is between HWY_BEFORE_NAMESPACE() and HWY_AFTER_NAMESPACE() is compiled
// for each instruction set that Highway knows of this kind of processor, and the best that the machine has is taken.

#ifdef __AVX2__  // a build for the own processor: its instructions alone
#define HWY_COMPILE_ONLY_STATIC
#endif
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "methods/march/march_cpu.cpp"
#include <hwy/foreach_target.h>

#include "methods/march/march_lanes.h"
#if HWY_TARGET != HWY_SCALAR
#include "methods/march/march_stream.h"
#endif

#include <limits>

#include "methods/march/march.h"

HWY_BEFORE_NAMESPACE();
namespace scanmill::HWY_NAMESPACE {

// Lanes find distances by offsets of 31 bits. Where Highway knows no instructions for lanes there is but one: so it is
// for x86 without SSSE3 if g++ is older than 12.3.
bool fitsLanes(const DistanceField& field) {
  constexpr auto most = static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max());
  return HWY_TARGET != HWY_SCALAR && field.distance.size() * sizeof field.distance[0] <= most;
}

// False: nothing was done, since lanes cannot.
bool marchInLanes(const DistanceField& field, [[maybe_unused]] const TriangleBlock& triangles,
                  [[maybe_unused]] const MarchOptions& options, [[maybe_unused]] const Particles& particles,
                  [[maybe_unused]] std::size_t first, [[maybe_unused]] std::size_t last,
                  [[maybe_unused]] HitRecords& records) {
  if (!fitsLanes(field)) return false;
#if HWY_TARGET != HWY_SCALAR
  if (field.shape.lists) {
    RayStream<true>(field, triangles, options, particles, first, last, records).run();
  } else {
    RayStream<false>(field, triangles, options, particles, first, last, records).run();
  }
#endif
  return true;
}

}  // namespace scanmill::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace scanmill {

namespace {

void marchAlone(const DistanceField& field, const TriangleBlock& triangles, const MarchOptions& options,
                const Particles& particles, std::size_t first, std::size_t last, HitRecords& records) {
  for (std::size_t i = first; i < last; ++i) {
    const HitRecord record = marchOne(field, triangles, options, particles, i);
    records.way[i] = record.way;
    records.triangle[i] = record.triangle;
    records.outcome[i] = static_cast<std::uint32_t>(record.outcome) + 4 * record.steps;
  }
}

// From corners to their triangles: all at once, since words lie anywhere in memory.
void nameTriangles(const DistanceField& field, std::size_t first, std::size_t last, HitRecords& records) {
  for (std::size_t i = first; i < last; ++i) {
    const Outcome outcome = records.outcomeOf(i);
    if (outcome == Outcome::Hit || outcome == Outcome::Grazing) records.triangle[i] = field.word[records.triangle[i]];
  }
}

HWY_EXPORT(marchInLanes);

}  // namespace

void marchCpu(const DistanceField& field, const TriangleBlock& triangles, const MarchOptions& options,
              const Particles& particles, std::size_t first, std::size_t last, HitRecords& records) {
  if (!HWY_DYNAMIC_DISPATCH(marchInLanes)(field, triangles, options, particles, first, last, records)) {
    marchAlone(field, triangles, options, particles, first, last, records);
  } else if (!field.shape.lists) {
    nameTriangles(field, first, last, records);
  }
}

}  // namespace scanmill

#endif
