#include "scene/surface_heights.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "base/error.h"
#include "base/parallel.h"
#include "scene/embree.h"
#include "scene/triangles.h"

namespace scanmill {
namespace {

constexpr double kMargin = 1;  // m; rays start this far above and end this far below all surfaces
// Triangles whose normals are within about this angle (rad) of the horizontal count as vertical and have no height.
constexpr double kVertical = 1e-6;

// The context of a query that collects every triangle that a ray crosses.
struct Crossings {
  EmbreeContext embree;
  std::vector<SurfaceHeights::Facet>* facets;
};

// Embree's filter function: adds the hit triangle to Crossings::facets.
void addCrossing(const RTCFilterFunctionNArguments* arguments) {
  auto* const crossings = reinterpret_cast<Crossings*>(arguments->context);
  const unsigned instance = RTCHitN_instID(arguments->hit, arguments->N, 0, 0);
  crossings->facets->push_back({instance, RTCHitN_primID(arguments->hit, arguments->N, 0)});
  arguments->valid[0] = 0;  // rejects the hit, so that the ray continues
}

constexpr double kMostCellsAlong = 512;  // largest number of cells along a side of the grid
constexpr double kLeastCell = 1e-6;      // m, least edge of a cell
constexpr std::size_t kMostTriangles = 10'000'000;

// Returns the horizontal distance of a point from the line segment between a and b.
double distanceToSegment(const Vec3d& point, const Vec3d& a, const Vec3d& b) {
  const double edgeX = b.x - a.x;
  const double edgeY = b.y - a.y;
  const double squaredLength = edgeX * edgeX + edgeY * edgeY;
  const double fraction =
      squaredLength > 0 ? std::clamp(((point.x - a.x) * edgeX + (point.y - a.y) * edgeY) / squaredLength, 0.0, 1.0) : 0;
  return std::hypot(point.x - a.x - fraction * edgeX, point.y - a.y - fraction * edgeY);
}

// Returns the horizontal distance of `p` from a triangle; 0 if `p` is above or below the triangle. A vertical triangle
// counts as a line.
double distanceToTriangle(const std::array<Vec3d, 3>& corners, const Vec3d& p) {
  int leftEdges = 0;  // edges that have the point to their left
  int rightEdges = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3d& a = corners[k];
    const Vec3d& b = corners[(k + 1) % 3];
    const double cross = (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
    leftEdges += cross > 0 ? 1 : 0;
    rightEdges += cross < 0 ? 1 : 0;
    nearest = std::min(nearest, distanceToSegment(p, a, b));
  }
  return leftEdges == 3 || rightEdges == 3 ? 0 : nearest;
}

}  // namespace

// Embree's hierarchy, in single precision relative to an anchor. It only finds triangles; their heights are computed in
// double precision afterwards.
struct SurfaceHeights::Hierarchy {
  RTCDevice device = rtcNewDevice(nullptr);
  RTCScene all = rtcNewScene(device);  // the instances
  std::vector<RTCScene> meshes;        // by index in Scene::meshes; null: no instance of the mesh is added
  Vec3d anchor;                        // m, world frame
  Box bounds;                          // m, world frame

  Hierarchy() { rtcSetSceneFlags(all, RTC_SCENE_FLAG_ROBUST); }
  ~Hierarchy() {
    for (RTCScene mesh : meshes) {
      if (mesh != nullptr) rtcReleaseScene(mesh);
    }
    rtcReleaseScene(all);
    rtcReleaseDevice(device);
  }
  Hierarchy& operator=(Hierarchy&&) = delete;  // neither copied nor moved

  // Returns Embree's scene of a mesh; builds it at the first call for the mesh.
  RTCScene sceneOf(const Mesh& mesh, std::uint32_t index) {
    if (index >= meshes.size()) meshes.resize(index + 1, nullptr);
    if (meshes[index] != nullptr) return meshes[index];
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    // Few rays are traced: a hierarchy that is quickly built saves more time than one that is quickly traced.
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_LOW);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    const auto copy = [&](RTCBufferType type, RTCFormat format, const auto& values) {
      using Item = typename std::decay_t<decltype(values)>::value_type;
      static_assert(sizeof(Item) == 12);
      void* const buffer = rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(Item), values.size());
      if (buffer == nullptr) throw Error("Embree has no memory for the surfaces that objects stand on");
      std::ranges::copy(values, static_cast<Item*>(buffer));
    };
    copy(RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, mesh.positions);
    copy(RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, mesh.triangles);
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_LOW);
    rtcSetGeometryIntersectFilterFunction(geometry, addCrossing);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    isolated([&] { rtcCommitScene(scene); });
    return meshes[index] = scene;
  }

  // Adds the instance with this index. The caller commits `all` afterwards.
  void add(const Scene& scene, std::uint32_t index) {
    const Instance& instance = scene.instances[index];
    const Affine& worldFromMesh = instance.worldFromMesh;
    const Mesh& mesh = scene.meshes[instance.mesh];
    if (bounds.empty()) anchor = worldFromMesh.translation;
    bounds.add(boxAround(worldFromMesh, mesh.bounds()));
    const Affine anchorFromMesh{worldFromMesh.linear, worldFromMesh.translation - anchor};
    attachInstance(device, all, sceneOf(mesh, instance.mesh), {anchorFromMesh}, index);
  }

  // Returns the triangles that the vertical line at (x, y) (m, world frame) crosses, sorted.
  std::vector<Facet> crossedAt(double x, double y) const {
    std::vector<Facet> facets;
    Crossings crossings{.embree = newEmbreeContext(), .facets = &facets};
    RTCRayHit ray = newRay(Vec3d{x, y, bounds.high.z + kMargin} - anchor, {0, 0, -1}, 0,
                           static_cast<float>(bounds.high.z - bounds.low.z + 2 * kMargin));
    intersectOne(all, crossings.embree, ray);
    std::ranges::sort(facets);
    facets.erase(std::ranges::unique(facets).begin(), facets.end());  // Embree may call the filter twice for a hit
    return facets;
  }
};

SurfaceHeights::SurfaceHeights(const Scene& scene, std::function<bool(std::uint16_t)> isNeeded)
    : scene_(scene), isNeeded_(std::move(isNeeded)), hierarchy_(std::make_unique<Hierarchy>()) {}
SurfaceHeights::~SurfaceHeights() = default;

void SurfaceHeights::update() {
  if (addedInstances_ == scene_.instances.size()) return;
  for (; addedInstances_ < scene_.instances.size(); ++addedInstances_) {
    const Instance& instance = scene_.instances[addedInstances_];
    const auto isNeeded = [&](const auto& surface) { return !isNeeded_ || isNeeded_(surface.semantic); };
    if (instance.moves() || std::ranges::none_of(scene_.meshes[instance.mesh].surfaces, isNeeded)) continue;
    hierarchy_->add(scene_, static_cast<std::uint32_t>(addedInstances_));
  }
  isolated([&] { rtcCommitScene(hierarchy_->all); });
}

std::vector<SurfaceHeights::Surface> SurfaceHeights::at(double x, double y) const {
  std::vector<Surface> surfaces;
  if (hierarchy_->bounds.empty()) return surfaces;
  for (const Facet& facet : hierarchy_->crossedAt(x, y)) {
    const Instance& instance = scene_.instances[facet.instance];
    const Mesh& mesh = scene_.meshes[instance.mesh];
    const auto [a, b, c] = cornersOf(instance.worldFromMesh, mesh, facet.triangle);
    const Vec3d normal = cross(b - a, c - a);
    if (!(std::fabs(normal.z) > kVertical * length(normal))) continue;
    const std::uint16_t semantic = mesh.surfaces[mesh.surfaceOf[facet.triangle]].semantic;
    const SemanticClass* const semanticClass = scene_.ontology.find(semantic);
    surfaces.push_back({.height = a.z - (normal.x * (x - a.x) + normal.y * (y - a.y)) / normal.z,
                        .slope = std::acos(std::min(std::fabs(normal.z) / length(normal), 1.0)),
                        .semantic = semantic,
                        .thing = semanticClass != nullptr && semanticClass->thing});
  }
  std::ranges::stable_sort(surfaces, std::greater{}, &Surface::height);
  return surfaces;
}

SurfaceHeights::Area SurfaceHeights::area(const std::vector<std::uint16_t>& classes) const {
  Area facingUp;
  Area allFacets;
  const auto add = [](Area& area, const Facet& facet, double squareMetres) {
    if (!(squareMetres > 0)) return;
    area.facets_.push_back(facet);
    area.sums_.push_back(area.squareMetres() + squareMetres);
  };
  forEachTriangleOf(scene_, classes, addedInstances_,
                    [&](std::uint32_t instance, std::uint32_t triangle, const std::array<Vec3d, 3>& corners) {
                      const bool mirrored = determinant(scene_.instances[instance].worldFromMesh.linear) < 0;
                      const Vec3d normal = cross(corners[1] - corners[0], corners[2] - corners[0]);
                      // The area as seen from above; negative if the triangle faces down.
                      const double squareMetres = normal.z / 2 * (mirrored ? -1 : 1);
                      if (std::fabs(squareMetres) < kVertical * length(normal)) return;
                      add(facingUp, {instance, triangle}, squareMetres);
                      add(allFacets, {instance, triangle}, std::fabs(squareMetres));
                    });
  Area& area = facingUp.facets_.empty() ? allFacets : facingUp;
  area.scene_ = &scene_;
  return std::move(area);
}

Vec3d SurfaceHeights::Area::sample(const std::array<double, 3>& u) const {
  const auto sum = std::upper_bound(sums_.begin(), sums_.end() - 1, u[0] * sums_.back());
  const Facet& facet = facets_[static_cast<std::size_t>(sum - sums_.begin())];
  const Instance& instance = scene_->instances[facet.instance];
  return pointInTriangle(cornersOf(instance.worldFromMesh, scene_->meshes[instance.mesh], facet.triangle), u[1], u[2]);
}

SurfaceDistance::SurfaceDistance(const Scene& scene, const std::vector<std::uint16_t>& classes, double reach)
    : reach_(reach) {
  Box bounds;
  forEachTriangleOf(scene, classes, scene.instances.size(),
                    [&](std::uint32_t, std::uint32_t, const std::array<Vec3d, 3>& corners) {
                      if (triangles_.size() == kMostTriangles) {
                        throw InputError(
                            "distance_from: more than ten million triangles of these classes are placed: "
                            "name a class of which there is less");
                      }
                      triangles_.push_back(corners);
                      for (const Vec3d& corner : corners) bounds.add(corner);
                    });
  if (triangles_.empty()) return;
  low_ = bounds.low;
  const Vec3d size = bounds.high - bounds.low;
  edge_ = std::max({reach, size.x / kMostCellsAlong, size.y / kMostCellsAlong, kLeastCell});
  columns_ = static_cast<std::size_t>(size.x / edge_) + 1;
  rows_ = static_cast<std::size_t>(size.y / edge_) + 1;
  cells_.resize(columns_ * rows_);
  for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
    Box box;
    for (const Vec3d& corner : triangles_[i]) box.add(corner);
    const auto [firstX, firstY] = cellOf(box.low.x, box.low.y);
    const auto [lastX, lastY] = cellOf(box.high.x, box.high.y);
    for (std::size_t x = firstX; x <= lastX; ++x) {
      for (std::size_t y = firstY; y <= lastY; ++y) cells_[x * rows_ + y].push_back(i);
    }
  }
}

std::array<std::size_t, 2> SurfaceDistance::cellOf(double x, double y) const {
  const auto index = [&](double offset, std::size_t count) {
    return static_cast<std::size_t>(std::clamp(offset / edge_, 0.0, static_cast<double>(count - 1)));
  };
  return {index(x - low_.x, columns_), index(y - low_.y, rows_)};
}

double SurfaceDistance::at(double x, double y) const {
  constexpr double kBeyondReach = std::numeric_limits<double>::infinity();
  if (triangles_.empty()) return kBeyondReach;
  // Search all cells that overlap the square about the point with sides of 2 * reach_.
  const auto [firstX, firstY] = cellOf(x - reach_, y - reach_);
  const auto [lastX, lastY] = cellOf(x + reach_, y + reach_);
  double nearest = kBeyondReach;
  for (std::size_t column = firstX; column <= lastX; ++column) {
    for (std::size_t row = firstY; row <= lastY; ++row) {
      for (const std::uint32_t t : cells_[column * rows_ + row]) {
        nearest = std::min(nearest, distanceToTriangle(triangles_[t], {x, y, 0}));
      }
    }
  }
  return nearest <= reach_ ? nearest : kBeyondReach;
}

}  // namespace scanmill
