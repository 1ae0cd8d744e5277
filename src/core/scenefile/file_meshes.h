#pragma once

// Loads the meshes of the files that a scene's objects name.

#include <array>
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

  // Warns, once for all files, if a survey is placed at the position of an earlier one and does not fit it: their
  // coordinate systems differ, or one is in degrees and lies around its own middle. The file was read by read().
  void compareSurveys(const std::filesystem::path& file, const AssetOptions& options, const Labelling& labelling,
                      const Vec3d& position, const Location& where);

  // Returns a clip of a file as a looping animation that has one mesh per sampled moment.
  std::shared_ptr<const Animation> playing(const std::filesystem::path& file, AssetOptions options, Labelling labelling,
                                           const std::string& clip, const Location& where);

 private:
  Asset load(const std::filesystem::path& file, const AssetOptions& options, const Labelling& labelling,
             const Location& where) const;

  struct Survey {
    std::filesystem::path file;
    std::string system;
    bool ownMiddle = false;
    Vec3d origin;
  };

  SceneBuilder& builder_;
  std::map<std::string, std::vector<PlacedMesh>> meshes_;
  std::map<std::string, Survey> surveys_;                  // with the keys of meshes_
  std::map<std::array<double, 2>, const Survey*> firsts_;  // the first survey, by x and y of its position
  bool misfitTold_ = false;
  std::map<std::string, std::shared_ptr<const Animation>> animations_;
};

}  // namespace scanmill
