#pragma once

// Objects of a scene file that are shapes: boxes, spheres, cylinders, cones, planes and capsules.

#include <cstdint>
#include <map>
#include <string>

#include "config/fields.h"
#include "scene/builder.h"
#include "scenefile/object_placer.h"

namespace scanmill {

class PrimitiveObjects {
 public:
  PrimitiveObjects(SceneBuilder& builder, ObjectPlacer& placer) : builder_(builder), placer_(placer) {}

  // Reads an object with the key `primitive` and places its copies. Throws InputError with the place in the file.
  void add(Fields& object);

 private:
  SceneBuilder& builder_;
  ObjectPlacer& placer_;
  std::map<std::string, std::uint32_t> meshes_;  // by shape, class and material: the mesh that such objects share
};

}  // namespace scanmill
