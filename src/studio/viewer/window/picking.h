#pragma once

// Finds the point under the pointer.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "base/vec.h"
#include "viewer/view_camera.h"

namespace scanmill {

// The points of one item on the canvas.
struct PickCloud {
  std::span<const Vec3f> positions;
  std::span<const std::uint8_t> shown;  // for each point, 0 if it is hidden; empty: all are shown
  Affine canvasFromItem;
};

struct PointHit {
  std::size_t cloud = 0;
  std::size_t point = 0;
  double distance = 0;  // distance from the pointer (pixels)
};

// Returns the point that is visible at the pixel (x, y) of the camera's picture. Points are drawn as squares of `size`
// pixels; among those that cover (x, y), the one nearest to the eye is returned. If no square covers (x, y), returns
// the point nearest to (x, y) in the picture, within `reach` pixels. At equal distances the first point is returned.
// Uses all threads; the result does not depend on their number.
std::optional<PointHit> pickPoint(std::span<const PickCloud> clouds, const ViewCamera& camera, double x, double y,
                                  double size, double reach);

// The line of sight through a pixel, given by its start (m) and its unit direction in the canvas frame.
struct SightLine {
  Vec3d origin;
  Vec3d direction;
};
SightLine sightLine(const ViewCamera& camera, double x, double y);

}  // namespace scanmill
