#pragma once

// Beams are data: a sensor is a table of directions, origins and firing times. This header is installed because
// sensors/sensor.h includes it.
//
//   const Vec3d firstOfRing3 = beams->direction[3 * beams->columns];

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "base/vec.h"

namespace scanmill {

// Beams that are listed one by one, indexed by ring * columns + column.
struct ListedBeams {
  std::vector<double> azimuth, elevation;  // rad, in the sensor's frame
  std::vector<double> time;                // s since the start of the revolution
  std::vector<Vec3f> origin;               // m; empty if all origins are zero

  // Returns when the first beam of each column fires (s since the start of the revolution).
  std::vector<double> columnStarts(std::uint32_t columns) const;
};

// Rotating prisms, each of which deflects the beam by a small angle towards the prism's current orientation. To first
// order the deflections add up, and the beam traces a rosette about the x axis that need not repeat (Risley prisms;
// Marshall, "Risley prism scan patterns", Proc. SPIE 3787, 1999, equations 1 and 2).
struct Rosette {
  std::vector<double> angle;  // rad, deflection by each prism
  std::vector<double> speed;  // rad/s, rotation of each prism
  std::vector<double> phase;  // rad, orientation of each prism at time 0: from y (left) towards z (up)
  // Further deflection of each laser (rad), to the left and up; a laser is a ring. Empty: one laser on the axis.
  std::vector<double> left, up;
  // A mirror that turns about the z axis. If there is one, lasers and prisms look along z (deflections to the left and
  // up are then along x and y), and the mirror reflects the beams to the sides.
  struct Mirror {
    double tilt = 0;   // rad, between the mirror's normal and the -z axis
    double speed = 0;  // rad/s, counter-clockwise seen from above
    double phase = 0;  // rad, azimuth of the normal at time 0
  };
  std::optional<Mirror> mirror;

  std::size_t lasers() const { return left.empty() ? 1 : left.size(); }
};

// The beams of one revolution of a sensor, indexed by ring * columns + column; column 0 fires first. Directions and
// origins are in the sensor's frame: x forward, y left, z up. Azimuths count from x towards y, which is
// counter-clockwise seen from above, for both directions of rotation.
struct BeamTable {
  std::string model;   // for example "OS1-128"
  std::string source;  // source of the sensor's figures
  std::uint32_t rings = 0;
  std::uint32_t columns = 0;

  std::vector<Vec3d> direction;  // unit vectors
  std::vector<Vec3f> origin;     // m, origin of each beam; empty if all are zero
  std::vector<float> time;       // s since the start of the revolution; empty for the rays of footprints, which fire at
                                 // columnTime(), without the few microseconds of the ring's offset

  double minRange = 0;  // m, smallest range that is reported; a nearer surface blocks the beam, which then has no hit
  double maxRange = 0;  // m, largest range that is reported, inclusive
  double period = 0;    // s, duration of one revolution

  // Compact description of the beams, which the manifest stores; fillBeams() computes the three tables above from it.
  // Rings on cones about the z axis are described by the members below. In the other patterns, `field` is a full
  // circle. Listed beams also use `elevation` and `topDown`, and a rosette uses `firingOffset`; the other members for
  // cones are unused. Each ring of a rosette sensor traces the rosette; its columns fire evenly over the period.
  struct RingsOnCones {};
  std::variant<RingsOnCones, std::shared_ptr<const ListedBeams>, Rosette> pattern;
  double sweep = 0;                 // s, time from the first to the last column of a partial field; 0: the time is
                                    // period * field / (2 pi)
  double start = 0;                 // s since the start of the drive: time at which column 0 fires, see changes()
  std::vector<double> columnStart;  // s, firing time of each column of listed beams; set by fillBeams()
  // Number of equal parts of a turn about the z axis, each of which is a revolution of its own, for scans that do not
  // fit into memory as a whole. The members describe the part that begins at `start`; `period` is the time of one part.
  std::uint32_t sectors = 1;
  bool clockwise = false;             // direction of rotation, seen from above
  double firstAzimuth = 0;            // rad, azimuth of column 0 without the ring's offset
  double field = 2 * kPi;             // rad, horizontal field of view; in a full circle the last column is one
                                      // step before the first column
  std::vector<double> elevation;      // rad, per ring
  std::vector<double> azimuthOffset;  // rad, per ring; added to the azimuth of each column
  std::vector<double> firingOffset;   // s, per ring; added to the column's time
  double originOffset = 0;            // m, distance of the beam origin from the axis, along the head's azimuth
  double originHeight = 0;            // m, height of the beam origin above the origin of the sensor's frame
  // Shifts of the beam's origin per ring (m): to the left, perpendicular to the beam; and upwards, perpendicular to the
  // beam and to the left. Each array is empty if all its values are zero.
  std::vector<double> originLeft, originUp;
  bool topDown = false;  // true: ring 0 is the highest ring, or for listed beams is above the last ring

  // Full width of the beam across (in azimuth) and up (in elevation): exit width + divergence * range. A Gaussian beam
  // is measured where the power has fallen to 1/e^2 of the power in the middle. Zero if the sensor file gives no width.
  std::array<double, 2> divergence{};  // rad, full angle, across and up
  std::array<double, 2> exitWidth{};   // m, across and up
  bool uniformBeam = false;            // true: equal power over the whole beam; false: Gaussian
  double pulse = 0;                    // s, duration for which the emitted pulse exceeds half of its maximum

  // Number of neighbouring columns in `direction`, `origin` and `time` that are rays of one beam (sensors/footprint.h).
  std::uint32_t raysPerBeam = 1;

  std::size_t size() const { return std::size_t{rings} * columns; }

  bool onCones() const { return std::holds_alternative<RingsOnCones>(pattern); }
  const Rosette* rosette() const { return std::get_if<Rosette>(&pattern); }  // null: another pattern
  // Returns true if the beams of a revolution depend on `start`.
  bool changes() const { return rosette() != nullptr || sectors > 1; }
  // Returns the beams that are listed one by one; null: another pattern.
  std::shared_ptr<const ListedBeams> listed() const {
    const auto* const beams = std::get_if<std::shared_ptr<const ListedBeams>>(&pattern);
    return beams == nullptr ? nullptr : *beams;
  }

  // Returns the point where a beam starts (m, the sensor's frame).
  Vec3d originOf(std::size_t beam) const { return origin.empty() ? Vec3d{} : Vec3d(origin[beam]); }

  bool fullTurn() const { return field > 2 * kPi - 1e-9; }
  // Returns the azimuth (rad) of the head when a column fires, without the ring's offset.
  double azimuth(std::uint32_t column) const;
  // Returns the time (s since the start of the revolution) at which a column fires, without the ring's offset.
  double columnTime(std::uint32_t column) const {
    return columnStart.empty() ? column * columnPeriod() : columnStart[column / raysPerBeam];
  }
  // Returns the time between neighbouring columns (s), or its mean for listed beams. In a field of less than a full
  // circle the first and the last column are at the two edges.
  double columnPeriod() const {
    const std::uint32_t steps = fullTurn() || columns == 1 ? columns : columns - 1;
    return (sweep > 0 ? sweep : period * (field / (2 * kPi))) / steps;
  }
};

// Computes direction, origin and time of every beam from the table's compact description. raysPerBeam must be 1.
void fillBeams(BeamTable& table);

// Returns the beams of the revolution that starts at `time` (s since the start of the drive). The result is `table`
// itself unless BeamTable::changes(): a rosette's pattern differs from revolution to revolution, and sectors follow
// each other about the z axis. `table` may have the rays of footprints if it is not a rosette.
[[nodiscard]] std::shared_ptr<const BeamTable> beamsAt(const std::shared_ptr<const BeamTable>& table, double time);

// Computes the column of a range image for each beam, such that every column looks in one direction. The lasers that
// fire as one column of the sensor look in directions that differ by the rings' azimuth offsets. Without correction,
// upright edges are therefore zigzags in the image; shifting each row straightens the edges (destaggering).
//
//   const Destagger image = destagger(*beams);
//   const std::uint32_t x = image.columnOf(ring, column);  // row: ring; 0 <= x < image.width
struct Destagger {
  std::vector<std::uint32_t> shift;  // columns to add in each ring
  std::uint32_t width = 0;           // columns of the image

  // Returns the column of the image that shows a beam. Beams of one ring never share a column.
  std::uint32_t columnOf(std::size_t ring, std::uint32_t column) const { return (column + shift[ring]) % width; }
};

// Returns shifts that place each beam in the column of the image nearest to its direction, at most half a column away.
// `offset`: azimuth offset of each ring (rad). `step`: azimuth from a column to the next one (rad), negative if the
// sensor turns clockwise. In a full turn the image is as wide as the sensor has columns, and a ring with the offset 0
// is not shifted. In a partial field the image is wider by the largest difference of two shifts; the least shift is 0.
Destagger destagger(std::span<const double> offset, double step, std::uint32_t columns, bool fullTurn);

// Returns the shifts of a sensor by its azimuth offsets; only the compact description of the beams is needed. Sensors
// whose rings are not cones (listed beams, rosettes) have no azimuth offsets: their shifts are 0.
Destagger destagger(const BeamTable& beams);

}  // namespace scanmill
