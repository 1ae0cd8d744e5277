#pragma once

// Appends simple solids to a mesh, as triangles. Seen from outside, a triangle's corners go round counter-clockwise.
// Sizes are in metres. `surface` is an index into mesh.surfaces; `meshFromShape` transforms points from the primitive's
// frame to the mesh's frame. `segments` is the number of flat sides around the axis.

#include <cstdint>

#include "scene/scene.h"

namespace scanmill {

// Boxes and spheres are centred at the origin of the primitive's frame.
void appendBox(Mesh& mesh, std::uint16_t surface, const Affine& meshFromShape, const Vec3d& size);
void appendSphere(Mesh& mesh, std::uint16_t surface, const Affine& meshFromShape, double radius, int segments = 32);
// A cylinder lies along z, from -height/2 to height/2. A cone is a cylinder whose top radius is 0.
void appendCylinder(Mesh& mesh, std::uint16_t surface, const Affine& meshFromShape, double bottomRadius,
                    double topRadius, double height, int segments = 32);
// A capsule lies along z, centred at the origin; `height` is the height of the cylinder between the half spheres.
void appendCapsule(Mesh& mesh, std::uint16_t surface, const Affine& meshFromShape, double radius, double height,
                   int segments = 32);
// A plane lies in z = 0, centred at the origin, and faces +z. It is cut into `cells` x `cells` quads.
void appendPlane(Mesh& mesh, std::uint16_t surface, const Affine& meshFromShape, double sizeX, double sizeY,
                 int cells = 1);
// A quad becomes the two triangles a b c and a c d. Corners are in the mesh's frame.
void appendQuad(Mesh& mesh, std::uint16_t surface, const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d);

}  // namespace scanmill
