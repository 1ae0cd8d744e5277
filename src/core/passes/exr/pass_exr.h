#pragma once

// Pass images as OpenEXR files.
//
// Each file has the image of one camera, as scan lines, lossless (ZIP), row 0 at the top. It has these channels, as far
// as the image has them:
//
//   Z                 float32  m, planar depth; 1e10 if the pixel shows no surface (as Blender writes it)
//   N.X N.Y N.Z       float32  unit normal, world axes, turned towards the camera; 0 if the pixel shows no surface
//   instance          uint32   instance id; 0: the surface belongs to no thing
//   semantic          uint32   class id
//   material          uint32   index into the materials of the recording
//   primitive         uint32   triangle index in its mesh
//   reflectance, roughness, metallic, retroreflectance   float32
//
// Attributes:
//
//   cameraMatrix        m33d    px, the rows fx 0 cx, 0 fy cy, 0 0 1
//   worldFromCamera     m44d    for column vectors, row by row; camera axes x right, y down, z forward
//   worldFromCameraXyz, worldFromCameraW (v3d, double)    the exact rotation, as a quaternion
//   horizontalFieldDeg, verticalFieldDeg (double)         between the outer edges of the image
//   camera, units, writer (string)                        the camera's name, "m", the program's name
//
// Files of other programs can be read too. They need Z, the other requested passes, cameraMatrix and worldFromCamera
// (m33f and m44f are accepted). The other attributes may be absent, but must not contradict these two. Files may have
// scan lines or tiles, one part or several, and any lossless compression. A layer's name may precede a channel's name
// ("ViewLayer.Normal.X"), and these other names are accepted:
//
//   Z: also Depth.Z and depth.Z     N.X ...: also Normal.X ...     single values: also with .X or .V at the end
//   instance: also IndexOB          material: also IndexMA
//
// Many programs write ids as FLOAT. Such ids are accepted if all of them are integers below 2^24, so that no id can
// have been rounded or blended. Depth and ids must not be HALF, all other channels may be.

#include <filesystem>

#include "passes/pass_image.h"

namespace scanmill {

// Writes an image. The file gets its final name only when it is complete (see AtomicFile). Throws Error.
void writePasses(const std::filesystem::path& path, const PassImage& image);

// Reads the requested passes, bit for bit as writePasses() wrote them. A pixel whose depth is infinite or at least 1e9
// m shows no surface, whatever its other channels contain. Normals that face away from the camera are flipped. Throws
// InputError that names the file, the channel or attribute, and what to do, for files that are not EXR or truncated; a
// channel that is absent or of the wrong type; a depth that is NaN, negative or zero; a normal that is not a unit
// vector; normals of which most face away (worldFromCamera then probably has the axes of OpenGL or Blender); an id that
// is not an integer or too large; a reflectance, roughness or metallic outside of 0 to 1; an attribute that is absent
// or invalid; a data window that differs from the display window.
PassImage readPasses(const std::filesystem::path& path, PassChoice requested);

// Returns the passes that a file contains.
PassChoice passesIn(const std::filesystem::path& path);

}  // namespace scanmill
