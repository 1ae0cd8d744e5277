#pragma once

// A square road about a lawn, with a wall across it, a parked car and a bridge.

#include <fmt/core.h>

#include <string>

#include "scene/scene.h"
#include "scenefile/scene_file.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {

// The road is 8 m wide, its middle a square from -40 to 40 in x and y; z is 0. A car of 4 m x 2 m stands at [0, -42]
// on its outer side, a bridge crosses at x = 20, 6 m above the road. `more`: further objects.
inline std::string roadScene(const std::string& more = "") {
  return fmt::format(R"(ontology: {0}/labels/scanmill.yaml
materials: {0}/labels/materials.yaml
objects:
  - {{name: lawn, primitive: plane, size: [200, 200], class: terrain, material: grass, position: [0, 0, -0.1]}}
  - {{name: south, primitive: plane, size: [88, 8], class: road, material: asphalt, position: [0, -40, 0]}}
  - {{name: north, primitive: plane, size: [88, 8], class: road, material: asphalt, position: [0, 40, 0]}}
  - {{name: west, primitive: plane, size: [8, 72], class: road, material: asphalt, position: [-40, 0, 0]}}
  - {{name: east, primitive: plane, size: [8, 72], class: road, material: asphalt, position: [40, 0, 0]}}
  - {{name: parked, primitive: box, size: [4, 2, 1.5], class: car, material: painted_metal, position: [0, -42.5, 0.75]}}
  - {{name: bridge, primitive: box, size: [4, 120, 0.5], class: structure, material: concrete, position: [20, 0, 5.75]}}
{1})",
                     SCANMILL_SOURCE_DIR, more);
}

inline Scene readRoadScene(const TemporaryFolder& folder, const std::string& more = "") {
  return readScene(folder.write("roads.yaml", roadScene(more)), {});
}

}  // namespace scanmill
