#pragma once

// Import of .blend files: Blender itself turns them into GLB.

#include <filesystem>

#include "base/scratch_folder.h"

namespace scanmill {

// A GLB of what a .blend shows in its active scene, in the viewport and in renders: surfaces with modifiers applied,
// instances, materials with their base colour textures; names kept; z up, metres by the file's unit scale. No script,
// driver expression or handler of the file runs. It lies in a temporary folder and is gone with the object.
class BlendExport {
 public:
  // Throws InputError that names the file: no .blend, damaged, saved by a newer Blender, nothing to see; and Error
  // where there is no Blender.
  explicit BlendExport(const std::filesystem::path& file);

  std::filesystem::path glb() const { return folder_.path() / "scene.glb"; }

 private:
  ScratchFolder folder_;
};

}  // namespace scanmill
