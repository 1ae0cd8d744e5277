#pragma once

// Computes the column of a range image for each beam, such that every column looks in one direction. The lasers that
// fire as one column of the sensor look in directions that differ by the rings' azimuth offsets; in an image of rings
// and columns upright edges are therefore zigzags. Shifting each row straightens them, which vendors call destaggering.
//
//   const Destagger image = destagger(*beams);
//   const std::uint32_t x = image.place(ring, column);  // row: ring; 0 <= x < image.width

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sensors/beams.h"

namespace scanmill {

struct Destagger {
  std::vector<std::uint32_t> shift;  // columns to add in each ring
  std::uint32_t width = 0;           // columns of the image

  // Returns the image's column of a beam. Different columns of a ring have different places.
  std::uint32_t place(std::size_t ring, std::uint32_t column) const { return (column + shift[ring]) % width; }
};

// Returns shifts that place each beam within half a column of the direction of its column in the image. `offset`:
// azimuth of each ring (rad) relative to the others. `step`: azimuth from a column to the next one (rad), negative if
// the sensor turns clockwise. In a full turn the image is as wide as the sensor has columns, and a ring with the offset
// 0 is not shifted. In a partial field the image is wider by the largest difference of two shifts, and the least shift
// is 0.
Destagger destagger(std::span<const double> offset, double step, std::uint32_t columns, bool fullTurn);

// Returns the shifts of a sensor by its azimuth offsets; only the compact description of the beams is needed. Sensors
// whose rings are not cones (listed beams, rosettes) have no azimuth offsets: their shifts are 0.
Destagger destagger(const BeamTable& beams);

}  // namespace scanmill
