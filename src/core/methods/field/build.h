#pragma once

// Builds distance fields, by Embree's point queries.

#include <cstdint>
#include <memory>

#include "methods/field/distance_field.h"
#include "methods/world/world.h"

namespace scanmill {

// What building took, for benchmarks and reports.
struct BuildCounts {
  std::uint64_t bricks = 0;     // looked at
  std::uint64_t kept = 0;       // of them taken over from the field before
  std::uint64_t distances = 0;  // corners whose distances were computed, and centres of bricks
  std::uint64_t listed = 0;     // entries of lists made
};

// Builds the field of a world. Where `before` is a field of the same world with the same voxel size and lists, the
// bricks that both have are copied from it; the result is the same, byte by byte, as without it (null). The world must
// be flat: nothing in it is instanced. An empty world gives a field of empty bricks. Runs on all threads; the bytes do
// not depend on how many there are.
std::shared_ptr<const DistanceField> buildField(const World& world, const FieldShape& shape,
                                                const DistanceField* before, BuildCounts* counts = nullptr);

}  // namespace scanmill
