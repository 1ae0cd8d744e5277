#pragma once

// Reads files that Blender opens (.blend) or imports (.fbx, .abc, .x3d, .usd): Blender itself converts them to GLB.

#include <filesystem>

#include "base/file.h"
#include "base/format_support.h"

namespace scanmill {

// Returns what is read from files that Blender opens or imports, and what is left out.
const FormatSupport& blenderFormat();

// A GLB of what a file shows: of a .blend, the active scene at its saved frame, with all objects that are visible both
// in the viewport and in renders; their surfaces and instances as renders evaluate them, and materials with base colour
// textures. Names stay the same, but Blender adds .001 to a name that occurs twice. Coordinates are in metres by the
// file's unit, z up by its axes. The GLB names missing images by their paths. Warns of what is left out. No script,
// driver expression or handler of the file is run. The GLB is in a temporary folder, which the destructor removes.
class BlenderExport {
 public:
  // Throws an InputError that names the file if its content does not fit its ending, if it is damaged, was saved by a
  // newer Blender, or shows nothing, or if this Blender has no importer for it. Throws Error if Blender is not
  // installed.
  explicit BlenderExport(const std::filesystem::path& file);

  std::filesystem::path glb() const { return folder_.path() / "scene.glb"; }

 private:
  ScratchFolder folder_;
};

}  // namespace scanmill
