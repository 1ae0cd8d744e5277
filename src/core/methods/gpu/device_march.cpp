#include "methods/gpu/device_march.h"

#include <array>
#include <span>
#include <vector>

#include "base/parallel.h"

namespace scanmill {

namespace {

// The parameters of marchShader(), in std140 layout.
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

MarchBlock marchBlock(const DistanceField& field, std::uint32_t steps, std::size_t count) {
  MarchBlock block{};
  block.lastLevel = static_cast<std::int32_t>(field.levels.size()) - 1;
  block.perReach = 1.0f / field.shape.reach;
  block.metres = static_cast<float>(field.shape.voxel);
  block.steps = steps;
  block.count = static_cast<std::uint32_t>(count);
  return block;
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

}  // namespace

DeviceMarch::DeviceMarch(const ComputeDevice& device, std::uint64_t mostTableBytes)
    : device_(device),
      mostTableBytes_(mostTableBytes),
      marchers_(device, "particle", marchShader),
      particles_(device),
      records_(device),
      triangles_(device),
      fields_(device, mostTableBytes) {
  triangles_.reserve(16);  // buffers without storage cannot be read from
}

void DeviceMarch::hold(const std::shared_ptr<const DistanceField>& field, const std::shared_ptr<const World>& world) {
  fields_.hold(field);
  if (!field->shape.lists || world_.lock() == world) return;
  world_.reset();
  const std::vector<DeviceTriangle> triangles = deviceTriangles(world->baked);
  holdTable(device_, triangles_, ComputeTable::Texel::Float32x4, std::as_bytes(std::span(triangles)), mostTableBytes_,
            "scene's triangles", ": take `refine: none`, which does not need them");
  world_ = world;
}

void DeviceMarch::reserve(bool lists, std::size_t particles) {
  particles_.reserve((lists ? kMostColumns : kFewestColumns) * particles * sizeof(float));
  records_.reserve(5 * particles * sizeof(float));
}

void DeviceMarch::run(const DistanceField& field, std::uint32_t steps, std::size_t particles, bool again) {
  MarchBlock block = marchBlock(field, steps, particles);
  block.again = again ? 1 : 0;
  marchers_.of(field.shape.lists)
      .run(particles, {&particles_, &records_}, std::as_bytes(std::span(&block, 1)),
           {fields_.levels(),
            fields_.table(),
            fields_.distances(),
            fields_.words(),
            fields_.lists(),
            {&triangles_, ComputeTable::Texel::Float32x4}});
}

}  // namespace scanmill
