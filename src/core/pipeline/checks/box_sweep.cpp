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

// A box in one step.
struct Step {
  Affine boxFromWorld, worldFromBox;
  Box box;          // in the step's own frame
  Box worldBounds;  // in the world's frame
  bool backward = false;
};

Step stepOf(const Box& box, const Pose& from, const Pose& to) {
  const Pose middle = interpolate(from, to, 0.5);
  Step step{toAffine(inverse(middle)), toAffine(middle), box, {}, false};
  const Vec3d travel = inverse(middle) * to.translation;
  const Vec3d half{std::fabs(travel.x), std::fabs(travel.y), std::fabs(travel.z)};
  step.box.low = box.low - half;
  step.box.high = box.high + half;
  step.backward = travel.x < 0;
  step.worldBounds = boxAround(step.worldFromBox, step.box);
  return step;
}

// The boxes of all steps, by the cells of the ground plan that they overlap.
class StepCells {
 public:
  explicit StepCells(const std::vector<Step>& steps) {
    for (std::size_t i = 0; i < steps.size(); ++i) {
      around_.add(steps[i].worldBounds);
      eachCell(steps[i].worldBounds, [&](std::int64_t cell) { steps_[cell].push_back(i); });
    }
  }

  // Calls visit(index) for all boxes that may be near this one, for some of them more than once.
  void eachNear(const Box& box, const auto& visit) const {
    if (!overlaps(box, around_)) return;
    const Box within{{std::max(box.low.x, around_.low.x), std::max(box.low.y, around_.low.y), 0},
                     {std::min(box.high.x, around_.high.x), std::min(box.high.y, around_.high.y), 0}};
    const double cells = (within.high.x - within.low.x) * (within.high.y - within.low.y) / (kBoxCell * kBoxCell);
    if (cells > static_cast<double>(steps_.size())) {
      for (const auto& [cell, steps] : steps_) std::ranges::for_each(steps, visit);
      return;
    }
    eachCell(within, [&](std::int64_t cell) {
      const auto found = steps_.find(cell);
      if (found != steps_.end()) std::ranges::for_each(found->second, visit);
    });
  }

 private:
  static void eachCell(const Box& box, const auto& visit) {
    const auto cell = [](double at) { return static_cast<std::int64_t>(std::floor(at / kBoxCell)); };
    for (std::int64_t x = cell(box.low.x); x <= cell(box.high.x); ++x) {
      for (std::int64_t y = cell(box.low.y); y <= cell(box.high.y); ++y) visit(x * (std::int64_t{1} << 32) + y);
    }
  }

  Box around_;
  std::unordered_map<std::int64_t, std::vector<std::size_t>> steps_;
};

// Cuts a triangle by the faces of a box. Returns a box around the part inside, which is empty if there is none.
Box insideOf(const Box& box, const std::array<Vec3d, 3>& corners) {
  TrianglePiece inside(corners);
  TrianglePiece below;
  TrianglePiece above;
  const std::array<std::pair<double, double>, 3> ends{
      {{box.low.x, box.high.x}, {box.low.y, box.high.y}, {box.low.z, box.high.z}}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    inside.split(axis, ends[axis].first, below, above);
    above.split(axis, ends[axis].second, below, inside);
    inside = below;
  }
  if (inside.empty()) return {};
  const auto [x, y, z] = std::array{inside.extent(0), inside.extent(1), inside.extent(2)};
  return {{x[0], y[0], z[0]}, {x[1], y[1], z[1]}};
}

}  // namespace

std::optional<BoxContact> sweepBoxes(
    const Scene& scene, const std::vector<Box>& boxes, const std::vector<std::pair<Pose, Pose>>& steps,
    const std::function<bool(const Instance&, const Surface&, const Vec3d&)>& isObstacle) {
  std::vector<Step> swept;  // box k of step i is at i * boxes.size() + k
  swept.reserve(steps.size() * boxes.size());
  for (const auto& [from, to] : steps) {
    for (const Box& box : boxes) swept.push_back(stepOf(box, from, to));
  }
  const StepCells cells(swept);
  std::vector<Box> bounds;
  bounds.reserve(scene.meshes.size());
  for (const Mesh& mesh : scene.meshes) bounds.push_back(mesh.bounds());
  std::optional<BoxContact> first;
  for (const Instance& instance : scene.instances) {
    if (bounds[instance.mesh].empty()) continue;
    bool near = false;
    const Box around = boxAround(instance.worldFromMesh, bounds[instance.mesh]);
    cells.eachNear(around, [&](std::size_t k) { near = near || overlaps(around, swept[k].worldBounds); });
    if (!near) continue;
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const std::array<Vec3d, 3> corners = cornersOf(instance, mesh, static_cast<std::uint32_t>(t));
      Box bounding;
      for (const Vec3d& corner : corners) bounding.add(corner);
      std::optional<bool> obstacle;  // nothing: not asked yet
      const Surface& surface = mesh.surfaces[mesh.surfaceOf[t]];
      cells.eachNear(bounding, [&](std::size_t k) {
        const Step& box = swept[k];
        if (obstacle == false || !overlaps(bounding, box.worldBounds)) return;
        if (!obstacle) {
          obstacle = isObstacle(instance, surface, normalized(cross(corners[1] - corners[0], corners[2] - corners[0])));
        }
        if (!*obstacle) return;
        const std::size_t step = k / boxes.size();
        if (first && first->step < step) return;
        const Affine& f = box.boxFromWorld;
        const Box inside = insideOf(box.box, {f * corners[0], f * corners[1], f * corners[2]});
        if (inside.empty()) return;
        const double x = box.backward ? inside.high.x : inside.low.x;
        const double along = box.backward ? -x : x;
        if (first && std::pair(step, along) >= std::pair(first->step, first->along)) return;
        const Vec3d at = box.worldFromBox * Vec3d{x, inside.center().y, inside.center().z};
        first = BoxContact{&instance, surface.semantic, step, along, at};
      });
    }
  }
  return first;
}

}  // namespace scanmill
