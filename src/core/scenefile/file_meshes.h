#pragma once

// Loads the meshes of the files that a scene's objects name.

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "assets/asset.h"
#include "scene/builder.h"
#include "scenefile/labelling.h"

namespace scanmill {

// Loads each combination of file, options and rules once: objects with the same combination share their meshes.
class FileMeshes {
 public:
  explicit FileMeshes(SceneBuilder& builder) : builder_(builder) {}

  // Returns the meshes of a file. Throws InputError at `where` if the file cannot be read, and the errors of
  // addAsset().
  const std::vector<PlacedMesh>& read(const std::filesystem::path& file, const AssetOptions& options,
                                      const Labelling& labelling, const Location& where);

  // Returns a clip of a file as a looping animation that has one mesh per sampled moment.
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
