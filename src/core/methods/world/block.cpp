#include "methods/world/block.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string_view>

#include "base/error.h"
#include "base/parallel.h"
#include "scene/embree.h"

namespace scanmill {

namespace {

bool alphaTested(const Scene& scene, const Surface& surface) {
  const Material& material = scene.materials[surface.material];
  return material.alphaTested && material.texture != nullptr;
}

// Appends either the opaque or the alpha-tested triangles of a mesh. fillPlanes() adds their planes later, in parallel.
void appendTriangles(TriangleBlock& block, const Scene& scene, const BlockSource& source, bool alpha) {
  const Mesh& mesh = *source.mesh;
  std::vector<char> wanted(mesh.surfaces.size());
  for (std::size_t s = 0; s < wanted.size(); ++s) wanted[s] = alphaTested(scene, mesh.surfaces[s]) == alpha ? 1 : 0;
  if (std::count(wanted.begin(), wanted.end(), 1) == 0) return;
  const std::uint32_t first = source.firstVertex;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (wanted[mesh.surfaceOf[t]] == 0) continue;
    const Triangle& c = mesh.triangles[t];
    block.corners.push_back({c[0] + first, c[1] + first, c[2] + first});
    block.triangles.push_back({{}, 0, source.firstSurface + mesh.surfaceOf[t], t});
  }
}

void fillVertices(TriangleBlock& block, const std::vector<BlockSource>& sources) {
  parallelFor(sources.size(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const BlockSource& source = sources[i];
      for (std::size_t v = 0; v < source.mesh->positions.size(); ++v) {
        block.vertices[source.firstVertex + v] = Vec3f(source.blockFromMesh * Vec3d(source.mesh->positions[v]));
      }
    }
  });
}

// Computes the triangles' planes in double from the meshes' corners and transforms, without the rounding of transformed
// vertices.
void fillPlanes(TriangleBlock& block, const std::vector<BlockSource>& sources) {
  parallelFor(block.triangles.size(), 4096, [&](std::size_t first, std::size_t last) {
    for (std::size_t t = first; t < last; ++t) {
      const auto next = std::upper_bound(sources.begin(), sources.end(), block.corners[t][0],
                                         [](std::uint32_t v, const BlockSource& s) { return v < s.firstVertex; });
      const BlockSource& source = *std::prev(next);
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
  rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_MEDIUM);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, id);
  rtcReleaseGeometry(geometry);
}

}  // namespace

DeviceHandle makeDevice() {
  // Ranges differ in their last bits between instruction sets.
  const char* const isa = std::getenv("SCANMILL_ISA");
  constexpr std::array<std::string_view, 5> kKnown{"sse2", "sse4.2", "avx", "avx2", "avx512"};
  if (isa != nullptr && std::ranges::find(kKnown, isa) == kKnown.end()) {
    throw InputError(fmt::format("SCANMILL_ISA={}: there are {}", isa, fmt::join(kKnown, ", ")));
  }
  RTCDevice device = rtcNewDevice(isa == nullptr ? nullptr : fmt::format("isa={}", isa).c_str());
  if (device == nullptr)
    throw Error("Embree could not start on this machine: is the memory limit too low (ulimit -v)?");
  return {device, rtcReleaseDevice};
}

std::string embreeVersion(RTCDevice device) {
  const auto part = [&](RTCDeviceProperty property) { return rtcGetDeviceProperty(device, property); };
  return fmt::format("{}.{}.{}", part(RTC_DEVICE_PROPERTY_VERSION_MAJOR), part(RTC_DEVICE_PROPERTY_VERSION_MINOR),
                     part(RTC_DEVICE_PROPERTY_VERSION_PATCH));
}

void attachBlock(RTCDevice device, RTCScene scene, const TriangleBlock& block, const HierarchyOptions& options) {
  const auto count = static_cast<std::uint32_t>(block.triangles.size());
  attachTriangles(device, scene, block, 0, block.firstAlpha, 0, options, options.solidFilter);
  attachTriangles(device, scene, block, block.firstAlpha, count, 1, options, options.alphaFilter);
}

SceneHandle newScene(RTCDevice device) {
  SceneHandle scene(rtcNewScene(device), rtcReleaseScene);
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene.get(), RTC_BUILD_QUALITY_MEDIUM);
  return scene;
}

void fillBlock(TriangleBlock& block, const Scene& scene, const std::vector<BlockSource>& sources) {
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  bool uvs = false;
  for (const BlockSource& s : sources) {
    vertices += s.mesh->positions.size();
    triangles += s.mesh->triangles.size();
    uvs = uvs || needsUvs(scene, *s.mesh);
  }
  block.vertices.resize(vertices + 1);
  block.corners.reserve(triangles);
  block.triangles.reserve(triangles);
  for (const bool alpha : {false, true}) {
    for (const BlockSource& s : sources) appendTriangles(block, scene, s, alpha);
    if (!alpha) block.firstAlpha = static_cast<std::uint32_t>(block.triangles.size());
  }
  fillVertices(block, sources);
  fillPlanes(block, sources);
  if (uvs) {
    block.uvs.reserve(vertices);
    for (const BlockSource& s : sources) appendUvs(block, *s.mesh);
  }
}

std::unique_ptr<TriangleBlock> blockOf(const Scene& scene, const Mesh& mesh) {
  auto block = std::make_unique<TriangleBlock>();
  for (const Surface& s : mesh.surfaces) block->surfaces.push_back({s.object, s.semantic, s.material});
  fillBlock(*block, scene, {{&mesh, {}, 0, 0}});
  return block;
}

void checkEmbree(RTCDevice device, const char* what) {
  const RTCError code = rtcGetDeviceError(device);
  if (code == RTC_ERROR_NONE) return;
  throw Error(fmt::format("Embree could not {}: {}", what,
                          code == RTC_ERROR_OUT_OF_MEMORY ? "out of memory" : fmt::format("error {}", int(code))));
}

}  // namespace scanmill
