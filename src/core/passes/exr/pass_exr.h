#pragma once

// Pass images as OpenEXR files.
//
// One file per camera, scan lines, lossless (ZIP), row 0 at the top. Channels, those that there are:
//
//   Z                 float32  m, planar depth; 1e10 where nothing is seen (as Blender writes it)
//   N.X N.Y N.Z       float32  unit normal, world axes, turned towards the camera; 0 where nothing is seen
//   instance          uint32   0: stuff
//   semantic          uint32   class id
//   material          uint32   index into the materials of the recording
//   primitive         uint32   triangle index in its mesh
//   reflectance, roughness, metallic, retroreflectance   float32
//
// Attributes:
//
//   cameraMatrix        m33d    px, the rows fx 0 cx, 0 fy cy, 0 0 1
//   worldFromCamera     m44d    for column vectors, row by row; camera axes x right, y down, z forward
//   worldFromCameraXyz, worldFromCameraW (v3d, double)    the quaternion of its rotation, to the bit
//   worldToCamera       m44f    OpenEXR's standard attribute, for row vectors; camera axes x right, y up, z forward
//   horizontalFieldDeg, verticalFieldDeg (double)         between the outer edges of the image
//   camera, units, writer (string)                        the camera's name, "m", the program
//
// Files of others are read too. They need Z and what else is asked for, cameraMatrix and worldFromCamera (m33f and m44f
// will do); other attributes must agree with these where they are there. Scan lines or tiles, one part or several, any
// lossless compression. Before a channel's name may stand a layer's ("ViewLayer.Normal.X"), and these names are known:
//
//   Z: also Depth.Z and depth.Z     N.X ...: also Normal.X ...     single values: also with .X or .V at the end
//   instance: also IndexOB          material: also IndexMA
//
// Many programs write ids as FLOAT: those are taken where all of them are whole and below 2^24, so that none is rounded
// and none is blended. Normals and surface parameters may be HALF; depth and ids may not.

#include <filesystem>
#include <string>

#include "passes/pass_image.h"

namespace scanmill {

// Under its final name the file is whole (see AtomicFile). Throws Error.
void writePasses(const std::filesystem::path& path, const PassImage& image);

// Reads the passes that are asked for; what writePasses() wrote, to the bit. A depth that is infinite or at least 1e9 m
// means that nothing is seen, whatever the other channels say there. Throws InputError that names the file, the channel
// or attribute, and what to do: no EXR, truncated, a channel absent or of the wrong type, a depth that is NaN, negative
// or zero, a normal that is no unit vector, normals most of which face away from the camera (fewer are turned to it:
// then worldFromCamera is likely to have the axes of OpenGL or Blender), an id that is not whole or too large, a
// reflectance, roughness or metallic outside of 0 to 1, an attribute absent or senseless, a data window that is not the
// display window.
PassImage readPasses(const std::filesystem::path& path, PassChoice asked);

// Which passes the file holds.
PassChoice passesIn(const std::filesystem::path& path);

}  // namespace scanmill
