#pragma once

// The parts of the reader that uses the assimp library (assets/meshes/assimp/reader.h).

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "assets/meshes/imported_file.h"

struct aiBone;
struct aiMesh;
struct aiScene;

namespace Assimp {
class IOSystem;
}

namespace scanmill {

// Returns the file access for the importer. It opens only regular files, no pipes or devices, and without
// `allowOutside` only files in the asset's folder and its subfolders. `refused` is set to the message about the first
// file that was refused, and must outlive the result.
std::unique_ptr<Assimp::IOSystem> filesFor(const std::filesystem::path& asset, bool allowOutside, std::string& refused);

// How a material's image is placed by texture coordinates: scaled, turned about (0.5, 0.5) and shifted, in this order
// (aiUVTransform of assimp). The importer's own step, aiProcess_TransformUVCoords, scales about the middle of the
// image.
struct UvPlacement {
  std::uint32_t channel = 0;  // index of the set of texture coordinates
  std::string set;            // its name, which holds in place of the index; empty: it is not known
  Vec2f scale{1, 1}, offset{0, 0};
  float rotation = 0;  // rad, counter-clockwise
  Vec2f apply(const Vec2f& uv) const;
};

// Returns the materials of an assimp scene. Base colours count as linear, since most exporters write linear ones.
// `alphaIsOpacity`: the alpha of a colour is the material's opacity. `placements` receives one entry per material.
std::vector<ImportedMaterial> materialsOf(const aiScene& scene, bool alphaIsOpacity,
                                          std::vector<UvPlacement>& placements);
// Returns the embedded images of an assimp scene. Throws Error if an image has no usable size.
std::vector<ImportedImage> imagesOf(const aiScene& scene);

// Collects the errors that the assimp library meets in files and reads past, as long as the object lives.
struct ImporterLog {
  ImporterLog();
  ~ImporterLog();
  ImporterLog(const ImporterLog&) = delete;
  ImporterLog& operator=(const ImporterLog&) = delete;
  std::vector<std::string> problems;  // the first ones
};

// The vertices of a mesh with a skin, in the asset's frame.
struct SkinnedMesh {
  std::vector<Vec3d> vertices;
  bool mirrored = false;  // true: the joints' transforms mirror
};

// Returns the vertices of a mesh where its joints take them, each by the mean of their transforms, weighted (linear
// blend skinning). `assetFromMesh` returns a joint's transform; nullopt if the file has no node for it, which `leftOut`
// then counts. Vertices without such a joint follow the mesh's node. Returns nullopt if the mesh has no skin, or if all
// joints take it where its node does.
std::optional<SkinnedMesh> skinned(const aiMesh& mesh, const Affine& assetFromNode,
                                   const std::function<std::optional<Affine>(const aiBone&)>& assetFromMesh,
                                   LeftOut& leftOut);

}  // namespace scanmill
