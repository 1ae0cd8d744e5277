#include "methods/march/march_lanes.h"
#if HWY_TARGET != HWY_SCALAR
#include "methods/march/march_stream.h"
#endif

#include <limits>

#include "methods/march/march.h"

namespace scanmill {

namespace {

// Lanes find distances by offsets of 31 bits. Where Highway knows no instructions for lanes there is but one: so it is
// for x86 without SSSE3 if g++ is older than 12.3.
bool fitsLanes(const DistanceField& field) {
  constexpr auto most = static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max());
  return HWY_TARGET != HWY_SCALAR && field.distance.size() * sizeof field.distance[0] <= most;
}

void marchAlone(const DistanceField& field, const TriangleBlock& triangles, const MarchOptions& options,
                const Particles& particles, std::size_t first, std::size_t last, HitRecords& records) {
  for (std::size_t i = first; i < last; ++i) {
    const HitRecord record = marchOne(field, triangles, options, particles, i);
    records.way[i] = record.way;
    records.triangle[i] = record.triangle;
    records.outcome[i] = static_cast<std::uint32_t>(record.outcome) + 4 * record.steps;
  }
}

#if HWY_TARGET != HWY_SCALAR
// From corners to their triangles: all at once, since words lie anywhere in memory.
void nameTriangles(const DistanceField& field, std::size_t first, std::size_t last, HitRecords& records) {
  for (std::size_t i = first; i < last; ++i) {
    const Outcome outcome = records.outcomeOf(i);
    if (outcome == Outcome::Hit || outcome == Outcome::Grazing) records.triangle[i] = field.word[records.triangle[i]];
  }
}
#endif

}  // namespace

void marchCpu(const DistanceField& field, const TriangleBlock& triangles, const MarchOptions& options,
              const Particles& particles, std::size_t first, std::size_t last, HitRecords& records) {
  if (!fitsLanes(field)) {
    marchAlone(field, triangles, options, particles, first, last, records);
    return;
  }
#if HWY_TARGET != HWY_SCALAR
  if (field.shape.lists) {
    RayStream<true>(field, triangles, options, particles, first, last, records).run();
  } else {
    RayStream<false>(field, triangles, options, particles, first, last, records).run();
    nameTriangles(field, first, last, records);
  }
#endif
}

}  // namespace scanmill
