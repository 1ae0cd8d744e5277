#pragma once

// Determines the azimuths of a scan's rings and columns, so that a range image can be arranged like a photograph.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "scan/scan.h"
#include "sensors/beams.h"
#include "sensors/destagger.h"

namespace scanmill {

// The azimuths of all beams. The azimuth of a beam is first + offset[ring] + step * column (rad).
struct StripColumns {
  double first = 0;            // azimuth of column 0 (rad)
  std::vector<double> offset;  // azimuth of each ring relative to the column (rad)
  double step = 0;             // angle from column to column (rad); negative if the sensor rotates clockwise
  bool fullTurn = false;       // true: a full revolution, where the first column follows the last
};

// Returns the azimuths of the beams. They are taken from the sensor's beam table `beams` if it has `rings` rings and
// `columns` columns and its rings are cones; otherwise they are estimated from the points. The estimated step is the
// median of the steps between neighbouring columns. The estimated offset of a ring is the median of (azimuth - first -
// step * column) over its points, so that a few near or noisy points have no influence. If azimuths increase or
// decrease steadily but not evenly, as in a camera image, all offsets are 0. Returns nothing if there are too
// few points, or if azimuths neither increase nor decrease with the column. `ring` and `column`: one per point.
std::optional<StripColumns> stripColumns(const Scan& scan, const std::vector<std::size_t>& ring,
                                         const std::vector<std::size_t>& column, std::size_t rings, std::size_t columns,
                                         const BeamTable* beams);

// The pixels of beams in a range image that looks outward: the image is destaggered, mirrored if the sensor rotates
// counter-clockwise, and rotated in a full revolution.
struct StripPlaces {
  Destagger image;
  bool mirrored = false;
  std::size_t start = 0;  // pixel column of column 0 of the destaggered image

  std::size_t place(std::size_t ring, std::size_t column) const {
    const std::size_t c = image.place(ring, static_cast<std::uint32_t>(column));
    return (start + (mirrored ? image.width - c : c)) % image.width;
  }
};

// Returns the places of the beams such that the left side of the image shows what is on the sensor's left. If the field
// of view is a full revolution, the middle of the image shows straight ahead. Returns nothing if the azimuths of two
// rings differ so much that their rows would not overlap.
std::optional<StripPlaces> lookingOutward(const StripColumns& look, std::size_t columns);

}  // namespace scanmill
