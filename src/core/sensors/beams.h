#pragma once

// Beams are data: a sensor is a table of directions, origins and firing times.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/vec.h"

namespace scanmill {

// Beams that are listed one by one, indexed by ring * columns + column.
struct ListedBeams {
  std::vector<double> azimuth, elevation;  // rad, in the sensor's frame
  std::vector<double> time;                // s since the start of the revolution
  std::vector<Vec3f> origin;               // m; empty where all are zero

  // Returns when the first beam of each column fires (s since the start of the revolution).
  std::vector<double> columnStarts(std::uint32_t columns) const;
};

// Two rotating prisms, each of which deflects the beam by a small angle in the direction that the prism has turned to.
// To first order the deflections add up, and the beam traces a rosette about the x axis that need not repeat (Risley
// prisms; Marshall, "Risley prism scan patterns", Proc. SPIE 3787, 1999, equations 1 and 2).
struct Rosette {
  std::array<double, 2> angle{};  // rad, deflection
  std::array<double, 2> speed{};  // rad/s
  std::array<double, 2> phase{};  // rad, at the time 0: from y (left) towards z (up)
};

// The beams of one revolution of a sensor, indexed by ring * columns + column; column 0 fires first. They are in the
// sensor's frame: x forward, y left, z up. Azimuths count from x towards y, which is counter-clockwise seen from above,
// whichever way the sensor rotates.
struct BeamTable {
  std::string model;   // "OS1-128"
  std::string source;  // where the figures come from
  std::uint32_t rings = 0;
  std::uint32_t columns = 0;

  std::vector<Vec3d> direction;  // unit
  std::vector<Vec3f> origin;     // m; empty where all are zero
  std::vector<float> time;       // s since the start of the revolution

  double minRange = 0;  // m; nearer surfaces are not reported (the beam is a miss: they still block it)
  double maxRange = 0;  // m; a hit at exactly maxRange counts
  double period = 0;    // s, of one revolution

  // The description of the beams, as the manifest keeps it; fillBeams() computes the three tables above from it. With
  // `listed` or `rosette`, the figures of cones below are unused, and the field is a full circle.
  std::shared_ptr<const ListedBeams> listed;  // null: not listed
  std::optional<Rosette> rosette;             // traced by each ring; columns fire evenly over the period
  double start = 0;                           // s, time of a rosette's column 0 since the start of the drive
  std::vector<double> columnStart;            // s, of listed beams; set by fillBeams()
  bool clockwise = false;                     // seen from above
  double firstAzimuth = 0;                    // rad, of column 0 before offsets
  double field = 2 * kPi;                     // rad, horizontal; in a full circle no column repeats the first
  std::vector<double> elevation;              // rad, per ring
  std::vector<double> azimuthOffset;          // rad, per ring
  std::vector<double> firingOffset;           // s, per ring
  double originOffset = 0;                    // m, beam origin to the axis of rotation, along the head's azimuth
  double originHeight = 0;                    // m, beam origin above the sensor frame's origin
  // Shifts of the beam's origin, m, per ring: to the left, perpendicular to the beam, and upwards, perpendicular to
  // both. Each is empty if all its values are zero.
  std::vector<double> originLeft, originUp;
  bool topDown = false;  // ring 0 is the highest beam

  // The beam's full width, across (in azimuth) and up (in elevation), is the width at the exit plus the divergence
  // times the range. A Gaussian beam's width is measured where its power has fallen to 1/e^2 of that in the middle.
  // Zero if the sensor file gives none.
  std::array<double, 2> divergence{};  // rad, full angle
  std::array<double, 2> exitWidth{};   // m
  bool uniformBeam = false;            // as bright at the edge as in the middle; false: Gaussian
  double pulse = 0;                    // s, full width of the emitted pulse at half of its maximum

  // This many neighbouring columns of the three tables are rays of one beam: see sensors/footprint.h.
  std::uint32_t raysPerBeam = 1;

  std::size_t size() const { return std::size_t{rings} * columns; }

  // Returns the point where a beam starts (m, the sensor's frame).
  Vec3d originOf(std::size_t beam) const { return origin.empty() ? Vec3d{} : Vec3d(origin[beam]); }

  bool fullTurn() const { return field > 2 * kPi - 1e-9; }
  // The azimuth of the head when a column fires, before the ring's offset (rad).
  double azimuth(std::uint32_t column) const;
  // The time at which a column fires, before the ring's offset (s since the start of the revolution).
  double columnTime(std::uint32_t column) const {
    return listed == nullptr ? column * columnPeriod() : columnStart[column / raysPerBeam];
  }
  // The time from column to column (s). A field below a full circle has its first and last column at its two edges.
  double columnPeriod() const {
    const std::uint32_t steps = fullTurn() || columns == 1 ? columns : columns - 1;
    return period * (field / (2 * kPi)) / steps;
  }
};

// Computes direction, origin and time of every beam from the table's compact description.
void fillBeams(BeamTable& table);

// Returns the beams of the revolution that starts at a time (s since the start of the drive). This is the table itself,
// except for rosettes, whose pattern differs from revolution to revolution.
std::shared_ptr<const BeamTable> beamsAt(const std::shared_ptr<const BeamTable>& table, double time);

}  // namespace scanmill
