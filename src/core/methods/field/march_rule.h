#pragma once

// The rules of marching, for all backends: the outcomes of particles and the constants of their steps. Lengths are in
// voxels of the level unless stated otherwise.

#include <cstdint>

namespace scanmill {

enum class Outcome : std::uint32_t {
  Hit = 0,
  Miss = 1,       // the particle hit nothing up to the end of its path
  Exhausted = 2,  // the particle used up its steps: neither a hit nor a miss
};

// In a field with lists, particles near surfaces go from voxel to voxel and are intersected with the triangles there.
// In a field without lists, a particle hits a surface where the interpolated distance (voxels of the level) is at most
// kRest. With half a voxel or more no plane is missed: a plane midway between two corners is half a voxel away from
// both.
constexpr float kRest = 0.501f;

// A distance R at a point means that the ball of radius R around the point is free. A particle at r from the centre of
// the ball, with |r| <= M < R, leaves the ball after the length -r.d + sqrt(R^2 - m^2), where m^2 = |r|^2 - (r.d)^2.
// The root is a concave function of m^2. So R - c m^2 is at most the root for all m <= M, if c = (R - sqrt(R^2 - M^2))
// / M^2, which makes the two equal at m = M. As c falls with R, the c of the smallest R serves all larger R. So each
// kind of ball needs one constant and no root, which GPUs round differently.
constexpr float kEmptyBend = 0.083334f;  // R >= kEmptyBrick, M = 4 sqrt(3)
constexpr float kNamedBend = 0.26297f;   // R >= kNamed, M = sqrt(3) / 2
constexpr float kListedBend = 0.78805f;  // R >= kListed, M = sqrt(3) / 2

// Triangles count as larger by this share, so that rounding opens no cracks between them.
constexpr float kSeam = 1e-5f;
constexpr float kBehind = 0.25f;  // how far behind the particle a hit may lie, as the particle may have overstepped it
constexpr float kTie = 1e-4f;     // of surfaces this close to each other the first in the list is hit
constexpr float kNudge = 1e-3f;   // length of the step past a voxel's face
// The distance from the middle of a voxel to the planes at which a particle leaves it. They lie slightly past the
// faces, so that the particle is certainly in the next voxel, and so that a particle that moves within a face need not
// leave.
constexpr float kFace = 0.5f + kNudge;

// A particle that passes a hole of an alpha-tested texture continues this far behind it: the larger of a length and a
// share of its path so far, both in the field frame.
constexpr float kBehindHole = 2e-3f;
constexpr float kBehindHoleShare = 1e-5f;

// The plane of the triangle that a particle has found is trusted if the particle is at most this far from it: a
// particle rests at most kRest from a surface, and the corner that names the triangle is at most half a diagonal away.
constexpr float kTrusted = 1.5f;
// If the distance at the corrected position is larger than this, there is no surface: the position is beyond the edge
// of the triangle, although in its plane.
constexpr float kThere = 0.6f;

// Thin layers, such as markings on a road, are found through corners on the beam's side of the layer: a point kAside in
// front of the surface is nearest to a corner at least kLayer in front of it, beyond the layer. On the street 0.6 % of
// all beams get their label this way, on truck_town 0.03 %.
constexpr double kLayer = 0.1;  // largest thickness of a layer; a surface farther off is not one
constexpr double kAside = 0.5 + kLayer;
constexpr double kAlike = 0.9;  // least cosine of the angle between a layer and the surface below it

}  // namespace scanmill
