#pragma once

// Loads the meshes of the files that a scene's objects name.

#include <array>
#include <filesystem>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "assets/asset.h"
#include "config/fields.h"
#include "scene/builder.h"
#include "scenefile/labelling.h"

namespace scanmill {

struct LabelledFile {
  std::filesystem::path file;
  AssetOptions asset;
  Labelling labelling;
};

// Reads the keys `points` and `heights` of an object whose file is a point cloud or a height raster. Throws InputError,
// also if the file is not what a key is for.
void readSurveyOptions(Fields& object, const std::filesystem::path& file, AssetOptions& asset);

// Loads each combination of file, options and rules once: objects with the same combination share their meshes.
class FileMeshes {
 public:
  explicit FileMeshes(SceneBuilder& builder) : builder_(builder) {}

  // Returns the meshes of a file. Throws InputError at `where` if the file cannot be read, and the errors of
  // addAsset().
  const std::vector<PlacedMesh>& read(const LabelledFile& from, const Location& where);

  // Warns, once for all files, if a survey is placed at the position of an earlier one and does not fit it: their
  // coordinate systems differ, or one is in degrees and lies around its own middle. The file was read by read().
  void compareSurveys(const LabelledFile& from, const Vec3d& position, const Location& where);

  // Returns a clip of a file as a looping animation that has one mesh per sampled moment.
  std::shared_ptr<const Animation> playing(LabelledFile from, const std::string& clip, const Location& where);

 private:
  struct Survey {
    std::filesystem::path file;
    std::string system;
    bool ownMiddle = false;
    Vec3d origin;
  };
  struct Known {
    LabelledFile from;
    std::vector<PlacedMesh> meshes;  // empty: not loaded
    std::optional<Survey> survey;
    std::shared_ptr<const Animation> animation;  // of the clip; null: not loaded
  };

  Known& knownOf(const LabelledFile& from);
  Asset load(const LabelledFile& from, const Location& where) const;

  SceneBuilder& builder_;
  std::map<std::filesystem::path, std::list<Known>> known_;  // by file
  std::map<std::array<double, 2>, const Survey*> firsts_;    // the first survey, by x and y of its position
  bool misfitReported_ = false;
};

}  // namespace scanmill
