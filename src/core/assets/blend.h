#pragma once

// Imports .blend files: Blender itself turns them into GLB.

#include <filesystem>

#include "base/scratch_folder.h"

namespace scanmill {

// A GLB of what the active scene of a .blend shows in the viewport and in renders: surfaces with their modifiers
// applied, instances, and materials with their base colour textures. Names are kept. Coordinates are in metres by the
// file's unit scale, z up. No script, driver expression or handler of the file runs. The GLB lies in a temporary
// folder, which the destructor removes.
class BlendExport {
 public:
  // Throws an InputError that names the file where it is no .blend, is damaged, was saved by a newer Blender, or shows
  // nothing. Throws Error where there is no Blender.
  explicit BlendExport(const std::filesystem::path& file);

  std::filesystem::path glb() const { return folder_.path() / "scene.glb"; }

 private:
  ScratchFolder folder_;
};

}  // namespace scanmill
