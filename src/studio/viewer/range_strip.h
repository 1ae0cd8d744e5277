#pragma once

// The range image of a scan (rings x columns), and the mapping between its pixels and the points in the 3D view.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "scan/scan.h"
#include "sensors/beams.h"
#include "viewer/image.h"

namespace scanmill {

constexpr std::uint32_t kNoPoint = 0xFFFFFFFFu;

struct RangeStrip {
  Image image;                         // the picture; one row per ring, the highest beams at the top
  std::vector<std::uint32_t> pointAt;  // index of the point that each pixel shows; kNoPoint: none
  // Pixel of each point (row * width + column), even if the pixel shows another point.
  std::vector<std::uint32_t> pixelOf;
  bool ringsRise = false;   // true: ring 0 is the lowest; it is in the last row
  bool outward = false;     // true: the image's left side is to the sensor's left; upright edges appear upright
  bool fullTurn = false;    // true: `outward` is true and the columns form a full turn; straight ahead is in the middle
  std::size_t columns = 0;  // number of the sensor's columns; the image is wider if rings of a partial turn are shifted

  // Returns the column and the row of the pixel of a point.
  std::pair<int, int> place(std::size_t point) const {
    const auto width = static_cast<std::uint32_t>(image.width);
    return {static_cast<int>(pixelOf[point] % width), static_cast<int>(pixelOf[point] / width)};
  }
};

// Draws the range image of a scan, with a separate pixel for each beam. `colors`: one per point. `shown`: for each
// point, whether it is drawn; empty: all are drawn. If several points are in the same pixel, the nearest is drawn.
// `beams`: beam table of the sensor; null if unknown. If azimuths do not increase or decrease with the column, columns
// are in the sensor's order. Throws InputError if the scan is too large for a picture, or if it is not organised and
// has no columns ring and column.
RangeStrip makeRangeStrip(const Scan& scan, std::span<const Rgb> colors, const std::vector<bool>& shown,
                          const BeamTable* beams = nullptr);

// Returns a description, such as "128 rings x 1024 columns, looking outward, straight ahead in the middle".
std::string describeStrip(const RangeStrip& strip);

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
