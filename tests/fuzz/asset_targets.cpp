// 3D files. Those of assimp go through its child process, so that 'assets' is slow.

#include <algorithm>
#include <array>

#include "assets/asset.h"
#include "assets/meshes/imported_file.h"
#include "base/error.h"
#include "formats/cloud_file.h"
#include "formats/readers.h"
#include "images/images.h"
#include "tests/fuzz/target.h"

namespace scanmill {
namespace {

const AddFuzzTarget kGltf("gltf", [](std::string_view bytes) {
  readAsset(inputFile(bytes, bytes.starts_with("glTF") ? ".glb" : bytes.starts_with("b3dm") ? ".b3dm" : ".gltf"), {});
});

const AddFuzzTarget kAssets("assets", [](std::string_view bytes) {
  static constexpr std::array<const char*, 5> kKinds{".obj", ".stl", ".ply", ".dae", ".ac"};
  const std::string kind = kKinds[kindOf(bytes, kKinds.size())];
  readAsset(inputFile(bytes, kind), {});
});

// An OBJ file, and from the first "newmtl" on the library that stands beside it.
const AddFuzzTarget kObj("obj", [](std::string_view bytes) {
  const std::size_t library = std::min(bytes.find("newmtl"), bytes.size());
  inputFile(bytes.substr(library), ".mtl");
  readObjMesh(inputFile(bytes.substr(0, library), ".obj"), {});
});

const AddFuzzTarget kWorlds("worlds", [](std::string_view bytes) {
  static constexpr std::array<const char*, 3> kKinds{".sdf", ".urdf", ".json"};
  const std::string kind = kKinds[kindOf(bytes, kKinds.size())];
  readAsset(inputFile(bytes, kind), {});
});

const AddFuzzTarget kClouds("clouds", [](std::string_view bytes) {
  if (bytes.starts_with("LASF")) {
    readLas(bytes, "input.las");
  } else {
    const auto file = inputFile(bytes, ".ply");
    if (isCloud(file)) readCloud(file);
  }
});

const AddFuzzTarget kImages("images", [](std::string_view bytes) { decodeImage(bytes, "input.tga"); });

}  // namespace
}  // namespace scanmill
