#pragma once

// Imports .blend files: Blender itself converts them to GLB.

#include <filesystem>

#include "base/file.h"
#include "base/format_support.h"

namespace scanmill {

// Returns what is read from a .blend and what is left out.
const FormatSupport& blendFormat();

// A GLB of the active scene of a .blend, with all objects that are visible both in the viewport and in renders: their
// surfaces and instances as renders evaluate them at the saved frame, and materials with base colour textures. Names
// stay the same. Coordinates are in metres by the file's unit scale, z up. The GLB names missing images by their paths.
// Warns of what is left out. No script, driver expression or handler of the file is run. The GLB is in a temporary
// folder, which the destructor removes.
class BlendExport {
 public:
  // Throws an InputError that names the file if it is not a .blend, is damaged, was saved by a newer Blender, or shows
  // nothing. Throws Error if Blender is not installed.
  explicit BlendExport(const std::filesystem::path& file);

  std::filesystem::path glb() const { return folder_.path() / "scene.glb"; }

 private:
  ScratchFolder folder_;
};

}  // namespace scanmill
