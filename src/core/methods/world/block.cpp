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
#include "scene/triangles.h"

namespace scanmill {

namespace {

bool alphaTested(const Scene& scene, const Surface& surface) {
  const Material& material = scene.materials[surface.material];
  return material.alphaTested && material.texture != nullptr;
}

// Appends a mesh's alpha-tested triangles if `alpha` is true, otherwise its other triangles. fillPlanes() sets planes.
void appendTriangles(TriangleBlock& block, const Scene& scene, const BlockSource& source, bool alpha) {
  const Mesh& mesh = *source.mesh;
  std::vector<char> isAppended(mesh.surfaces.size());  // by surface
  std::ranges::transform(mesh.surfaces, isAppended.begin(),
                         [&](const Surface& surface) { return alphaTested(scene, surface) == alpha ? 1 : 0; });
  if (std::ranges::count(isAppended, 1) == 0) return;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (isAppended[mesh.surfaceOf[t]] == 0) continue;
    Triangle corners = mesh.triangles[t];
    for (std::uint32_t& corner : corners) corner += source.firstVertex;
    block.corners.push_back(corners);
    block.triangles.push_back(
        {.normal = {}, .offset = 0, .surface = source.firstSurface + mesh.surfaceOf[t], .primitive = t});
  }
}

void fillVertices(TriangleBlock& block, const std::vector<BlockSource>& sources) {
  parallelForEach(sources.size(), 1, [&](std::size_t i) {
    const BlockSource& source = sources[i];
    for (std::size_t v = 0; v < source.mesh->positions.size(); ++v) {
      block.vertices[source.firstVertex + v] = Vec3f(source.blockFromMesh * Vec3d(source.mesh->positions[v]));
    }
  });
}

// Computes the triangles' planes in double from the meshes' corners and transforms, without the rounding of transformed
// vertices. The source of a triangle is the last source whose first vertex is not after the triangle's first corner.
void fillPlanes(TriangleBlock& block, const std::vector<BlockSource>& sources) {
  constexpr std::size_t kGrain = 4096;  // triangles per task
  parallelForEach(block.triangles.size(), kGrain, [&](std::size_t t) {
    const auto next = std::ranges::upper_bound(sources, block.corners[t][0], {}, &BlockSource::firstVertex);
    const BlockSource& source = *std::prev(next);
    BlockTriangle& triangle = block.triangles[t];
    const auto [a, b, c] = cornersOf(source.blockFromMesh, *source.mesh, triangle.primitive);
    triangle.normal = normalized(cross(b - a, c - a));
    triangle.offset = dot(triangle.normal, a);
  });
}

bool needsUvs(const Scene& scene, const Mesh& mesh) {
  const auto isTextured = [&](const Surface& s) { return scene.materials[s.material].texture != nullptr; };
  return !mesh.uvs.empty() && std::ranges::any_of(mesh.surfaces, isTextured);
}

// Adds the triangles [first, end) of a block, if there are any, to an Embree scene as the geometry `id`. A null
// filter accepts all hits.
void attachTriangles(RTCDevice device, RTCScene scene, const TriangleBlock& block, std::uint32_t first,
                     std::uint32_t end, unsigned id, RTCFilterFunctionN filter, RTCFilterFunctionN occlusionFilter) {
  if (first == end) return;
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, block.vertices.data(), 0,
                             sizeof(Vec3f), block.vertices.size() - 1);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, block.corners.data(),
                             first * sizeof(Triangle), sizeof(Triangle), end - first);
  if (filter != nullptr) rtcSetGeometryIntersectFilterFunction(geometry, filter);
  if (occlusionFilter != nullptr) rtcSetGeometryOccludedFilterFunction(geometry, occlusionFilter);
  // In a scene of low quality, Embree builds the hierarchy of each geometry with the quality set for this geometry.
  rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_MEDIUM);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, id);
  rtcReleaseGeometry(geometry);
}

}  // namespace

DeviceHandle makeDevice() {
  // Embree's instruction set can be chosen, because ranges differ in their last bits between instruction sets.
  const char* const isa = std::getenv("SCANMILL_ISA");
  constexpr std::array<std::string_view, 5> kIsas{"sse2", "sse4.2", "avx", "avx2", "avx512"};
  if (isa != nullptr && std::ranges::find(kIsas, isa) == kIsas.end()) {
    throw InputError(fmt::format("SCANMILL_ISA={}: there are {}", isa, fmt::join(kIsas, ", ")));
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
  attachTriangles(device, scene, block, 0, block.firstAlpha, 0, options.solidFilter, options.occlusionFilter);
  attachTriangles(device, scene, block, block.firstAlpha, count, 1, options.alphaFilter, options.occlusionFilter);
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
  for (const BlockSource& s : sources) {
    vertices += s.mesh->positions.size();
    triangles += s.mesh->triangles.size();
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
  if (std::ranges::none_of(sources, [&](const BlockSource& s) { return needsUvs(scene, *s.mesh); })) return;
  block.uvs.resize(vertices);  // zero for meshes without texture coordinates
  for (const BlockSource& s : sources) std::ranges::copy(s.mesh->uvs, block.uvs.begin() + s.firstVertex);
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
  throw Error("Embree could not {}: {}", what,
              code == RTC_ERROR_OUT_OF_MEMORY ? "out of memory" : fmt::format("error {}", int(code)));
}

}  // namespace scanmill
