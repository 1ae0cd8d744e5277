#include "python/array_part.h"

#include <fmt/format.h>

#include <unordered_set>

#include "base/error.h"

namespace scanmill {
namespace {

Surface surfaceOf(SceneBuilder& builder, const ArraySurface& given) {
  Surface surface = builder.surface(given.className, given.material);
  if (given.object >= 0) surface.object = static_cast<std::uint32_t>(given.object);
  if (given.reflectance >= 0) {
    Material material = builder.library().require(given.material, {});
    material.reflectance = material.least = material.greatest = given.reflectance;
    material.source = "given as an array";
    surface.material = builder.addMaterial(material);
  }
  return surface;
}

}  // namespace

void addParts(SceneBuilder& builder, const std::vector<ArrayPart>& parts) {
  std::unordered_set<std::string> names;
  for (const Instance& i : builder.soFar().instances) names.insert(i.name);
  for (const ArrayPart& part : parts) {
    if (!names.insert(part.name).second) {
      throw InputError(fmt::format("part '{}': the scene has an object of this name: take another name", part.name));
    }
    try {
      Mesh mesh = part.mesh;
      mesh.name = part.name;
      for (const ArraySurface& given : part.surfaces) mesh.surfaces.push_back(surfaceOf(builder, given));
      const std::uint32_t added = builder.addMesh(std::move(mesh));
      if (builder.soFar().meshes[added].triangles.empty()) throw InputError("none of its triangles has an area");
      builder.place(added, part.worldFromMesh, part.name);
    } catch (const InputError& e) {
      throw InputError(fmt::format("part '{}': {}", part.name, e.what()));
    }
  }
}

}  // namespace scanmill
