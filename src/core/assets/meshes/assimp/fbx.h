#pragma once

// Searches FBX files for facts that the assimp library does not report.

#include <filesystem>
#include <map>
#include <set>
#include <string>

#include "base/format_support.h"

namespace scanmill {

const FormatSupport& fbxFormat();

// Name of the metadata in which assimp reports whether an object is visible, in files that readFbx() has changed.
constexpr const char* kFbxVisibility = "VisibilityFlag";

struct FbxImages {
  std::set<std::string> clamped;              // names of images that do not repeat
  std::map<std::string, std::string> uvSets;  // names of sets of texture coordinates, by names of images; empty: none
};

// Returns the bytes of an FBX file (7.x, text or binary) with changes for assimp: properties "Visibility", whose type
// it does not know, become numbers named kFbxVisibility; rotations that are not active and coarser levels of detail are
// cut off. Counts animations, morph targets that are not at rest, curved surfaces, objects that get the materials of
// another one, and uses of images that assimp does not know. `images` receives how the file uses its images.
std::string readFbx(const std::filesystem::path& file, LeftOut& leftOut, FbxImages& images);

}  // namespace scanmill
