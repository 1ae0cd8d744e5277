#include "study/repeatability/repeatability_object.h"

#include <fmt/core.h>

#include <algorithm>

#include "base/error.h"
#include "config/fields.h"
#include "evaluate/beam_errors.h"

namespace scanmill {

BoxedThing::BoxedThing(std::string name, const Affine& worldFromMesh, const Box& box)
    : name_(std::move(name)), worldFromMesh_(worldFromMesh), meshFromWorld_(inverse(worldFromMesh)), box_(box) {}

double BoxedThing::distance(const Vec3d& point) const {
  const Vec3d p = meshFromWorld_ * point;
  const Vec3d inside{std::clamp(p.x, box_.low.x, box_.high.x), std::clamp(p.y, box_.low.y, box_.high.y),
                     std::clamp(p.z, box_.low.z, box_.high.z)};
  return length(worldFromMesh_.linear * (p - inside));
}

std::vector<BoxedThing> boxedThings(const Scene& scene) {
  std::vector<std::vector<Box>> boxes;  // indexed by mesh and object
  for (const Mesh& mesh : scene.meshes) boxes.push_back(objectBoxes(mesh));
  std::vector<BoxedThing> things;
  for (const Instance& instance : scene.instances) {
    for (const Box& box : boxes[instance.mesh]) {
      if (!box.empty()) things.emplace_back(instance.name, instance.worldFromMesh, box);
    }
  }
  return things;
}

const BoxedThing& thingToWatch(const std::vector<BoxedThing>& things, const std::string& name, const Vec3d& from,
                               const Scene& scene) {
  const BoxedThing* nearestThing = nullptr;
  double least = 0;
  std::vector<std::string> names;
  for (const BoxedThing& thing : things) {
    if (std::ranges::find(names, thing.name()) == names.end()) names.push_back(thing.name());
    if (!name.empty() && thing.name() != name) continue;
    const double distance = thing.distance(from);
    if (nearestThing != nullptr && distance >= least) continue;
    nearestThing = &thing;
    least = distance;
  }
  if (nearestThing != nullptr) return *nearestThing;
  if (things.empty()) {
    throw InputError({scene.file.string()},
                     "has no thing to scan repeatedly: give an object a class of things, such as `object` or `car`");
  }
  throw InputError({scene.file.string()}, fmt::format("has no thing '{}'{}", name, suggestion(name, names)));
}

}  // namespace scanmill
