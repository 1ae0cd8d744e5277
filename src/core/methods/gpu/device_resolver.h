#pragma once

// Computes hits on a device from the triangles that a shot's rays hit, with the same bytes as methods/world/resolve.h
// on the CPU. Sums and products in double have the CPU's bits (`precise`). Quotients and roots, which devices round
// differently, have error bounds (kSlack in shaders/rays.glsl); if an error within a bound could change the result, the
// ray is left to the CPU.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gpu/compute.h"
#include "methods/world/world.h"
#include "scan/hits.h"
#include "sensors/beams.h"

namespace scanmill {

// An element of the tables of triangles and materials that shaders read.
using DeviceWord = std::array<std::uint32_t, 4>;

// The first two words have the plane: the normal's x, y, z and the offset, in double. The third word has the instance
// id, class | material << 16, the triangle's index in its mesh, and 1 + its index in LabelTables::textured, or 0 if the
// triangle is not in that list.
struct TriangleRecord {
  DeviceWord normalXY, normalZOffset, label;
};

// Three words, each with a corner (bits of float32, m, relative to the world's origin) and its texture coordinate u;
// then one word with the three texture coordinates v.
struct TexturedTriangle {
  std::array<DeviceWord, 4> words;
};

constexpr std::uint32_t kLetsPass = 0x80000000u;  // bit of a transparent texel; the other bits are the reflectance

// Flags of a material: the reasons why its texels are read.
constexpr std::uint32_t kTextured = 1;  // texels scale the reflectance
constexpr std::uint32_t kCutOut = 2;    // some texels may let beams pass

struct LabelTables {
  std::vector<TriangleRecord> records;     // one per triangle of World::baked
  std::vector<TexturedTriangle> textured;  // triangles whose material's texels are read
  // Each material has the bits of its reflectance, the index of its first texel, width | height << 16 of its texture,
  // and flags.
  std::vector<DeviceWord> materials;
  std::vector<std::uint32_t> texels;  // bits of the reflectance (float32), with kLetsPass if transparent
};

// Returns the tables of a flat world (without instances). Throws Error if a texture has a side of over 65535 texels.
LabelTables labelTables(const World& world);

// The reason why a ray is neither a hit nor a miss: the bits of a NaN that is stored in place of the ray's range.
enum class UnresolvedReason : std::uint32_t {
  Rounding = 0x7FC00001u,     // the device's rounding could change the result: the ray is left to the CPU
  StepsUsedUp = 0x7FC00002u,  // a particle used up its steps
  LeftField = 0x7FC00003u,    // a particle left the field
};

// A ray that the device has not resolved.
struct UnresolvedRay {
  std::uint32_t ray;
  UnresolvedReason reason;
};

// The parameters that hit_columns.glsl reads, in std140 layout.
struct ResolverParameters {
  double nearest, farthest;    // m, the sensor's range limits
  std::uint32_t channels = 0;  // bits of the requested channels
  std::uint32_t rays = 0;
};

class DeviceResolver {
 public:
  explicit DeviceResolver(const ComputeDevice& device);

  // Uploads the labelTables() of a flat world.
  void uploadMeshes(const World& world);

  static ResolverParameters parameters(const BeamTable& beams, Channels channels, std::size_t rays);

  // Reserves space in columns() for the requested channels of `rays` rays, bytesPerRay() for each ray.
  void reserve(Channels channels, std::size_t rays);
  static std::uint64_t bytesPerRay(Channels channels);
  // Returns the buffer for binding 5 of programs that include hit_columns.glsl.
  const ComputeBuffer& columns() const { return columns_; }
  // table(binding) returns the tables for the bindings 0 to kTables - 1 of programs that include hit_columns.glsl.
  static constexpr std::size_t kTables = 4;
  ComputeTable table(std::size_t binding) const;

  // Consecutive rays in columns().
  struct Piece {
    std::size_t totalRays;  // number of all rays in columns()
    std::size_t firstRay;
    std::size_t count;
  };
  // Copies a piece's results to the channels that `hits` has, and appends the rays that are neither hits nor misses to
  // `unresolved`, in ascending order. `columns`: a copy of the complete columns().
  static void copyHits(std::span<const std::byte> columns, const Piece& piece, Hits& hits,
                       std::vector<UnresolvedRay>& unresolved);

 private:
  ComputeDevice device_;
  ComputeBuffer columns_;
  ComputeBuffer records_, materials_, reflectances_, textured_;
};

}  // namespace scanmill
