#include "scene/scene.h"

#include <algorithm>
#include <cmath>

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

// Uses the corners of each mesh's box and not its vertices, so that a scene with a million copies stays fast. The
// result contains every vertex, and is tight if no mesh is rotated.
Box Scene::bounds() const {
  if (unreduced != nullptr) return unreduced->bounds;
  std::vector<Box> meshBounds;
  meshBounds.reserve(meshes.size());
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
  for (const double z : {box.low.z, box.high.z}) {
    for (const double y : {box.low.y, box.high.y}) {
      for (const double x : {box.low.x, box.high.x}) bounds.add(transform * Vec3d{x, y, z});
    }
  }
  return bounds;
}

}  // namespace scanmill
