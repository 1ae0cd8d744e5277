#pragma once

// Determines the azimuths of a scan's rings and columns, so that a range image can be laid out like a photograph.

#include <cstddef>
#include <optional>
#include <vector>

#include "scan/scan.h"
#include "sensors/beams.h"

namespace scanmill {

// The azimuth of a beam is first[ring] + step * column.
struct StripColumns {
  std::vector<double> first;  // rad, per ring
  double step = 0;            // rad, from column to column; negative if the sensor turns clockwise
  bool fullTurn = false;      // a full revolution: the first column follows the last
};

// Takes the azimuths from the sensor's table if it has this size and its beams lie on cones, else estimates them from
// the points. The estimated step is the median of the steps between neighbours; a ring's first azimuth is the median of
// (azimuth - step * column) over its points; a few near or noisy points do not move a median. If azimuths increase or
// decrease steadily but not evenly, as in a camera image, all rings have first = 0. None if there are too few points,
// or if columns do not follow the azimuth. `ring` and `column`: one per point.
std::optional<StripColumns> stripColumns(const Scan& scan, const std::vector<std::size_t>& ring,
                                         const std::vector<std::size_t>& column, std::size_t rings, std::size_t columns,
                                         const BeamTable* beams);

// How rings are shifted: column c of a ring is drawn in pixel column base[ring] - c, or base[ring] + c if the sensor
// turns clockwise; modulo the width in a full revolution.
struct StripShifts {
  std::vector<std::ptrdiff_t> base;
  bool clockwise = false;
  bool fullTurn = false;
  std::size_t width = 0;

  std::size_t place(std::size_t ring, std::size_t column) const;
};

// Returns shifts that put straight ahead (in a full revolution), or else the middle of the field of view, in the middle
// of the image, and left on the left. None if the azimuths of two rings differ so much that their rows would not
// overlap.
std::optional<StripShifts> lookingOutward(const StripColumns& look, std::size_t columns);

}  // namespace scanmill
