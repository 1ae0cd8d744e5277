#pragma once

// Draws points as round splats: in front of one another by a depth buffer, with darkened depth edges.

#include <span>
#include <vector>

#include "base/vec.h"
#include "viewer/image.h"
#include "viewer/view_camera.h"

namespace scanmill {

struct SplatStyle {
  double size = 1;         // factor on the radius of all splats
  bool depthEdges = true;  // darkens points behind a nearer surface, as eye-dome lighting does
};

// One colour per point; points that are not finite are left out. Of two points on a pixel the nearer wins, at equal
// depth the first.
Image drawSplats(std::span<const Vec3f> points, std::span<const Rgb> colors, const ViewCamera& camera, int width,
                 int height, const SplatStyle& style);

}  // namespace scanmill
