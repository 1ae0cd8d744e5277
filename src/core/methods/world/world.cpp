#include "methods/world/world.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstring>

#include "base/error.h"
#include "base/parallel.h"
#include "scene/embree.h"
#include "scene/reflectance.h"

namespace scanmill {

namespace {

// With Instancing::Auto, scenes with at most this many placed triangles are flattened: one level of hierarchy traces
// faster than two, but takes about 150 bytes per triangle. In the scene "street" of 1.28 million triangles both trace
// equally fast, and instancing takes half the memory.
constexpr std::uint64_t kFlattenedTriangles = 500'000;

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

// A mesh to be added to a block.
struct Source {
  const Mesh* mesh;
  Affine blockFromMesh;
  std::uint32_t firstVertex, firstSurface;
};

// Appends either the opaque or the alpha-tested triangles of a mesh. fillPlanes() adds their planes later, in parallel.
void appendTriangles(TriangleBlock& block, const Scene& scene, const Source& source, bool alpha) {
  const Mesh& mesh = *source.mesh;
  std::vector<bool> wanted(mesh.surfaces.size());
  for (std::size_t s = 0; s < wanted.size(); ++s) wanted[s] = alphaTested(scene, mesh.surfaces[s]) == alpha;
  const std::uint32_t first = source.firstVertex;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!wanted[mesh.surfaceOf[t]]) continue;
    const Triangle& c = mesh.triangles[t];
    block.corners.push_back({c[0] + first, c[1] + first, c[2] + first});
    block.triangles.push_back({{}, 0, source.firstSurface + mesh.surfaceOf[t], t});
  }
}

void fillVertices(TriangleBlock& block, const std::vector<Source>& sources) {
  parallelFor(sources.size(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const Source& source = sources[i];
      for (std::size_t v = 0; v < source.mesh->positions.size(); ++v) {
        block.vertices[source.firstVertex + v] = Vec3f(source.blockFromMesh * Vec3d(source.mesh->positions[v]));
      }
    }
  });
}

// Computes the triangles' planes in double from the meshes' corners and transforms, without the rounding of transformed
// vertices.
void fillPlanes(TriangleBlock& block, const std::vector<Source>& sources) {
  parallelFor(block.triangles.size(), 4096, [&](std::size_t first, std::size_t last) {
    for (std::size_t t = first; t < last; ++t) {
      const auto next = std::upper_bound(sources.begin(), sources.end(), block.corners[t][0],
                                         [](std::uint32_t v, const Source& s) { return v < s.firstVertex; });
      const Source& source = *std::prev(next);
      BlockTriangle& triangle = block.triangles[t];
      const Triangle& corners = source.mesh->triangles[triangle.primitive];
      const auto corner = [&](int i) { return source.blockFromMesh * Vec3d(source.mesh->positions[corners[i]]); };
      const Vec3d a = corner(0);
      triangle.normal = normalized(cross(corner(1) - a, corner(2) - a));
      triangle.offset = dot(triangle.normal, a);
    }
  });
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

RTCBuildQuality qualityOf(const HierarchyOptions& options) {
  switch (options.quality) {
    case HierarchyQuality::Low:
      return RTC_BUILD_QUALITY_LOW;
    case HierarchyQuality::High:
      return RTC_BUILD_QUALITY_HIGH;
    case HierarchyQuality::Medium:
      break;
  }
  return RTC_BUILD_QUALITY_MEDIUM;
}

void attachTriangles(RTCDevice device, RTCScene scene, const TriangleBlock& block, std::uint32_t first,
                     std::uint32_t last, unsigned id, const HierarchyOptions& options, RTCFilterFunctionN filter) {
  if (first == last) return;
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, block.vertices.data(), 0,
                             sizeof(Vec3f), block.vertices.size() - 1);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, block.corners.data(),
                             first * sizeof(Triangle), sizeof(Triangle), last - first);
  if (filter != nullptr) rtcSetGeometryIntersectFilterFunction(geometry, filter);
  if (options.occlusionFilter != nullptr) rtcSetGeometryOccludedFilterFunction(geometry, options.occlusionFilter);
  // A scene of low quality builds each geometry with the quality set for the geometry.
  rtcSetGeometryBuildQuality(geometry, qualityOf(options));
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, id);
  rtcReleaseGeometry(geometry);
}

void attachBlock(RTCDevice device, RTCScene scene, const TriangleBlock& block, const HierarchyOptions& options) {
  const auto count = static_cast<std::uint32_t>(block.triangles.size());
  attachTriangles(device, scene, block, 0, block.firstAlpha, 0, options, options.solidFilter);
  attachTriangles(device, scene, block, block.firstAlpha, count, 1, options, options.alphaFilter);
}

SceneHandle newScene(RTCDevice device, const HierarchyOptions& options) {
  SceneHandle scene(rtcNewScene(device));
  rtcSetSceneFlags(scene.get(), options.robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
  rtcSetSceneBuildQuality(scene.get(), qualityOf(options));
  return scene;
}

void fill(TriangleBlock& block, const Scene& scene, const std::vector<Source>& sources) {
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  bool uvs = false;
  for (const Source& s : sources) {
    vertices += s.mesh->positions.size();
    triangles += s.mesh->triangles.size();
    uvs = uvs || needsUvs(scene, *s.mesh);
  }
  block.vertices.resize(vertices + 1);
  block.corners.reserve(triangles);
  block.triangles.reserve(triangles);
  for (const bool alpha : {false, true}) {
    for (const Source& s : sources) appendTriangles(block, scene, s, alpha);
    if (!alpha) block.firstAlpha = static_cast<std::uint32_t>(block.triangles.size());
  }
  fillVertices(block, sources);
  fillPlanes(block, sources);
  if (uvs) {
    block.uvs.reserve(vertices);
    for (const Source& s : sources) appendUvs(block, *s.mesh);
  }
}

std::unique_ptr<TriangleBlock> sharedBlock(const Scene& scene, const Mesh& mesh) {
  auto block = std::make_unique<TriangleBlock>();
  for (const Surface& s : mesh.surfaces) block->surfaces.push_back({s.object, s.semantic, s.material});
  fill(*block, scene, {{&mesh, {}, 0, 0}});
  return block;
}

void bake(World& world, const std::vector<bool>& instanced) {
  const Scene& scene = *world.scene;
  TriangleBlock& block = world.baked;
  std::vector<Source> sources;
  std::uint64_t vertices = 0;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    if (instanced[instance.mesh] || mesh.triangles.empty()) continue;
    const Affine& place = instance.worldFromMesh;
    sources.push_back({&mesh,
                       {place.linear, place.translation - world.origin},
                       static_cast<std::uint32_t>(vertices),
                       static_cast<std::uint32_t>(block.surfaces.size())});
    for (const Surface& s : mesh.surfaces) block.surfaces.push_back({instanceId(instance, s), s.semantic, s.material});
    vertices += mesh.positions.size();
    if (vertices > 0xFFFFFFF0u) {
      throw Error(
          "the scene has over 4 billion vertices in meshes that are placed once: place repeated meshes as copies of "
          "one object");
    }
  }
  fill(block, scene, sources);
}

void setTransform(RTCGeometry geometry, unsigned step, const Affine& a) {
  const std::array<float, 12> columns{float(a.linear.x.x),    float(a.linear.x.y),    float(a.linear.x.z),
                                      float(a.linear.y.x),    float(a.linear.y.y),    float(a.linear.y.z),
                                      float(a.linear.z.x),    float(a.linear.z.y),    float(a.linear.z.z),
                                      float(a.translation.x), float(a.translation.y), float(a.translation.z)};
  rtcSetGeometryTransform(geometry, step, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns.data());
}

void attachInstance(RTCDevice device, RTCScene scene, RTCScene shared, const PlacedBlock& placed, unsigned id) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, shared);
  if (placed.moves) rtcSetGeometryTimeStepCount(geometry, 2);
  setTransform(geometry, 0, placed.originFromMesh);
  if (placed.moves) setTransform(geometry, 1, placed.atEnd);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, id);
  rtcReleaseGeometry(geometry);
}

}  // namespace

Affine PlacedBlock::at(double part) const {
  if (!moves) return originFromMesh;
  const auto between = [part](const Vec3d& a, const Vec3d& b) { return a + (b - a) * part; };
  const Mat3& a = originFromMesh.linear;
  const Mat3& b = atEnd.linear;
  return {{between(a.x, b.x), between(a.y, b.y), between(a.z, b.z)},
          between(originFromMesh.translation, atEnd.translation)};
}

void DeviceDeleter::operator()(RTCDeviceTy* device) const {
  rtcReleaseDevice(device);
}

void SceneDeleter::operator()(RTCSceneTy* scene) const {
  rtcReleaseScene(scene);
}

DeviceHandle makeDevice() {
  DeviceHandle device(rtcNewDevice(nullptr));
  if (!device) throw Error("Embree could not start on this machine: is the memory limit too low (ulimit -v)?");
  return device;
}

std::string embreeVersion(RTCDevice device) {
  const auto part = [&](RTCDeviceProperty property) { return rtcGetDeviceProperty(device, property); };
  return fmt::format("{}.{}.{}", part(RTC_DEVICE_PROPERTY_VERSION_MAJOR), part(RTC_DEVICE_PROPERTY_VERSION_MINOR),
                     part(RTC_DEVICE_PROPERTY_VERSION_PATCH));
}

bool worldsMove(const Scene& scene, Instancing instancing) {
  return scene.whole != nullptr && instancing != Instancing::Never ? scene.whole->moves : scene.moves();
}

std::vector<bool> instancedMeshes(const Scene& scene, Instancing instancing) {
  const WholeScene* const whole = scene.whole.get();
  const std::vector<std::uint64_t> copies = whole != nullptr ? whole->copies : scene.copies();
  const bool large = (whole != nullptr ? whole->placedTriangles : scene.placedTriangles()) > kFlattenedTriangles;
  const bool moves = worldsMove(scene, instancing);
  std::vector<bool> instanced(scene.meshes.size());
  for (std::size_t m = 0; m < instanced.size(); ++m) {
    instanced[m] =
        moves || instancing == Instancing::Always || (instancing == Instancing::Auto && large && copies[m] > 1);
  }
  return instanced;
}

SharedMeshes buildSharedMeshes(RTCDeviceTy* device, const Scene& scene, const std::vector<bool>& instanced,
                               const HierarchyOptions& options) {
  SharedMeshes shared;
  shared.blocks.resize(scene.meshes.size());
  shared.scenes.resize(scene.meshes.size());
  parallelFor(scene.meshes.size(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t m = first; m < last; ++m) {
      if (!instanced[m]) continue;
      shared.blocks[m] = sharedBlock(scene, scene.meshes[m]);
      shared.scenes[m] = newScene(device, options);
      attachBlock(device, shared.scenes[m].get(), *shared.blocks[m], options);
      isolated([&] { rtcCommitScene(shared.scenes[m].get()); });
      check(device, "build the shared meshes");  // Embree keeps an error for the thread in which it occurs
    }
  });
  return shared;
}

std::unique_ptr<World> buildWorld(RTCDeviceTy* device, const Scene& scene, const Vec3d& origin,
                                  const std::vector<bool>& instanced, const SharedMeshes& shared,
                                  const HierarchyOptions& options, double time, double duration) {
  auto world = std::make_unique<World>();
  world->origin = origin;
  world->scene = &scene;
  world->time = time;
  world->duration = duration;
  world->shared = &shared;
  bake(*world, instanced);
  world->embree = newScene(device, options);
  attachBlock(device, world->embree.get(), world->baked, options);
  for (const Instance& instance : scene.instances) {
    if (!instanced[instance.mesh]) continue;
    const auto placeAt = [&](double when) {
      const Affine a = instance.worldFromMeshAt(when);
      return Affine{a.linear, a.translation - origin};
    };
    const auto id = World::kFirstPlaced + static_cast<unsigned>(world->placed.size());
    PlacedBlock placed;
    const std::uint32_t mesh = instance.meshAt(time + duration / 2);
    placed.block = shared.blocks[mesh].get();
    placed.originFromMesh = placeAt(time);
    placed.firstInstanceId = instance.firstInstanceId;
    placed.normalFromMesh = transposed(inverse(placed.originFromMesh.linear));
    if (instance.movement != nullptr && duration > 0) {
      placed.atEnd = placeAt(time + duration);
      placed.moves = true;
    }
    attachInstance(device, world->embree.get(), shared.scenes[mesh].get(), placed, id);
    world->placed.push_back(placed);
  }
  rtcCommitScene(world->embree.get());
  check(device, "build the scene");
  return world;
}

bool transparentAt(const World& world, const TriangleBlock& block, std::uint32_t triangle, double u, double v) {
  const Material& material = world.scene->materials[block.surfaceOf(triangle).material];
  const Vec2f uv = textureCoordinates(block.uvs, block.corners[triangle], {u, v});
  return letsPass(material, material.texture->texel(uv.x, uv.y));
}

}  // namespace scanmill
