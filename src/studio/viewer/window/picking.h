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
  std::span<const std::uint8_t> shown;  // per point, 0: hidden; empty: all are shown
  Affine canvasFromItem;
};

struct PointHit {
  std::size_t cloud = 0;
  std::size_t point = 0;
  double depth = 0;     // m, along the line of sight
  double distance = 0;  // px, from the pointer
};

// Returns the point that is seen at (x, y), pixels of the camera's picture: among the points whose squares of `size`
// pixels cover (x, y), the one nearest to the eye. If no square covers (x, y), returns the point nearest to (x, y) in
// the picture, within `reach` pixels. At equal distances the first point is returned. Uses all threads; the result does
// not depend on their number.
std::optional<PointHit> pickPoint(std::span<const PickCloud> clouds, const ViewCamera& camera, double x, double y,
                                  double size, double reach);

// The line of sight through a pixel: its start and its unit direction; canvas frame.
struct SightLine {
  Vec3d origin;
  Vec3d direction;
};
SightLine sightLine(const ViewCamera& camera, double x, double y);

}  // namespace scanmill
