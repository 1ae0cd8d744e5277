#pragma once

// Objects of a scene file that are files: 3D models, worlds of robot simulators, point clouds, rasters of heights.
//
// A part of an asset gets its class from the first of these that matches and has a class: the object's rules in their
// order, the object's class, the scene's rules in their order. Its material is found in the same way. An object's class
// therefore overrides the classes of all the scene's rules; an object overrides their materials only if it has a
// material too.

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "scenefile/file_meshes.h"
#include "scenefile/object_placer.h"
#include "scenefile/rules.h"

namespace scanmill {

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
