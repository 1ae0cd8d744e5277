#include "methods/ray_tracing/world.h"

#include <embree3/rtcore.h>
#include <fmt/core.h>

#include <algorithm>
#include <cstring>

#include "base/error.h"
#include "base/parallel.h"
#include "methods/ray_tracing/filter.h"

namespace scanmill {

namespace {

// A scene with fewer placed triangles is flattened: one level traces faster than two, and costs about 130 bytes a
// triangle.
constexpr std::uint64_t kFlattenedTriangles = 1'500'000;

void check(RTCDevice device, const char* what) {
  const RTCError code = rtcGetDeviceError(device);
  if (code == RTC_ERROR_NONE) return;
  throw Error(fmt::format("Embree could not {}: {}", what,
                          code == RTC_ERROR_OUT_OF_MEMORY ? "out of memory" : fmt::format("error {}", int(code))));
}

bool alphaTested(const Scene& scene, const Surface& surface) {
  const Material& material = scene.materials[surface.material];
  return material.alphaTested && material.texture != nullptr;
}

// Appends a mesh's triangles, opaque ones or alpha-tested ones.
void appendTriangles(TriangleBlock& block, const Scene& scene, const Mesh& mesh, std::uint32_t firstVertex,
                     std::uint32_t firstSurface, bool alpha) {
  std::vector<bool> wanted(mesh.surfaces.size());
  for (std::size_t s = 0; s < wanted.size(); ++s) wanted[s] = alphaTested(scene, mesh.surfaces[s]) == alpha;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!wanted[mesh.surfaceOf[t]]) continue;
    const Triangle& corners = mesh.triangles[t];
    block.triangles.push_back({{corners[0] + firstVertex, corners[1] + firstVertex, corners[2] + firstVertex},
                               firstSurface + mesh.surfaceOf[t],
                               t});
  }
}

void reserve(TriangleBlock& block, std::size_t vertices, std::size_t triangles, bool uvs) {
  block.rounded.reserve(vertices + 1);
  if (uvs) block.uvs.reserve(vertices);
  block.triangles.reserve(triangles);
}

bool needsUvs(const Scene& scene, const Mesh& mesh) {
  return !mesh.uvs.empty() && std::any_of(mesh.surfaces.begin(), mesh.surfaces.end(), [&](const Surface& s) {
    return scene.materials[s.material].texture != nullptr;
  });
}

void appendUvs(TriangleBlock& block, const Mesh& mesh) {
  if (mesh.uvs.empty()) {
    block.uvs.resize(block.uvs.size() + mesh.positions.size());
  } else {
    block.uvs.insert(block.uvs.end(), mesh.uvs.begin(), mesh.uvs.end());
  }
}

void attachTriangles(RTCDevice device, RTCScene scene, const TriangleBlock& block, std::uint32_t first,
                     std::uint32_t last, unsigned id, RTCFilterFunctionN filter) {
  if (first == last) return;
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, block.rounded.data(), 0,
                             sizeof(Vec3f), block.rounded.size() - 1);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, block.triangles.data(),
                             first * sizeof(BlockTriangle), sizeof(BlockTriangle), last - first);
  rtcSetGeometryIntersectFilterFunction(geometry, filter);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, id);
  rtcReleaseGeometry(geometry);
}

void attachBlock(RTCDevice device, RTCScene scene, const TriangleBlock& block) {
  const auto count = static_cast<std::uint32_t>(block.triangles.size());
  attachTriangles(device, scene, block, 0, block.firstAlpha, 0, tieFilter);
  attachTriangles(device, scene, block, block.firstAlpha, count, 1, alphaTieFilter);
}

SceneHandle newScene(RTCDevice device, const RayTracingOptions& options) {
  SceneHandle scene(rtcNewScene(device));
  rtcSetSceneFlags(scene.get(), options.robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
  switch (options.quality) {
    case RayTracingOptions::Quality::Low:
      rtcSetSceneBuildQuality(scene.get(), RTC_BUILD_QUALITY_LOW);
      break;
    case RayTracingOptions::Quality::Medium:
      rtcSetSceneBuildQuality(scene.get(), RTC_BUILD_QUALITY_MEDIUM);
      break;
    case RayTracingOptions::Quality::High:
      rtcSetSceneBuildQuality(scene.get(), RTC_BUILD_QUALITY_HIGH);
      break;
  }
  return scene;
}

// Embree reads 16 bytes at each 12-byte vertex.
void pad(TriangleBlock& block) {
  block.rounded.emplace_back();
}

std::unique_ptr<TriangleBlock> sharedBlock(const Scene& scene, const Mesh& mesh) {
  auto block = std::make_unique<TriangleBlock>();
  reserve(*block, mesh.positions.size(), mesh.triangles.size(), needsUvs(scene, mesh));
  block->rounded.insert(block->rounded.end(), mesh.positions.begin(), mesh.positions.end());
  if (needsUvs(scene, mesh)) appendUvs(*block, mesh);
  for (const Surface& s : mesh.surfaces) block->surfaces.push_back({s.object, s.semantic, s.material});
  appendTriangles(*block, scene, mesh, 0, 0, false);
  block->firstAlpha = static_cast<std::uint32_t>(block->triangles.size());
  appendTriangles(*block, scene, mesh, 0, 0, true);
  pad(*block);
  return block;
}

void bake(World& world, const std::vector<bool>& instanced) {
  const Scene& scene = *world.scene;
  TriangleBlock& block = world.baked;
  struct Source {
    const Instance* instance;
    const Mesh* mesh;
    std::uint32_t firstVertex, firstSurface;
  };
  std::vector<Source> sources;
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  bool uvs = false;
  for (const Instance& instance : scene.instances) {
    if (instanced[instance.mesh]) continue;
    const Mesh& mesh = scene.meshes[instance.mesh];
    sources.push_back(
        {&instance, &mesh, static_cast<std::uint32_t>(vertices), static_cast<std::uint32_t>(block.surfaces.size())});
    for (const Surface& s : mesh.surfaces) block.surfaces.push_back({instanceId(instance, s), s.semantic, s.material});
    vertices += mesh.positions.size();
    triangles += mesh.triangles.size();
    uvs = uvs || needsUvs(scene, mesh);
  }
  if (triangles > 0xFFFFFFF0u || vertices > 0xFFFFFFF0u) {
    throw Error(fmt::format("the scene has {} triangles outside instances; 4 billion is the limit", triangles));
  }
  reserve(block, vertices, triangles, uvs);
  block.rounded.resize(vertices);
  block.exact.resize(vertices);
  parallelFor(sources.size(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const Source& source = sources[i];
      const Affine originFromMesh{source.instance->worldFromMesh.linear,
                                  source.instance->worldFromMesh.translation - world.origin};
      for (std::size_t v = 0; v < source.mesh->positions.size(); ++v) {
        const Vec3d p = originFromMesh * Vec3d(source.mesh->positions[v]);
        block.exact[source.firstVertex + v] = p;
        block.rounded[source.firstVertex + v] = Vec3f(p);
      }
    }
  });
  for (const bool alpha : {false, true}) {
    for (const Source& s : sources) appendTriangles(block, scene, *s.mesh, s.firstVertex, s.firstSurface, alpha);
    if (!alpha) block.firstAlpha = static_cast<std::uint32_t>(block.triangles.size());
  }
  if (uvs) {
    for (const Source& s : sources) appendUvs(block, *s.mesh);
  }
  pad(block);
}

void attachInstance(RTCDevice device, RTCScene scene, RTCScene shared, const Affine& a, unsigned id) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, shared);
  const std::array<float, 12> columns{float(a.linear.x.x),    float(a.linear.x.y),    float(a.linear.x.z),
                                      float(a.linear.y.x),    float(a.linear.y.y),    float(a.linear.y.z),
                                      float(a.linear.z.x),    float(a.linear.z.y),    float(a.linear.z.z),
                                      float(a.translation.x), float(a.translation.y), float(a.translation.z)};
  rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns.data());
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, id);
  rtcReleaseGeometry(geometry);
}

}  // namespace

void DeviceDeleter::operator()(RTCDeviceTy* device) const {
  rtcReleaseDevice(device);
}

void SceneDeleter::operator()(RTCSceneTy* scene) const {
  rtcReleaseScene(scene);
}

DeviceHandle makeDevice() {
  DeviceHandle device(rtcNewDevice(nullptr));
  if (!device) throw Error("Embree could not start on this machine");
  return device;
}

std::vector<bool> instancedMeshes(const Scene& scene, RayTracingOptions::Instancing instancing) {
  std::vector<std::uint64_t> copies(scene.meshes.size());
  for (const Instance& instance : scene.instances) ++copies[instance.mesh];
  const bool large = scene.placedTriangles() > kFlattenedTriangles;
  std::vector<bool> instanced(scene.meshes.size());
  for (std::size_t m = 0; m < instanced.size(); ++m) {
    instanced[m] = instancing == RayTracingOptions::Instancing::Always ||
                   (instancing == RayTracingOptions::Instancing::Auto && large && copies[m] > 1);
  }
  return instanced;
}

SharedMeshes buildSharedMeshes(RTCDeviceTy* device, const Scene& scene, const std::vector<bool>& instanced,
                               const RayTracingOptions& options) {
  SharedMeshes shared;
  shared.blocks.resize(scene.meshes.size());
  shared.scenes.resize(scene.meshes.size());
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    if (!instanced[m]) continue;
    shared.blocks[m] = sharedBlock(scene, scene.meshes[m]);
    shared.scenes[m] = newScene(device, options);
    attachBlock(device, shared.scenes[m].get(), *shared.blocks[m]);
    rtcCommitScene(shared.scenes[m].get());
  }
  check(device, "build the shared meshes");
  return shared;
}

std::unique_ptr<World> buildWorld(RTCDeviceTy* device, const Scene& scene, const Vec3d& origin,
                                  const std::vector<bool>& instanced, const SharedMeshes& shared,
                                  const RayTracingOptions& options) {
  auto world = std::make_unique<World>();
  world->origin = origin;
  world->scene = &scene;
  bake(*world, instanced);
  world->embree = newScene(device, options);
  attachBlock(device, world->embree.get(), world->baked);
  for (const Instance& instance : scene.instances) {
    if (!instanced[instance.mesh]) continue;
    const Affine originFromMesh{instance.worldFromMesh.linear, instance.worldFromMesh.translation - origin};
    const auto id = World::kFirstPlaced + static_cast<unsigned>(world->placed.size());
    world->placed.push_back({shared.blocks[instance.mesh].get(), originFromMesh, instance.firstInstanceId});
    attachInstance(device, world->embree.get(), shared.scenes[instance.mesh].get(), originFromMesh, id);
  }
  rtcCommitScene(world->embree.get());
  check(device, "build the scene");
  return world;
}

const std::uint8_t* texelAt(const TriangleBlock& block, std::uint32_t triangle, const Texture& texture, double u,
                            double v) {
  if (block.uvs.empty()) return texture.texel(0, 0);
  const Triangle& corners = block.triangles[triangle].corners;
  const Vec2f a = block.uvs[corners[0]];
  const Vec2f b = block.uvs[corners[1]];
  const Vec2f c = block.uvs[corners[2]];
  const double w = 1 - u - v;
  return texture.texel(static_cast<float>(w * a.x + u * b.x + v * c.x),
                       static_cast<float>(w * a.y + u * b.y + v * c.y));
}

}  // namespace scanmill
