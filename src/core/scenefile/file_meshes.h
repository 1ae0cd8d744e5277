#pragma once

// The meshes of the files that a scene's objects name.

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "assets/asset.h"
#include "scene/builder.h"
#include "scenefile/labelling.h"

namespace scanmill {

// Objects with the same file, options and rules share their meshes.
class FileMeshes {
 public:
  explicit FileMeshes(SceneBuilder& builder) : builder_(builder) {}

  // Throws InputError at `where` for a file that cannot be read, and what addAsset() throws.
  const std::vector<PlacedMesh>& read(const std::filesystem::path& file, const AssetOptions& options,
                                      const Labelling& labelling, const Location& where);

  // The meshes of a clip that plays, over and over, one for every moment of it.
  std::shared_ptr<const Animation> playing(const std::filesystem::path& file, AssetOptions options, Labelling labelling,
                                           const std::string& clip, const Location& where);

 private:
  Asset load(const std::filesystem::path& file, const AssetOptions& options, const Labelling& labelling,
             const Location& where) const;

  SceneBuilder& builder_;
  std::map<std::string, std::vector<PlacedMesh>> meshes_;
  std::map<std::string, std::shared_ptr<const Animation>> animations_;
};

}  // namespace scanmill
