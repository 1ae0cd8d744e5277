#pragma once

// How particles march, for all backends: what they end with, and the constants of their steps. Lengths are in voxels of
// the level unless said otherwise.

#include <cstdint>

namespace scanmill {

enum class Outcome : std::uint32_t {
  Hit = 0,
  Miss = 1,       // the particle met nothing up to the end of its way
  Exhausted = 2,  // its steps were used up: neither a hit nor a miss
};

// Where the field has lists, particles go from voxel to voxel near surfaces and are intersected with the triangles
// there. Where it has none, a particle hits a surface where the interpolated distance (voxels of the level) is at most
// this. With half a voxel or more no plane is missed: a plane midway between two corners is half a voxel away from
// both.
constexpr float kRest = 0.501f;

// A distance R at a point says that the ball around the point is free. Where the particle is at r from its centre, with
// |r| <= M < R, it leaves the ball after -r.d + sqrt(R^2 - m^2), m^2 = |r|^2 - (r.d)^2. The root is a concave function
// of m^2, so that R - c m^2 is at most the root if it is that at m = M, for c = (R - sqrt(R^2 - M^2)) / M^2; and c
// falls with R. Hence one constant for each kind of place, and no root, which GPUs round as they like.
constexpr float kEmptyBend = 0.083334f;  // R >= kEmptyBrick, M = 4 sqrt(3)
constexpr float kNamedBend = 0.26297f;   // R >= kNamed, M = sqrt(3) / 2
constexpr float kListedBend = 0.78805f;  // R >= kListed, M = sqrt(3) / 2

// Share of a triangle by which it is larger than it is, so that rounding opens no cracks between triangles.
constexpr float kSeam = 1e-5f;
constexpr float kBehind = 0.25f;  // how far behind the particle a hit may lie, for it may have overstepped
constexpr float kTie = 1e-4f;     // of surfaces so near to each other the first in the list is met
constexpr float kNudge = 1e-3f;   // past a voxel's face
// From a voxel's middle to where a particle leaves it. That is a little past the face, so that the particle is in the
// next voxel for certain, and so that a particle that moves along the face, on it, need not leave.
constexpr float kFace = 0.5f + kNudge;

// Behind a hole of a texture particles go on after the larger of a length and a share of their way, both in the field
// frame.
constexpr float kBehindHole = 2e-3f;
constexpr float kBehindHoleShare = 1e-5f;

// How far from its plane a particle's triangle may be for the plane to be trusted: what rests at kRest voxels of a
// surface is named by a corner at most half a diagonal from there.
constexpr float kTrusted = 1.5f;
// Where the distance at the corrected place is larger, there is no surface: beyond the edge of the triangle's plane.
constexpr float kThere = 0.6f;

// Thin layers, such as markings on a road, are told by corners of the side from which the beam comes, beyond the layer:
// a place kAside from the surface is nearest to a corner that is at least kLayer from it. On the street 0.6 % of all
// beams get their label so, on truck_town 0.03 %.
constexpr double kLayer = 0.1;  // how thick layers may be; what is farther off is another thing
constexpr double kAside = 0.5 + kLayer;
constexpr double kAlike = 0.9;  // cosine of the angle between a layer and what it lies on

}  // namespace scanmill
