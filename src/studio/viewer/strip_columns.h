#pragma once

// Determines the azimuths of a scan's rings and columns, so that a range image can be arranged like a photograph.

#include <cstddef>
#include <optional>
#include <vector>

#include "scan/scan.h"
#include "sensors/beams.h"

namespace scanmill {

// The azimuths of all beams. The azimuth of a beam is first[ring] + step * column (rad).
struct StripColumns {
  std::vector<double> first;  // azimuth of column 0 in each ring (rad)
  double step = 0;            // angle from column to column (rad); negative if the sensor rotates clockwise
  bool fullTurn = false;      // true: a full revolution, where the first column follows the last
};

// Returns the azimuths of the beams. They are taken from the sensor's beam table `beams` if it has `rings` rings and
// `columns` columns and its rings are cones; otherwise they are estimated from the points. The estimated step is the
// median of the steps between neighbouring columns. The estimated first azimuth of a ring is the median of (azimuth -
// step * column) over its points, so that a few near or noisy points have no influence. If azimuths increase or
// decrease steadily but not evenly, as in a camera image, all first azimuths are 0. Returns nothing if there are too
// few points, or if azimuths neither increase nor decrease with the column. `ring` and `column`: one per point.
std::optional<StripColumns> stripColumns(const Scan& scan, const std::vector<std::size_t>& ring,
                                         const std::vector<std::size_t>& column, std::size_t rings, std::size_t columns,
                                         const BeamTable* beams);

// How rings are shifted in a range image: column c of a ring is drawn in the pixel column base[ring] - c; if the sensor
// rotates clockwise, in base[ring] + c. In a full revolution, pixel columns are taken modulo the width.
struct StripShifts {
  std::vector<std::ptrdiff_t> base;
  bool clockwise = false;
  bool fullTurn = false;
  std::size_t width = 0;

  std::size_t place(std::size_t ring, std::size_t column) const;
};

// Returns shifts such that the left side of the image shows what is on the sensor's left. The middle of the image shows
// straight ahead; if the field of view is less than a full revolution, it shows the middle of the field of view.
// Returns nothing if the azimuths of two rings differ so much that their rows would not overlap.
std::optional<StripShifts> lookingOutward(const StripColumns& look, std::size_t columns);

}  // namespace scanmill
