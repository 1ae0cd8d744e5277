#pragma once

// The rules of marching, for all backends: the outcomes of particles and the constants of their steps. Lengths are in
// voxels of the level unless stated otherwise.

#include <cstdint>

namespace scanmill {

enum class Outcome : std::uint32_t {
  Hit = 0,
  Miss = 1,       // the particle hit nothing up to the end of its path
  Exhausted = 2,  // the particle used up its steps, so that it is neither a hit nor a miss
};

// In a field without lists, a particle hits a surface where the interpolated distance (voxels) is at most kHitDistance.
// A limit of half a voxel or more misses no plane: a plane midway between two corners is half a voxel away from both.
// In a field with lists, particles near surfaces go from voxel to voxel instead, and test the triangles of each voxel.
constexpr float kHitDistance = 0.501f;

// A distance R stored at a point means that the ball of radius R around the point is free. A particle at position r
// relative to the ball's centre, with |r| <= M < R, leaves the ball after the length -r.d + sqrt(R^2 - m^2), where d is
// the particle's direction and m^2 = |r|^2 - (r.d)^2. The root is a concave function of m^2. Therefore R - c m^2 is at
// most the root for all m <= M, if c = (R - sqrt(R^2 - M^2)) / M^2, which makes the two equal at m = M. As c decreases
// with R, the c for the smallest R is valid for all larger R. The bound avoids the root, which GPUs round differently.
constexpr float kEmptyChordFactor = 0.083334f;   // c for R >= kEmptyBrick and M = 4 sqrt(3)
constexpr float kNearestChordFactor = 0.26297f;  // c for R >= kNearestLimit and M = sqrt(3) / 2
constexpr float kListChordFactor = 0.78805f;     // c for R >= kListLimit and M = sqrt(3) / 2

// Fraction by which triangles are enlarged, so that rounding opens no cracks between them.
constexpr float kTriangleMargin = 1e-5f;
constexpr float kBackwardTolerance = 0.25f;  // voxels; a hit may be this far behind the particle, because the particle
                                             // may have stepped past it
constexpr float kTieMargin = 1e-4f;      // voxels by which a later triangle of a list must be nearer to replace a hit
constexpr float kFaceOvershoot = 1e-3f;  // voxels; length by which a step goes past a voxel's face
// Distance from a voxel's centre to the planes at which a particle leaves the voxel. The planes are slightly past the
// faces: the particle is then certainly in the next voxel, and a particle that moves within a face need not leave.
constexpr float kExitPlane = 0.5f + kFaceOvershoot;

// A particle that passes through a hole of an alpha-tested texture continues this far behind the hole: the larger of a
// length (field frame) and a fraction of the particle's path so far.
constexpr float kHoleSkip = 2e-3f;
constexpr float kHoleSkipShare = 1e-5f;

// Thin layers, such as markings on a road, are found by a lookup kLayerLookupOffset in front of the surface, on the
// beam's side. If the surface is parallel to an axis plane, the corner nearest to this point is at least
// kLayerThickness from the surface, and so outside of the layer. 0.6 % of beams need this lookup in "street", 0.03 % in
// "truck_town".
constexpr double kLayerThickness = 0.1;  // voxels, largest thickness of a layer
constexpr double kLayerLookupOffset = 0.5 + kLayerThickness;
constexpr double kLayerMinCosine = 0.9;  // least cosine of the angle between a layer and the surface below the layer

}  // namespace scanmill
