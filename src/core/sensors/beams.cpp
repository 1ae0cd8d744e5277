#include "sensors/beams.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace scanmill {

namespace {

// Returns the unit vector with an azimuth and an elevation (rad).
Vec3d towards(double azimuth, double elevation) {
  return {std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation), std::sin(elevation)};
}

void fillListed(BeamTable& table) {
  const ListedBeams& listed = *table.listed();
  table.direction.resize(table.size());
  table.time.resize(table.size());
  for (std::size_t beam = 0; beam < table.size(); ++beam) {
    table.direction[beam] = towards(listed.azimuth[beam], listed.elevation[beam]);
    table.time[beam] = static_cast<float>(listed.time[beam]);
  }
  table.origin = listed.origin;
  table.columnStart = listed.columnStarts(table.columns);
}

// Returns the orientation (rad) at a time (s) of a body that rotates at `speed` (rad/s) from `phase` (rad). Complete
// turns are subtracted first, so that the angle is still exact after hours.
double orientationAt(double speed, double phase, double time) {
  return std::fmod(time * (speed / (2 * kPi)), 1.0) * 2 * kPi + phase;
}

// Returns the direction of a laser's beam that leaves the prisms, and the mirror if there is one, at a time (s since
// the start of the drive).
Vec3d rosetteDirection(const Rosette& rosette, std::uint32_t laser, double time) {
  double left = rosette.left.empty() ? 0 : rosette.left[laser];
  double up = rosette.up.empty() ? 0 : rosette.up[laser];
  for (std::size_t prism = 0; prism < rosette.angle.size(); ++prism) {
    const double orientation = orientationAt(rosette.speed[prism], rosette.phase[prism], time);
    left += rosette.angle[prism] * std::cos(orientation);
    up += rosette.angle[prism] * std::sin(orientation);
  }
  const double deflection = std::hypot(left, up);  // rad, from the sensor's axis
  // A direction at an angle to an axis is cos(angle) along the axis and sin(angle) across it.
  const double sineOverAngle = deflection > 1e-12 ? std::sin(deflection) / deflection : 1;
  if (!rosette.mirror) return {std::cos(deflection), left * sineOverAngle, up * sineOverAngle};
  const Vec3d incoming{left * sineOverAngle, up * sineOverAngle, std::cos(deflection)};
  const double azimuth = orientationAt(rosette.mirror->speed, rosette.mirror->phase, time);
  const Vec3d normal = towards(azimuth, rosette.mirror->tilt - kPi / 2);
  return incoming - normal * (2 * dot(incoming, normal));
}

// Sets direction and time of each beam for the revolution that starts at BeamTable::start. All origins are zero.
void fillRosette(BeamTable& table) {
  table.direction.resize(table.size());
  table.time.resize(table.size());
  table.origin.clear();
  for (std::uint32_t ring = 0; ring < table.rings; ++ring) {
    for (std::uint32_t column = 0; column < table.columns; ++column) {
      const std::size_t beam = std::size_t{ring} * table.columns + column;
      const double sinceStart = table.columnTime(column) + table.firingOffset[ring];
      table.direction[beam] = rosetteDirection(*table.rosette(), ring, table.start + sinceStart);
      table.time[beam] = static_cast<float>(sinceStart);
    }
  }
}

}  // namespace

std::vector<double> ListedBeams::columnStarts(std::uint32_t columns) const {
  std::vector<double> starts(time.begin(), time.begin() + columns);
  for (std::size_t beam = columns; beam < time.size(); ++beam) {
    starts[beam % columns] = std::min(starts[beam % columns], time[beam]);
  }
  return starts;
}

std::shared_ptr<const BeamTable> beamsAt(const std::shared_ptr<const BeamTable>& table, double time) {
  if (!table->changes()) return table;
  auto ofRevolution = std::make_shared<BeamTable>(*table);
  ofRevolution->start = time;
  if (table->rosette() != nullptr) {
    fillBeams(*ofRevolution);
    return ofRevolution;
  }
  // The sector that begins at `time`; times are exact to a small fraction of a sector.
  const double sector = std::fmod(std::round((time - table->start) / table->period), table->sectors);
  const double turned = (table->clockwise ? -2 : 2) * kPi * sector / table->sectors;  // rad
  ofRevolution->firstAzimuth += turned;
  const double cosine = std::cos(turned);
  const double sine = std::sin(turned);
  for (Vec3d& d : ofRevolution->direction) d = {cosine * d.x - sine * d.y, sine * d.x + cosine * d.y, d.z};
  for (Vec3f& o : ofRevolution->origin) {
    o = static_cast<Vec3f>(Vec3d{cosine * o.x - sine * o.y, sine * o.x + cosine * o.y, o.z});
  }
  return ofRevolution;
}

double BeamTable::azimuth(std::uint32_t columnOfRays) const {
  const std::uint32_t column = columnOfRays / raysPerBeam;
  if (const auto beams = listed()) return beams->azimuth[column];
  const std::uint32_t beams = columns / raysPerBeam;
  // In a full revolution the last column is one step before the first azimuth; in a partial field the first and last
  // column are at the two edges, and a single column is in the middle.
  const std::uint32_t steps = fullTurn() ? beams : beams - 1;
  const double fieldFraction = steps == 0 ? 0.5 : static_cast<double>(column) / steps;
  return firstAzimuth + (clockwise ? -field : field) * fieldFraction;
}

// Computes the beams of any pattern. For rings on cones, with the head at encoder angle t, offset a and elevation e of
// the ring, and distance n of the beam origin from the axis:
//   direction = (cos(t + a) cos e, sin(t + a) cos e, sin e),  origin = (n cos t, n sin t, height),
//   point = origin + direction * (range from the beam origin).
// See Ouster, "Sensor Data: Lidar Range to XYZ" (there a is minus beam_azimuth_angles and n is
// lidar_origin_to_beam_origin_mm; the reported range counts from the axis, hence the term range - n there). The offsets
// l and u of a ring add l (-sin(t + a), cos(t + a), 0) + u (-cos(t + a) sin e, -sin(t + a) sin e, cos e) to the origin:
// Velodyne's horizontal and vertical offsets, as velodyne_pointcloud applies them (HDL-64E S2 User's Manual, appendix
// on converting data).
void fillBeams(BeamTable& table) {
  if (table.listed() != nullptr) return fillListed(table);
  if (table.rosette() != nullptr) return fillRosette(table);
  const std::size_t columns = table.columns;
  std::vector<double> cosAzimuth(columns);
  std::vector<double> sinAzimuth(columns);
  for (std::uint32_t column = 0; column < table.columns; ++column) {
    const double azimuth = table.azimuth(column);
    cosAzimuth[column] = std::cos(azimuth);
    sinAzimuth[column] = std::sin(azimuth);
  }

  const bool shifted = !table.originLeft.empty() || !table.originUp.empty();
  const bool offAxis = shifted || table.originOffset != 0 || table.originHeight != 0;
  table.direction.resize(table.size());
  table.origin.resize(offAxis ? table.size() : 0);
  table.time.resize(table.size());
  parallelForEach(table.rings, 1, [&](std::size_t ring) {
    const double cosOffset = std::cos(table.azimuthOffset[ring]);
    const double sinOffset = std::sin(table.azimuthOffset[ring]);
    const double cosElevation = std::cos(table.elevation[ring]);
    const double sinElevation = std::sin(table.elevation[ring]);
    const double leftShift = table.originLeft.empty() ? 0 : table.originLeft[ring];
    const double upShift = table.originUp.empty() ? 0 : table.originUp[ring];
    for (std::size_t column = 0; column < columns; ++column) {
      const std::size_t beam = ring * columns + column;
      // The beam's horizontal direction (x, y): the column's azimuth plus the ring's offset.
      const double x = cosAzimuth[column] * cosOffset - sinAzimuth[column] * sinOffset;
      const double y = sinAzimuth[column] * cosOffset + cosAzimuth[column] * sinOffset;
      table.direction[beam] = {x * cosElevation, y * cosElevation, sinElevation};
      table.time[beam] =
          static_cast<float>(table.columnTime(static_cast<std::uint32_t>(column)) + table.firingOffset[ring]);
      if (offAxis) {
        Vec3d origin{table.originOffset * cosAzimuth[column], table.originOffset * sinAzimuth[column],
                     table.originHeight};
        if (shifted)
          origin = origin + Vec3d{-y, x, 0} * leftShift +
                   Vec3d{-x * sinElevation, -y * sinElevation, cosElevation} * upShift;
        table.origin[beam] = static_cast<Vec3f>(origin);
      }
    }
  });
}

Destagger destagger(std::span<const double> offset, double step, std::uint32_t columns, bool fullTurn) {
  // A number of columns that is added before rounding, so that offsets halfway between two columns are rounded in the
  // same direction in all rings, despite floating-point errors.
  constexpr double kTie = 1e-6;
  std::vector<std::int64_t> shifts;
  shifts.reserve(offset.size());
  for (const double angle : offset) {
    shifts.push_back(step == 0 ? 0 : static_cast<std::int64_t>(std::floor(angle / step + 0.5 + kTie)));
  }
  Destagger image{.shift = {}, .width = columns};
  if (shifts.empty()) return image;
  std::int64_t leastShift = 0;  // stays 0 in a full turn, where the image's columns wrap around
  if (!fullTurn) {
    const auto [least, most] = std::ranges::minmax(shifts);
    leastShift = least;
    image.width += static_cast<std::uint32_t>(most - least);
  }
  const auto width = std::int64_t{image.width};
  for (const std::int64_t shift : shifts) {
    image.shift.push_back(static_cast<std::uint32_t>(((shift - leastShift) % width + width) % width));
  }
  return image;
}

Destagger destagger(const BeamTable& beams) {
  const std::uint32_t columns = beams.columns / beams.raysPerBeam;
  if (!beams.onCones() || columns < 2) return {std::vector<std::uint32_t>(beams.rings), columns};
  const std::uint32_t steps = beams.fullTurn() ? columns : columns - 1;
  const double step = (beams.clockwise ? -beams.field : beams.field) / steps;
  return destagger(beams.azimuthOffset, step, columns, beams.fullTurn());
}

}  // namespace scanmill
