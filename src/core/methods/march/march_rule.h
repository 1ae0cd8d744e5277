#pragma once

// Constants of the rule of flight, for all backends. Lengths in voxels of the level where nothing else is said.

namespace scanmill {

// A distance R at a point says that the ball around the point is free. Where the particle is at r from its centre, with
// |r| <= M < R, it leaves the ball after -r.d + sqrt(R^2 - m^2), m^2 = |r|^2 - (r.d)^2. The root is a concave function
// of m^2, so that R - c m^2 is at most the root if it is that at m = M, for c = (R - sqrt(R^2 - M^2)) / M^2; and c
// falls with R. Hence one constant for each kind of place, and no root, which GPUs round as they like.
constexpr float kEmptyBend = 0.083334f;  // R >= kEmptyBrick, M = 4 sqrt(3)
constexpr float kNamedBend = 0.26297f;   // R >= kNamed, M = sqrt(3) / 2
constexpr float kListedBend = 0.78805f;  // R >= kListed, M = sqrt(3) / 2

// Over-relaxation (Keinert, Schaefer, Korndoerfer, Ganse, Stamminger 2014, "Enhanced sphere tracing", section 3.1):
// after a ball the particle looks so much farther, as a share of its stride. Where the balls then leave a gap it goes
// back to where the first one ends.
constexpr float kLeap = 0.3f;

// Without lists: interpolated distances are up to 0.5 on a plane, but up to 0.624 where three walls meet at right
// angles and as far behind a plane as a particle may overstep. A particle that was so near and then moves away has
// turned at an edge, or passed it: it rests where it was nearest.
constexpr float kBrink = 0.63f;
constexpr float kNever = 1e30f;  // nearer than this has been everything

// Share of a triangle by which it is larger than it is, so that rounding opens no cracks between triangles.
constexpr float kSeam = 1e-5f;
constexpr float kBehind = 0.25f;  // how far behind the particle a hit may lie, for it may have overstepped
constexpr float kTie = 1e-4f;     // surfaces so near each other are one, and the first of the list is met
constexpr float kNudge = 1e-3f;   // past a voxel's face
// From a voxel's middle to where a particle leaves it: past the face, so that it is in the next voxel for certain, and
// so that one that flies along the face, on it, need not leave.
constexpr float kFace = 0.5f + kNudge;

}  // namespace scanmill
