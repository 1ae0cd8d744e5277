#include "pipeline/checks/box_sweep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "scene/triangle_pieces.h"
#include "scene/triangles.h"

namespace scanmill {
namespace {

constexpr double kBoxCell = 2;  // m, side of the cells in which boxes are found

bool overlaps(const Box& a, const Box& b) {
  return a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.y <= b.high.y && b.low.y <= a.high.y &&
         a.low.z <= b.high.z && b.low.z <= a.high.z;
}

// The space that a box covers in one step.
struct SweptBox {
  Affine sweptFromWorld, worldFromSwept;
  Box box;                // m, in a frame halfway between the poses of the step
  Box worldBounds;        // m, in the world's frame
  bool backward = false;  // true: the box travels along -x
};

SweptBox sweptBox(const Box& box, const Pose& start, const Pose& end) {
  const Pose middle = interpolate(start, end, 0.5);
  const Vec3d travel = inverse(middle) * end.translation;
  const Vec3d halfLength{std::fabs(travel.x), std::fabs(travel.y), std::fabs(travel.z)};
  const Box extended{box.low - halfLength, box.high + halfLength};
  return {.sweptFromWorld = toAffine(inverse(middle)),
          .worldFromSwept = toAffine(middle),
          .box = extended,
          .worldBounds = boxAround(toAffine(middle), extended),
          .backward = travel.x < 0};
}

// Finds swept boxes by the horizontal square cells that the boxes overlap.
class BoxCells {
 public:
  explicit BoxCells(const std::vector<SweptBox>& boxes) {
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      bounds_.add(boxes[i].worldBounds);
      forEachCell(boxes[i].worldBounds, [&](std::int64_t cell) { boxesByCell_[cell].push_back(i); });
    }
  }

  // Calls visit(index) for each swept box that may overlap `box` (m, world frame), several times for some boxes.
  void forEachNear(const Box& box, const auto& visit) const {
    if (!overlaps(box, bounds_)) return;
    const Box common{{std::max(box.low.x, bounds_.low.x), std::max(box.low.y, bounds_.low.y), 0},
                     {std::min(box.high.x, bounds_.high.x), std::min(box.high.y, bounds_.high.y), 0}};
    const double cellCount = (common.high.x - common.low.x) * (common.high.y - common.low.y) / (kBoxCell * kBoxCell);
    if (cellCount > static_cast<double>(boxesByCell_.size())) {
      for (const auto& [cell, indices] : boxesByCell_) std::ranges::for_each(indices, visit);
      return;
    }
    forEachCell(common, [&](std::int64_t cell) {
      const auto entry = boxesByCell_.find(cell);
      if (entry != boxesByCell_.end()) std::ranges::for_each(entry->second, visit);
    });
  }

 private:
  static void forEachCell(const Box& box, const auto& visit) {
    const auto index = [](double coordinate) { return static_cast<std::int64_t>(std::floor(coordinate / kBoxCell)); };
    for (std::int64_t x = index(box.low.x); x <= index(box.high.x); ++x) {
      for (std::int64_t y = index(box.low.y); y <= index(box.high.y); ++y) visit(x * (std::int64_t{1} << 32) + y);
    }
  }

  Box bounds_;  // m, world frame, of all swept boxes
  std::unordered_map<std::int64_t, std::vector<std::size_t>> boxesByCell_;
};

// Returns the bounds of the part of a triangle that is inside `box`; an empty box if no part of the triangle is. Points
// in the upper faces of the box count as outside, points in its lower faces as inside.
Box boundsInside(const Box& box, const std::array<Vec3d, 3>& corners) {
  TrianglePiece inside(corners);
  TrianglePiece aboveLow, discarded;
  const std::array<std::pair<double, double>, 3> limits{
      {{box.low.x, box.high.x}, {box.low.y, box.high.y}, {box.low.z, box.high.z}}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    inside.split(axis, limits[axis].first, discarded, aboveLow);
    aboveLow.split(axis, limits[axis].second, inside, discarded);
  }
  if (inside.empty()) return {};
  const auto [x, y, z] = std::array{inside.extent(0), inside.extent(1), inside.extent(2)};
  return {{x[0], y[0], z[0]}, {x[1], y[1], z[1]}};
}

}  // namespace

std::optional<BoxContact> sweepBoxes(
    const Scene& scene, const std::vector<Box>& boxes, const std::vector<std::pair<Pose, Pose>>& steps,
    const std::function<bool(const Instance&, const Surface&, const Vec3d&)>& isObstacle) {
  std::vector<SweptBox> swept;  // box k of step i is at i * boxes.size() + k
  for (const auto& [start, end] : steps) {
    for (const Box& box : boxes) swept.push_back(sweptBox(box, start, end));
  }
  const BoxCells cells(swept);
  std::vector<Box> meshBounds;
  for (const Mesh& mesh : scene.meshes) meshBounds.push_back(mesh.bounds());
  std::optional<BoxContact> first;
  std::vector<std::size_t> nearBoxes;  // swept boxes that may touch the current triangle
  for (const Instance& instance : scene.instances) {
    if (meshBounds[instance.mesh].empty()) continue;
    bool isNear = false;
    const Box bounds = boxAround(instance.worldFromMesh, meshBounds[instance.mesh]);
    cells.forEachNear(bounds, [&](std::size_t k) { isNear = isNear || overlaps(bounds, swept[k].worldBounds); });
    if (!isNear) continue;
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const std::array<Vec3d, 3> corners = cornersOf(instance.worldFromMesh, mesh, t);
      Box triangleBounds;
      for (const Vec3d& corner : corners) triangleBounds.add(corner);
      const Surface& surface = mesh.surfaces[mesh.surfaceOf[t]];
      nearBoxes.clear();
      cells.forEachNear(triangleBounds, [&](std::size_t k) {
        if (overlaps(triangleBounds, swept[k].worldBounds)) nearBoxes.push_back(k);
      });
      const Vec3d normal = cross(corners[1] - corners[0], corners[2] - corners[0]);
      if (nearBoxes.empty() || !isObstacle(instance, surface, normalized(normal))) continue;
      for (const std::size_t k : nearBoxes) {
        const SweptBox& box = swept[k];
        const std::size_t step = k / boxes.size();
        if (first && first->step < step) continue;
        const Affine& m = box.sweptFromWorld;
        const Box inside = boundsInside(box.box, {m * corners[0], m * corners[1], m * corners[2]});
        if (inside.empty()) continue;
        const double x = box.backward ? inside.high.x : inside.low.x;
        const double along = box.backward ? -x : x;
        if (first && std::pair(step, along) >= std::pair(first->step, first->along)) continue;
        first = BoxContact{.instance = &instance,
                           .semantic = surface.semantic,
                           .step = step,
                           .along = along,
                           .position = box.worldFromSwept * Vec3d{x, inside.center().y, inside.center().z}};
      }
    }
  }
  return first;
}

}  // namespace scanmill
