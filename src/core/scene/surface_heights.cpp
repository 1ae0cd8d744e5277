#include "scene/surface_heights.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "base/error.h"
#include "base/parallel.h"
#include "scene/embree.h"
#include "scene/triangles.h"

namespace scanmill {
namespace {

constexpr double kMargin = 1;  // m; rays start this far above and end this far below all surfaces

// Returns the area of the triangle as seen from above (m^2); negative if it faces down.
double areaFromAbove(const std::array<Vec3d, 3>& c) {
  return ((c[1].x - c[0].x) * (c[2].y - c[0].y) - (c[2].x - c[0].x) * (c[1].y - c[0].y)) / 2;
}

// The context of a query that collects every triangle that a ray crosses.
struct Crossings {
  EmbreeContext embree;
  std::vector<SurfaceHeights::Facet>* found;
};

void note(const RTCFilterFunctionNArguments* arguments) {
  auto* const crossings = reinterpret_cast<Crossings*>(arguments->context);
  const unsigned instance = RTCHitN_instID(arguments->hit, arguments->N, 0, 0);
  crossings->found->push_back({instance, RTCHitN_primID(arguments->hit, arguments->N, 0)});
  arguments->valid[0] = 0;  // rejects the hit, so that the ray continues
}

}  // namespace

// Embree's hierarchy, in single precision relative to an anchor. It only finds triangles; their heights are computed in
// double afterwards.
struct SurfaceHeights::Hierarchy {
  RTCDevice device = rtcNewDevice(nullptr);
  RTCScene all = rtcNewScene(device);
  std::vector<RTCScene> meshes;
  Vec3d anchor;
  Box bounds;

  Hierarchy() { rtcSetSceneFlags(all, RTC_SCENE_FLAG_ROBUST); }
  ~Hierarchy() {
    for (RTCScene mesh : meshes) {
      if (mesh != nullptr) rtcReleaseScene(mesh);
    }
    rtcReleaseScene(all);
    rtcReleaseDevice(device);
  }
  Hierarchy(const Hierarchy&) = delete;
  Hierarchy& operator=(const Hierarchy&) = delete;

  RTCScene sceneOf(const Mesh& mesh, std::uint32_t index) {
    if (index >= meshes.size()) meshes.resize(index + 1, nullptr);
    if (meshes[index] != nullptr) return meshes[index];
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    const auto copy = [&](RTCBufferType type, RTCFormat format, const auto& values) {
      using Item = typename std::decay_t<decltype(values)>::value_type;
      static_assert(sizeof(Item) == 12);
      void* const to = rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(Item), values.size());
      if (to == nullptr) throw Error("Embree has no memory for the surfaces that objects stand on");
      std::ranges::copy(values, static_cast<Item*>(to));
    };
    copy(RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, mesh.positions);
    copy(RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, mesh.triangles);
    rtcSetGeometryIntersectFilterFunction(geometry, note);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    isolated([&] { rtcCommitScene(scene); });
    return meshes[index] = scene;
  }

  void add(const Scene& scene, std::uint32_t index) {
    const Instance& instance = scene.instances[index];
    const Affine& a = instance.worldFromMesh;
    const Mesh& mesh = scene.meshes[instance.mesh];
    if (bounds.empty()) anchor = a.translation;
    bounds.add(boxAround(a, mesh.bounds()));
    const Vec3d t = a.translation - anchor;
    std::array<float, 12> columns{};
    std::size_t k = 0;
    for (const Vec3d& c : {a.linear.x, a.linear.y, a.linear.z, t}) {
      for (const double value : {c.x, c.y, c.z}) columns[k++] = static_cast<float>(value);
    }
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, sceneOf(mesh, instance.mesh));
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns.data());
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(all, geometry, index);
    rtcReleaseGeometry(geometry);
  }

  std::vector<Facet> crossedAt(double x, double y) const {
    std::vector<Facet> found;
    Crossings crossings{newEmbreeContext(), &found};
    RTCRayHit ray{};
    ray.ray.org_x = static_cast<float>(x - anchor.x);
    ray.ray.org_y = static_cast<float>(y - anchor.y);
    ray.ray.org_z = static_cast<float>(bounds.high.z + kMargin - anchor.z);
    ray.ray.dir_z = -1;
    ray.ray.tfar = static_cast<float>(bounds.high.z - bounds.low.z + 2 * kMargin);
    ray.ray.mask = UINT32_MAX;
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    intersectOne(all, crossings.embree, ray);
    return found;
  }
};

SurfaceHeights::SurfaceHeights(const Scene& scene) : scene_(scene), hierarchy_(std::make_unique<Hierarchy>()) {}
SurfaceHeights::~SurfaceHeights() = default;

void SurfaceHeights::update() {
  if (taken_ == scene_.instances.size()) return;
  for (; taken_ < scene_.instances.size(); ++taken_) {
    if (!scene_.instances[taken_].moves()) hierarchy_->add(scene_, static_cast<std::uint32_t>(taken_));
  }
  isolated([&] { rtcCommitScene(hierarchy_->all); });
}

std::vector<SurfaceHeights::Surface> SurfaceHeights::at(double x, double y) const {
  std::vector<Surface> surfaces;
  if (hierarchy_->bounds.empty()) return surfaces;
  std::vector<Facet> found = hierarchy_->crossedAt(x, y);
  std::ranges::sort(found);
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (i > 0 && found[i] == found[i - 1]) continue;
    const Mesh& mesh = scene_.meshes[scene_.instances[found[i].instance].mesh];
    const auto [a, b, c] = cornersOf(scene_.instances[found[i].instance], mesh, found[i].triangle);
    const Vec3d normal = cross(b - a, c - a);
    if (!(std::fabs(normal.z) > 1e-6 * length(normal))) continue;  // skips vertical triangles
    const std::uint16_t semantic = mesh.surfaces[mesh.surfaceOf[found[i].triangle]].semantic;
    const SemanticClass* const own = scene_.ontology.find(semantic);
    surfaces.push_back({a.z - (normal.x * (x - a.x) + normal.y * (y - a.y)) / normal.z,
                        std::acos(std::min(std::fabs(normal.z) / length(normal), 1.0)), semantic,
                        own != nullptr && own->thing});
  }
  std::ranges::stable_sort(surfaces, std::greater{}, &Surface::height);
  return surfaces;
}

SurfaceHeights::Area SurfaceHeights::area(const std::vector<std::uint16_t>& classes) const {
  Area up;
  Area any;
  const auto add = [](Area& area, const Facet& facet, double squareMetres) {
    if (!(squareMetres > 0)) return;
    area.facets_.push_back(facet);
    area.sums_.push_back(area.squareMetres() + squareMetres);
  };
  forEachTriangleOf(scene_, classes, taken_,
                    [&](std::uint32_t instance, std::uint32_t t, const std::array<Vec3d, 3>& c) {
                      const bool mirrored = determinant(scene_.instances[instance].worldFromMesh.linear) < 0;
                      const double squareMetres = areaFromAbove(c) * (mirrored ? -1 : 1);
                      if (std::fabs(squareMetres) < 1e-6 * length(cross(c[1] - c[0], c[2] - c[0]))) return;  // vertical
                      add(up, {instance, t}, squareMetres);
                      add(any, {instance, t}, std::fabs(squareMetres));
                    });
  Area& found = up.facets_.empty() ? any : up;
  found.scene_ = &scene_;
  return std::move(found);
}

Vec3d SurfaceHeights::Area::place(const std::array<double, 3>& u) const {
  const auto found = std::upper_bound(sums_.begin(), sums_.end() - 1, u[0] * sums_.back());
  const Facet& facet = facets_[static_cast<std::size_t>(found - sums_.begin())];
  const Instance& instance = scene_->instances[facet.instance];
  const std::array<Vec3d, 3> t = cornersOf(instance, scene_->meshes[instance.mesh], facet.triangle);
  // Shirley's mapping of the unit square to a triangle, uniform by area.
  const double root = std::sqrt(u[1]);
  return t[0] * (1 - root) + t[1] * (root * (1 - u[2])) + t[2] * (root * u[2]);
}

}  // namespace scanmill
