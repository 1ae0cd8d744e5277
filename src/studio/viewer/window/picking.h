#pragma once

// Which point lies under the pointer.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "base/vec.h"
#include "viewer/view_camera.h"

namespace scanmill {

// What is drawn of one item.
struct PickCloud {
  std::span<const Vec3f> positions;
  std::span<const std::uint8_t> shown;  // 0: not; empty: all
  Affine canvasFromItem;
};

struct PointHit {
  std::size_t cloud = 0;
  std::size_t point = 0;
  double depth = 0;     // m, along the line of sight
  double distance = 0;  // px, from the pointer
};

// Of the points whose squares of `size` pixels cover (x, y), pixels of the camera's picture, the nearest to the eye:
// the one that is seen there. Where none does: the one that is nearest to (x, y), within `reach` pixels. At equal
// distances the first. Uses all threads; the same for any number of them.
std::optional<PointHit> pickPoint(std::span<const PickCloud> clouds, const ViewCamera& camera, double x, double y,
                                  double size, double reach);

// The line of sight through a pixel, from where it starts; canvas frame, unit direction.
struct SightLine {
  Vec3d origin;
  Vec3d direction;
};
SightLine sightLine(const ViewCamera& camera, double x, double y);

}  // namespace scanmill
