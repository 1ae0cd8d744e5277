#pragma once

// Simple solids as triangles, appended to a mesh. Outward normals, counter-clockwise. Sizes in metres. `surface` is an
// index into mesh.surfaces; `place` goes from the primitive's frame to the mesh's.

#include <cstdint>

#include "scene/scene.h"

namespace scanmill {

// Centred at the origin.
void appendBox(Mesh& mesh, std::uint16_t surface, const Affine& place, const Vec3d& size);
void appendSphere(Mesh& mesh, std::uint16_t surface, const Affine& place, double radius, int segments = 32);
// Along z from -height/2 to height/2. A cone is a cylinder whose top radius is 0.
void appendCylinder(Mesh& mesh, std::uint16_t surface, const Affine& place, double bottomRadius, double topRadius,
                    double height, int segments = 32);
// Along z; `height` is the cylinder between the two half spheres.
void appendCapsule(Mesh& mesh, std::uint16_t surface, const Affine& place, double radius, double height,
                   int segments = 32);
// In z = 0, centred, facing +z, cut into `cells` x `cells` quads.
void appendPlane(Mesh& mesh, std::uint16_t surface, const Affine& place, double sizeX, double sizeY, int cells = 1);
// Two triangles a b c, a c d.
void appendQuad(Mesh& mesh, std::uint16_t surface, const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d);

}  // namespace scanmill
