#pragma once

// Objects of a scene file that are files: 3D models, worlds of robot simulators, point clouds, rasters of heights.
//
// The class of an asset's part comes from the first of these that matches the part and states a class: the object's
// rules, in order; the object's key `class`; the scene's rules, in order. The material is found in the same way. An
// object's key `class` therefore overrides the classes of all the scene's rules, but it overrides their materials only
// if the object also has the key `material`.

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

// Loads each combination of file, options and rules once: objects with the same combination share their meshes.
class FileMeshes {
 public:
  explicit FileMeshes(SceneBuilder& builder) : builder_(builder) {}

  // Returns the meshes of a file. Throws InputError at `where` if the file cannot be read, and as addAsset() does.
  const std::vector<PlacedMesh>& read(const LabelledFile& labelled, const Location& where);

  // Warns if a survey does not fit an earlier survey at the same position: their coordinate systems differ, or one has
  // coordinates relative to its own centre. Warns at most once for all files. read() must have read the file before.
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
    std::shared_ptr<const Animation> animation = nullptr;  // animation of the clip; null: not loaded
  };

  Entry& entryOf(const LabelledFile& labelled);
  Asset load(const LabelledFile& labelled, const Location& where) const;

  SceneBuilder& builder_;
  std::map<std::filesystem::path, std::list<Entry>> cache_;      // by file
  std::map<std::array<double, 2>, const Survey*> firstSurveys_;  // by x and y of a position: the first survey there
  bool misfitReported_ = false;
};

// Reads an object's key `joints`: the positions of joints (rad or m) by their names.
std::map<std::string, double> readJoints(Fields& object);

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
