#pragma once

// Which way the rings and columns of a scan look, so that a range image can be laid out like a photograph.

#include <cstddef>
#include <optional>
#include <vector>

#include "scan/scan.h"
#include "sensors/beams.h"

namespace scanmill {

// Azimuth of a beam: first[ring] + step * column.
struct StripColumns {
  std::vector<double> first;  // rad, per ring
  double step = 0;            // rad, from column to column; negative where the sensor turns clockwise
  bool fullTurn = false;      // the last column is followed by the first
};

// By the sensor's table, where it is of this size and its beams lie on cones; else estimated from the points: the step
// is the median of that between neighbours, a ring's first azimuth the median of its points' azimuth minus the step
// times the column; medians are not moved by the few points that are near or noisy. Where azimuths are not evenly apart
// and go one way all the same, as in an image, the rings' first are all 0. None where there are too few points, or
// where their columns follow no azimuth. `ring` and `column`: one per point.
std::optional<StripColumns> stripColumns(const Scan& scan, const std::vector<std::size_t>& ring,
                                         const std::vector<std::size_t>& column, std::size_t rings, std::size_t columns,
                                         const BeamTable* beams);

// Of each ring and of the whole: column c stands in pixel column base[ring] - c, or + c where the sensor turns
// clockwise; modulo the width in a full revolution.
struct StripShifts {
  std::vector<std::ptrdiff_t> base;
  bool clockwise = false;
  bool fullTurn = false;
  std::size_t width = 0;

  std::size_t place(std::size_t ring, std::size_t column) const;
};

// Straight ahead (a full revolution), or the middle of the field, is in the middle; left is on the left. None where
// rings look so far past one another that the rows would not meet.
std::optional<StripShifts> lookingOutward(const StripColumns& look, std::size_t columns);

}  // namespace scanmill
