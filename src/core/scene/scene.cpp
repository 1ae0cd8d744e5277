#include "scene/scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/path.h"
#include "scene/placements.h"
#include "scene/triangles.h"

namespace scanmill {
std::uint32_t Animation::at(double time) const {
  const double periods = std::clamp(time, 0.0, until) / period;
  const auto count = static_cast<double>(meshes.size());
  const double index = std::round((periods - std::floor(periods)) * count);
  return meshes[index < count ? static_cast<std::size_t>(index) : 0];
}

Affine Instance::worldFromMeshAt(double time) const {
  if (movement == nullptr) return worldFromMesh;
  return toAffine(movement->at(time) * inverse(movement->at(0))) * worldFromMesh;
}

bool Scene::moves() const {
  return placeable || std::ranges::any_of(instances, [](const Instance& i) { return i.moves(); });
}

void standStill(Scene& scene, double time) {
  for (Instance& i : scene.instances) {
    i.worldFromMesh = i.worldFromMeshAt(time);
    i.mesh = i.meshAt(time);
    i.movement = nullptr;
    i.animation = nullptr;
  }
}

std::uint64_t Scene::triangles() const {
  std::uint64_t count = 0;
  for (const Mesh& mesh : meshes) count += mesh.triangles.size();
  return count;
}

std::uint64_t Scene::placedTriangles() const {
  std::uint64_t count = 0;
  for (const Instance& instance : instances) count += meshes[instance.mesh].triangles.size();
  return count;
}

std::uint32_t Scene::things() const {
  std::uint32_t largestId = 0;  // several instances may share an id
  for (const Instance& instance : instances) {
    const std::uint32_t objects = meshes[instance.mesh].objects;
    if (objects > 0) largestId = std::max(largestId, instance.firstInstanceId + objects - 1);
  }
  return largestId;
}

std::vector<std::uint64_t> Scene::copies() const {
  std::vector<std::uint64_t> counts(meshes.size());
  for (const Instance& instance : instances) ++counts[instance.mesh];
  return counts;
}

// Transforms the corners of each mesh's box instead of all vertices, which is fast even for a million copies. The
// result contains every vertex, and is tight if no mesh is rotated.
Box Scene::bounds() const {
  if (unreduced != nullptr) return unreduced->bounds;
  std::vector<Box> meshBounds;
  for (const Mesh& mesh : meshes) meshBounds.push_back(mesh.bounds());
  Box box;
  for (const Instance& instance : instances) {
    const Box& meshBox = meshBounds[instance.mesh];
    if (!meshBox.empty()) box.add(boxAround(instance.worldFromMesh, meshBox));
  }
  return box;
}

Box boxAround(const Affine& transform, const Box& box) {
  Box bounds;
  for (const Vec3d& corner : box.corners()) bounds.add(transform * corner);
  return bounds;
}

namespace {

// Corners are treated as collinear if twice the triangle's area, divided by the product of the lengths of two sides, is
// at most this limit: double arithmetic on float32 coordinates cannot tell whether such corners are collinear. The
// thinnest triangle that float32 can represent is far above the limit.
constexpr double kCollinear = 1e-14;

bool isDegenerate(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d ab = b - a;
  const Vec3d ac = c - a;
  const Vec3d normal = cross(ab, ac);
  // Compares squares first, since nearly all triangles then need no square root. kRounding exceeds the rounding errors.
  constexpr double kRounding = 1.001;
  if (dot(normal, normal) > kRounding * kCollinear * kCollinear * dot(ab, ab) * dot(ac, ac)) return false;
  return !(length(normal) > kCollinear * length(ab) * length(ac));
}

}  // namespace

Dropped& Dropped::operator+=(const Dropped& o) {
  nonFinite += o.nonFinite;
  degenerate += o.degenerate;
  outOfRange += o.outOfRange;
  return *this;
}

// Ignores vertices that no triangle uses, since clean() leaves zeroed vertices behind. For speed, loads four floats per
// vertex, the fourth of which belongs to the next vertex and is ignored, and keeps separate bounds of the first, second
// and third corners, which the CPU can update in parallel.
Box Mesh::bounds() const {
  typedef float Floats __attribute__((vector_size(16)));
  if (triangles.empty()) return {};
  const std::size_t last = positions.size() - 1;
  const auto load = [&](std::uint32_t vertex) {
    const Vec3f& position = positions[vertex];
    if (vertex == last) return Floats{position.x, position.y, position.z, 0};
    Floats floats;
    std::memcpy(&floats, &position, sizeof floats);
    return floats;
  };
  std::array<Floats, 3> low;  // by corner of the triangles
  low.fill(Floats{INFINITY, INFINITY, INFINITY, INFINITY});
  std::array<Floats, 3> high;
  high.fill(-low[0]);
  for (const Triangle& t : triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Floats p = load(t[k]);
      low[k] = p < low[k] ? p : low[k];
      high[k] = p > high[k] ? p : high[k];
    }
  }
  Box box;
  for (std::size_t k = 0; k < 3; ++k) {
    box.add(Vec3d{low[k][0], low[k][1], low[k][2]});
    box.add(Vec3d{high[k][0], high[k][1], high[k][2]});
  }
  return box;
}

bool canBeTraced(const Triangle& triangle, const std::vector<Vec3f>& positions, Dropped& dropped) {
  if (std::ranges::any_of(triangle, [&](std::uint32_t corner) { return corner >= positions.size(); })) {
    ++dropped.outOfRange;
    return false;
  }
  const Vec3f& a = positions[triangle[0]];
  const Vec3f& b = positions[triangle[1]];
  const Vec3f& c = positions[triangle[2]];
  if (!isFinite(a) || !isFinite(b) || !isFinite(c)) {
    ++dropped.nonFinite;
    return false;
  }
  if (isDegenerate(Vec3d(a), Vec3d(b), Vec3d(c))) {
    ++dropped.degenerate;
    return false;
  }
  return true;
}

Dropped clean(Mesh& mesh) {
  Dropped dropped;
  keepTriangles(mesh, [&](std::size_t t) { return canBeTraced(mesh.triangles[t], mesh.positions, dropped); });
  for (Vec3f& p : mesh.positions) {
    if (!isFinite(p)) p = {};
  }
  return dropped;
}

Movement::Movement(const Vec3d& velocity) : velocity_(velocity) {}

Movement::Movement(std::shared_ptr<const Path> path, double start, double speed) : path_(std::move(path)) {
  interval_ = std::max(path_->length() - start, 0.0) / speed;
  travelled_ = {start};
  if (interval_ > 0) travelled_.push_back(path_->length());
}

Movement::Movement(std::shared_ptr<const Path> path, std::vector<double> travelled, double interval)
    : path_(std::move(path)), travelled_(std::move(travelled)), interval_(interval) {}

Pose Movement::at(double time) const {
  const double t = std::max(time, 0.0);
  if (path_ == nullptr) return {{}, velocity_ * t};
  const double steps = t / interval_;
  if (!(steps < static_cast<double>(travelled_.size() - 1))) return path_->pose(travelled_.back());
  const auto step = static_cast<std::size_t>(steps);
  const double fraction = steps - static_cast<double>(step);
  return path_->pose(travelled_[step] + (travelled_[step + 1] - travelled_[step]) * fraction);
}

bool Movement::moves() const {
  return path_ == nullptr ? length(velocity_) > 0 : travelled_.back() != travelled_.front();
}

Affine RigidMotion::at(double seconds) const {
  if (!moves()) return worldFromMesh;
  Affine placed = worldFromMesh;
  const double rate = length(turning);
  if (rate > 0) {
    const double halfAngle = rate * seconds / 2;
    const Vec3d quaternionVector = turning * (std::sin(halfAngle) / rate);
    placed.linear =
        toMatrix(Quat{std::cos(halfAngle), quaternionVector.x, quaternionVector.y, quaternionVector.z}) * placed.linear;
  }
  placed.translation += velocity * seconds;
  return placed;
}

const RigidMotion* Placements::find(std::uint32_t instance) const {
  const auto entry = placed_.find(instance);
  return entry == placed_.end() ? nullptr : &entry->second;
}

Affine worldFromMeshAt(const Instance& instance, std::uint32_t index, const Placements* placed, double time) {
  const RigidMotion* const placement = placed == nullptr ? nullptr : placed->find(index);
  return placement == nullptr ? instance.worldFromMeshAt(time) : placed->worldFromMeshAt(*placement, time);
}

Affine rigidPartOf(const Affine& transform) {
  const Vec3d x = normalized(transform.linear.x);
  const Vec3d z = normalized(cross(x, transform.linear.y));
  return {{x, cross(z, x), z}, transform.translation};
}

}  // namespace scanmill
