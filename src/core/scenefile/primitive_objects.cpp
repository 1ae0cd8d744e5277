#include "scenefile/primitive_objects.h"

#include <fmt/format.h>

#include <utility>

#include "scene/primitives.h"
#include "scenefile/concepts.h"

namespace scanmill {
namespace {

constexpr Range kLength{1e-6, 1e6};  // m, limits of the sizes of primitives

Vec3d readSize(const Value& value, std::size_t count) {
  std::vector<double> size = readNumbers(value, "size", kLength);
  if (size.size() != count) {
    throw InputError(value.where, fmt::format("size must be {}, found {} numbers", count == 3 ? "[x, y, z]" : "[x, y]",
                                              size.size()));
  }
  size.resize(3);
  return {size[0], size[1], size[2]};
}

// Reads the keys of a primitive and appends its shape to a mesh. Returns a key that is the same for equal shapes.
std::string appendPrimitive(Fields& f, const std::string& kind, Mesh& mesh) {
  if (kind == "box") {
    const Vec3d size = readSize(f.require("size"), 3);
    appendBox(mesh, 0, {}, size);
    return fmt::format("box {} {} {}", size.x, size.y, size.z);
  }
  if (kind == "plane") {
    const Vec3d size = readSize(f.require("size"), 2);
    const auto cells = static_cast<int>(f.integer("cells", 1, 2048, 1));
    appendPlane(mesh, 0, {}, size.x, size.y, cells);
    return fmt::format("plane {} {} {}", size.x, size.y, cells);
  }
  const double radius = f.number("radius", kLength);
  const double height = kind == "sphere" ? 0 : f.number("height", kLength);
  const auto segments = static_cast<int>(f.integer("segments", 3, 4096, 32));
  if (kind == "sphere") appendSphere(mesh, 0, {}, radius, segments);
  if (kind == "cylinder") appendCylinder(mesh, 0, {}, radius, radius, height, segments);
  if (kind == "cone") appendCylinder(mesh, 0, {}, radius, 0, height, segments);
  if (kind == "capsule") appendCapsule(mesh, 0, {}, radius, height, segments);
  return fmt::format("{} {} {} {}", kind, radius, height, segments);
}

}  // namespace

void PrimitiveObjects::add(Fields& f) {
  const std::string kind = f.choice("primitive", {"box", "sphere", "cylinder", "cone", "plane", "capsule"}, "");
  Mesh mesh;
  mesh.name = kind;
  const std::string shape = appendPrimitive(f, kind, mesh);
  const Value& className = f.require("class");
  const Value& materialName = f.require("material");
  Surface surface;
  const SemanticClass& semantic = requireClass(builder_.ontology(), f.text("class"), className.where);
  surface.semantic = semantic.id;
  surface.object = semantic.thing ? 1 : 0;
  surface.material = builder_.material(f.text("material"), materialName.where);
  surface.labelledBy = className.where;
  const std::string name = f.text("name", kind);
  const Copies copies = placer_.read(f);
  if (!copies.arrangement.materials().empty()) {
    throw InputError(f.require("vary").where, "the key `material` of `vary` is only for objects that are files");
  }
  f.finish();

  const std::string key = fmt::format("primitive {} {} {}", shape, surface.semantic, surface.material);
  mesh.surfaces.push_back(std::move(surface));
  auto shared = meshes_.find(key);
  if (shared == meshes_.end()) shared = meshes_.emplace(key, builder_.addMesh(std::move(mesh))).first;
  placer_.place(std::vector<PlacedMesh>{{shared->second, {}, {}}}, name, copies, f.where());
}

}  // namespace scanmill
