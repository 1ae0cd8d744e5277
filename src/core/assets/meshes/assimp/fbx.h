#pragma once

// Searches FBX files for facts that the assimp library does not report.

#include <filesystem>
#include <set>
#include <string>

#include "base/format_support.h"

namespace scanmill {

const FormatSupport& fbxFormat();

// Name of the metadata in which assimp reports whether an object is visible, in files that readFbx() has changed.
constexpr const char* kFbxVisibility = "VisibilityFlag";

// Returns the bytes of an FBX file (7.x, text or binary) with changes for assimp: properties "Visibility", whose type
// it does not know, become numbers named kFbxVisibility; rotations that are not active and coarser levels of detail are
// cut off. Counts animations, morph targets that are not at rest, curved surfaces, and uses of images that assimp does
// not know. `clamped` receives the names of images that do not repeat.
std::string readFbx(const std::filesystem::path& file, LeftOut& leftOut, std::set<std::string>& clamped);

}  // namespace scanmill
