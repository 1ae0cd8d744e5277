#include "scene/surface_heights.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace scanmill {
namespace {

constexpr double kMostCells = 4e6;

double areaFromAbove(const std::array<Vec3d, 3>& c) {
  return std::fabs((c[1].x - c[0].x) * (c[2].y - c[0].y) - (c[2].x - c[0].x) * (c[1].y - c[0].y)) / 2;
}

}  // namespace

SurfaceHeights::SurfaceHeights(const Scene& scene) {
  for (const Instance& instance : scene.instances) {
    if (instance.moves()) continue;
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      Facet facet;
      for (int k = 0; k < 3; ++k)
        facet.corner[k] = instance.worldFromMesh * Vec3d(mesh.positions[mesh.triangles[t][k]]);
      if (!(areaFromAbove(facet.corner) > 0)) continue;
      facet.semantic = mesh.surfaces[mesh.surfaceOf[t]].semantic;
      const SemanticClass* const own = scene.ontology.find(facet.semantic);
      facet.thing = own != nullptr && own->thing;
      for (const Vec3d& c : facet.corner) bounds_.add(c);
      facets_.push_back(facet);
    }
  }
  if (facets_.empty()) return;
  const Vec3d size = bounds_.high - bounds_.low;
  const double cells = std::min(static_cast<double>(facets_.size()), kMostCells);
  cell_ = std::max(std::sqrt(size.x * size.y / cells), 1e-3);
  cell_ = std::max({cell_, size.x / kMostCells, size.y / kMostCells});
  across_ = static_cast<std::size_t>(size.x / cell_) + 1;
  up_ = static_cast<std::size_t>(size.y / cell_) + 1;
  // Twice: counted, then filed.
  begin_.assign(across_ * up_ + 1, 0);
  const auto forCells = [&](const Facet& f, const auto& visit) {
    Box box;
    for (const Vec3d& c : f.corner) box.add(c);
    const auto column = [&](double x) {
      return std::min(static_cast<std::size_t>((x - bounds_.low.x) / cell_), across_ - 1);
    };
    const auto row = [&](double y) { return std::min(static_cast<std::size_t>((y - bounds_.low.y) / cell_), up_ - 1); };
    for (std::size_t j = row(box.low.y); j <= row(box.high.y); ++j) {
      for (std::size_t i = column(box.low.x); i <= column(box.high.x); ++i) visit(j * across_ + i);
    }
  };
  for (const Facet& f : facets_) forCells(f, [&](std::size_t cell) { ++begin_[cell + 1]; });
  for (std::size_t c = 1; c < begin_.size(); ++c) begin_[c] += begin_[c - 1];
  inCell_.resize(begin_.back());
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  for (std::uint32_t f = 0; f < facets_.size(); ++f) {
    forCells(facets_[f], [&](std::size_t cell) { inCell_[next[cell]++] = f; });
  }
}

std::vector<SurfaceHeights::Surface> SurfaceHeights::at(double x, double y) const {
  std::vector<Surface> found;
  if (facets_.empty() || x < bounds_.low.x || y < bounds_.low.y || x > bounds_.high.x || y > bounds_.high.y)
    return found;
  const auto column = std::min(static_cast<std::size_t>((x - bounds_.low.x) / cell_), across_ - 1);
  const auto row = std::min(static_cast<std::size_t>((y - bounds_.low.y) / cell_), up_ - 1);
  const std::size_t cell = row * across_ + column;
  for (std::uint32_t k = begin_[cell]; k < begin_[cell + 1]; ++k) {
    const Facet& f = facets_[inCell_[k]];
    const auto& [a, b, c] = f.corner;
    const double whole = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    const double v = ((x - a.x) * (c.y - a.y) - (c.x - a.x) * (y - a.y)) / whole;
    const double w = ((b.x - a.x) * (y - a.y) - (x - a.x) * (b.y - a.y)) / whole;
    constexpr double kEdge = 1e-9;  // so that no place falls between two triangles
    if (v < -kEdge || w < -kEdge || v + w > 1 + kEdge) continue;
    const Vec3d square = cross(b - a, c - a);
    found.push_back({a.z + v * (b.z - a.z) + w * (c.z - a.z),
                     std::acos(std::min(std::fabs(square.z) / length(square), 1.0)), f.semantic, f.thing});
  }
  std::stable_sort(found.begin(), found.end(), [](const Surface& p, const Surface& q) { return p.height > q.height; });
  return found;
}

SurfaceHeights::Area SurfaceHeights::area(const std::vector<std::uint16_t>& classes) const {
  Area area;
  double sum = 0;
  for (const Facet& f : facets_) {
    if (std::find(classes.begin(), classes.end(), f.semantic) == classes.end()) continue;
    sum += areaFromAbove(f.corner);
    area.triangles_.push_back(f.corner);
    area.sums_.push_back(sum);
  }
  return area;
}

Vec3d SurfaceHeights::Area::place(const std::array<double, 3>& u) const {
  const auto found = std::upper_bound(sums_.begin(), sums_.end() - 1, u[0] * sums_.back());
  const std::array<Vec3d, 3>& t = triangles_[static_cast<std::size_t>(found - sums_.begin())];
  // Shirley's mapping of the square onto a triangle.
  const double root = std::sqrt(u[1]);
  return t[0] * (1 - root) + t[1] * (root * (1 - u[2])) + t[2] * (root * u[2]);
}

}  // namespace scanmill
