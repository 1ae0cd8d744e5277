#pragma once

// Builds fields, by Embree's point queries.

#include <cstdint>
#include <memory>

#include "methods/field/field.h"
#include "methods/world/world.h"

namespace scanmill {

// What building took, for benchmarks and reports.
struct BuildCounts {
  std::uint64_t bricks = 0;     // looked at
  std::uint64_t kept = 0;       // of them taken over from the field before
  std::uint64_t distances = 0;  // corners whose distances were computed, and centres of bricks
  std::uint64_t listed = 0;     // entries of lists made
};

// Bricks that `before` has (null: none), of the same voxel size, lists and world, are taken over: the result is the
// same, byte by byte. The world must be flat (nothing instanced). An empty world gives a field of empty bricks. Runs on
// all threads; the bytes do not depend on how many.
std::shared_ptr<const Field> buildField(const World& world, const FieldShape& shape, const Field* before,
                                        BuildCounts* counts = nullptr);

}  // namespace scanmill
