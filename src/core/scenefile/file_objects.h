#pragma once

// Objects of a scene file that are files: 3D models, worlds of robot simulators, point clouds, rasters of heights.
//
// A part of an asset gets its class from the first of these that matches and has a class: the object's rules in their
// order, the object's class, the scene's rules in their order. Its material is found in the same way. An object's class
// therefore overrides the classes of all the scene's rules; an object overrides their materials only if it has a
// material too.

#include <array>
#include <filesystem>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "assets/asset.h"
#include "config/fields.h"
#include "scene/builder.h"
#include "scenefile/labelling.h"
#include "scenefile/object_placer.h"
#include "scenefile/rules.h"

namespace scanmill {

// A file, how it is read, and how its triangles are labelled.
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
  const std::vector<PlacedMesh>& read(const LabelledFile& labelled, const Location& where);

  // Warns, once for all files, if a survey is placed at the position of an earlier one and does not fit it: their
  // coordinate systems differ, or one is in degrees and lies around its own middle. The file was read by read().
  void compareSurveys(const LabelledFile& labelled, const Vec3d& position, const Location& where);

  // Returns a clip of a file as a looping animation that has one mesh per sampled moment.
  std::shared_ptr<const Animation> playing(LabelledFile labelled, const std::string& clip, const Location& where);

 private:
  struct Survey {
    std::filesystem::path file;
    std::string system;      // its coordinate system, see Asset::system
    bool ownMiddle = false;  // see Asset::ownMiddle
    Vec3d origin;
  };
  struct Entry {
    LabelledFile labelled;
    std::vector<PlacedMesh> meshes = {};  // empty: not loaded
    std::optional<Survey> survey = {};
    std::shared_ptr<const Animation> animation = nullptr;  // of the clip; null: not loaded
  };

  Entry& entryOf(const LabelledFile& labelled);
  Asset load(const LabelledFile& labelled, const Location& where) const;

  SceneBuilder& builder_;
  std::map<std::filesystem::path, std::list<Entry>> cache_;      // by file
  std::map<std::array<double, 2>, const Survey*> firstSurveys_;  // the first survey, by x and y of its position
  bool misfitReported_ = false;
};

class FileObjects {
 public:
  // `textures`: see SceneOptions::textures. `assetFolder`: the folder where relative paths start; empty: the folder of
  // the scene file. Throws InputError for a rule with an unknown class or material.
  FileObjects(SceneBuilder& builder, ObjectPlacer& placer, std::vector<Rule> sceneRules,
              std::filesystem::path assetFolder, bool textures);

  // Reads an object with the key `file` and places its copies. Throws InputError with the place in the scene file.
  void add(Fields& object);

 private:
  using NamedFile = std::pair<std::filesystem::path, std::string>;  // the path, and the name as the scene writes it
  std::vector<NamedFile> filesOf(Fields& object) const;
  AssetOptions assetOptions(Fields& object) const;
  std::vector<Rule> rulesOf(Fields& object) const;
  std::vector<LabelledFile> variantsOf(Fields& object, const std::vector<NamedFile>& files,
                                       const std::vector<std::string>& materials) const;
  void checkNames(const std::vector<Rule>& rules) const;
  std::filesystem::path assetPath(const std::string& name, const Value& value) const;

  SceneBuilder& builder_;
  ObjectPlacer& placer_;
  std::vector<Rule> sceneRules_;
  std::filesystem::path assetFolder_;
  bool textures_;
  FileMeshes meshes_;
};

}  // namespace scanmill
