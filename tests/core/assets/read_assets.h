#pragma once

// Helpers of the tests of all kinds of assets.

#include <string>

#include "assets/asset.h"
#include "base/error.h"
#include "scene/scene.h"
#include "scenefile/scene_file.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {

inline std::size_t trianglesOf(const Asset& asset) {
  std::size_t count = 0;
  for (const AssetPart& part : asset.parts) count += part.triangles.size();
  return count;
}

// Reads a scene with the classes and materials of labels/. `rest`: the YAML after these, from its keys on.
inline Scene sceneOf(const TemporaryFolder& folder, const std::string& rest) {
  const std::string labels = SCANMILL_SOURCE_DIR "/labels/";
  return readScene(folder.write("scene.yaml", "ontology: " + labels + "scanmill.yaml\nmaterials: " + labels +
                                                  "materials.yaml\n" + rest),
                   {});
}

}  // namespace scanmill
