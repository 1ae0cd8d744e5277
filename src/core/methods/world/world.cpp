#include "methods/world/world.h"

#include <algorithm>

#include "base/error.h"
#include "base/parallel.h"
#include "scene/embree.h"
#include "scene/reflectance.h"

namespace scanmill {

namespace {

// With Instancing::Auto, scenes with at most this many placed triangles are flattened: one level of hierarchy traces
// faster than two, but takes about 150 bytes per triangle. In the scene "street" of 1.28 million triangles both
// hierarchies trace equally fast, and instancing takes half the memory.
constexpr std::uint64_t kFlattenedTriangles = 500'000;

constexpr std::uint64_t kMostVertices = 0xFFFFFFF0u;  // largest number of vertices in a block (32-bit indices)

// Fills World::baked with the instances of all meshes that are not instanced.
void bake(World& world, const std::vector<bool>& instanced) {
  const Scene& scene = *world.scene;
  TriangleBlock& block = world.baked;
  std::vector<BlockSource> sources;
  std::uint64_t vertices = 0;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    if (instanced[instance.mesh] || mesh.triangles.empty()) continue;
    const Affine& worldFromMesh = instance.worldFromMesh;
    sources.push_back({.mesh = &mesh,
                       .blockFromMesh = {worldFromMesh.linear, worldFromMesh.translation - world.origin},
                       .firstVertex = static_cast<std::uint32_t>(vertices),
                       .firstSurface = static_cast<std::uint32_t>(block.surfaces.size())});
    for (const Surface& s : mesh.surfaces) block.surfaces.push_back({instanceId(instance, s), s.semantic, s.material});
    vertices += mesh.positions.size();
    if (vertices > kMostVertices) {
      throw Error(
          "the scene has over 4 billion vertices in meshes that are placed once: place repeated meshes as copies of "
          "one object");
    }
  }
  fillBlock(block, scene, sources);
}

// Sets World::placed, without blocks, to the parts of instanced meshes that are within Revolution::reach at some time
// of the revolution. Returns, for each element of World::placed, the number of its part in `shared`.
std::vector<std::size_t> placeParts(World& world, const std::vector<bool>& instanced, const SharedMeshes& shared) {
  const Revolution& revolution = world.revolution;
  std::vector<std::size_t> parts;
  for (std::uint32_t i = 0; i < world.scene->instances.size(); ++i) {
    const Instance& instance = world.scene->instances[i];
    if (!instanced[instance.mesh]) continue;
    const RigidMotion* const motion = revolution.placed == nullptr ? nullptr : revolution.placed->find(i);
    if (motion != nullptr && motion->hidden) continue;
    const auto originFromMeshAt = [&](double time) {
      const Affine worldFromMesh = worldFromMeshAt(instance, i, revolution.placed.get(), time);
      return Affine{worldFromMesh.linear, worldFromMesh.translation - world.origin};
    };
    const bool moves = motion != nullptr ? motion->moves() : instance.movement != nullptr;
    PlacedBlock placed;
    placed.instance = i;
    placed.originFromMesh = originFromMeshAt(revolution.time);
    placed.normalFromMesh = transposed(inverse(placed.originFromMesh.linear));
    placed.firstInstanceId = instance.firstInstanceId;
    placed.moves = moves && revolution.duration > 0;
    if (placed.moves) placed.atEnd = originFromMeshAt(revolution.time + revolution.duration);
    const std::uint32_t mesh = instance.meshAt(revolution.time + revolution.duration / 2);
    for (std::size_t part = shared.firstPart(mesh); part < shared.firstPart(mesh + 1); ++part) {
      const Box& bounds = shared.part(part).bounds;
      if (bounds.empty()) continue;
      Box box = boxAround(placed.originFromMesh, bounds);
      if (placed.moves) box.add(boxAround(placed.atEnd, bounds));
      if (box.distanceTo({}) > revolution.reach) continue;
      world.placed.push_back(placed);
      parts.push_back(part);
    }
  }
  return parts;
}

}  // namespace

Affine PlacedBlock::at(double fraction) const {
  if (!moves) return originFromMesh;
  const auto between = [fraction](const Vec3d& a, const Vec3d& b) { return a + (b - a) * fraction; };
  const Mat3& a = originFromMesh.linear;
  const Mat3& b = atEnd.linear;
  return {{between(a.x, b.x), between(a.y, b.y), between(a.z, b.z)},
          between(originFromMesh.translation, atEnd.translation)};
}

bool worldsMove(const Scene& scene, Instancing instancing) {
  return scene.unreduced != nullptr && instancing != Instancing::Never ? scene.unreduced->moves : scene.moves();
}

std::vector<bool> instancedMeshes(const Scene& scene, Instancing instancing) {
  if (instancing == Instancing::Always || worldsMove(scene, instancing)) {
    return std::vector<bool>(scene.meshes.size(), true);
  }
  std::vector<bool> instanced(scene.meshes.size());
  const UnreducedScene* const unreduced = scene.unreduced.get();
  const std::uint64_t triangles = unreduced != nullptr ? unreduced->placedTriangles : scene.placedTriangles();
  if (instancing == Instancing::Never || triangles <= kFlattenedTriangles) return instanced;
  const std::vector<std::uint64_t> copies = unreduced != nullptr ? unreduced->copies : scene.copies();
  for (std::size_t m = 0; m < instanced.size(); ++m) instanced[m] = copies[m] > 1;
  return instanced;
}

std::unique_ptr<World> buildWorld(RTCDeviceTy* device, const Scene& scene, const Vec3d& origin,
                                  const std::vector<bool>& instanced, const SharedMeshes& shared,
                                  const HierarchyOptions& options, const Revolution& revolution) {
  auto world = std::make_unique<World>();
  world->origin = origin;
  world->scene = &scene;
  world->revolution = revolution;
  bake(*world, instanced);
  world->embree = newScene(device);
  attachBlock(device, world->embree.get(), world->baked, options);
  const std::vector<std::size_t> parts = placeParts(*world, instanced, shared);
  shared.build(parts);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const SharedMeshes::Part& part = shared.part(parts[i]);
    PlacedBlock& placed = world->placed[i];
    placed.block = part.block.get();
    placed.hierarchy = part.hierarchy.get();
    const unsigned id = World::kFirstPlaced + static_cast<unsigned>(i);
    if (placed.moves) {
      attachInstance(device, world->embree.get(), part.hierarchy.get(), {placed.originFromMesh, placed.atEnd}, id);
    } else {
      attachInstance(device, world->embree.get(), part.hierarchy.get(), {placed.originFromMesh}, id);
    }
  }
  isolated([&] { rtcCommitScene(world->embree.get()); });
  checkEmbree(device, "build the scene");
  return world;
}

bool transparentAt(const World& world, const TriangleBlock& block, std::uint32_t triangle, double u, double v) {
  const Material& material = world.scene->materials[block.surfaceOf(triangle).material];
  const Vec2f uv = textureCoordinates(block.uvs, block.corners[triangle], {u, v});
  return letsPass(material, material.texture->texel(uv.x, uv.y));
}

}  // namespace scanmill
