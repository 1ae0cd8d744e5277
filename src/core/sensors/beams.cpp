#include "sensors/beams.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace scanmill {

namespace {

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

// Returns the orientation (rad) at a time (s). Complete turns are subtracted first, so that the angle is still exact
// after hours.
double orientationAt(double speed, double phase, double time) {
  return std::fmod(time * (speed / (2 * kPi)), 1.0) * 2 * kPi + phase;
}

// Returns the direction of a laser's beam that leaves the prisms, and the mirror if there is one, at a time (s since
// the start of the drive).
Vec3d rosetteDirection(const Rosette& r, std::uint32_t laser, double time) {
  double left = r.left.empty() ? 0 : r.left[laser];
  double up = r.up.empty() ? 0 : r.up[laser];
  for (std::size_t prism = 0; prism < r.angle.size(); ++prism) {
    const double orientation = orientationAt(r.speed[prism], r.phase[prism], time);
    left += r.angle[prism] * std::cos(orientation);
    up += r.angle[prism] * std::sin(orientation);
  }
  const double deflection = std::hypot(left, up);  // rad, from the sensor's axis
  const double across = deflection > 1e-12 ? std::sin(deflection) / deflection : 1;
  if (!r.mirror) return {std::cos(deflection), left * across, up * across};
  const Vec3d incoming{left * across, up * across, std::cos(deflection)};
  const double azimuth = orientationAt(r.mirror->speed, r.mirror->phase, time);
  const Vec3d normal = towards(azimuth, r.mirror->tilt - kPi / 2);
  return incoming - normal * (2 * dot(incoming, normal));
}

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
  if (table->rosette() == nullptr) return table;
  auto ofRevolution = std::make_shared<BeamTable>(*table);
  ofRevolution->start = time;
  fillBeams(*ofRevolution);
  return ofRevolution;
}

double BeamTable::azimuth(std::uint32_t columnOfRays) const {
  const std::uint32_t column = columnOfRays / raysPerBeam;
  if (const auto beams = listed()) return beams->azimuth[column];
  const std::uint32_t beams = columns / raysPerBeam;
  // In a full revolution the last column is one step before the first azimuth; in a partial field the first and last
  // column are at the two edges.
  double swept = 0.5;
  if (fullTurn()) {
    swept = static_cast<double>(column) / beams;
  } else if (beams > 1) {
    swept = static_cast<double>(column) / (beams - 1);
  }
  return firstAzimuth + (clockwise ? -field : field) * swept;
}

// Computes the beams of rings that lie on cones. With the head at encoder angle t, offset a and elevation e of the
// ring, and distance n of the beam origin from the axis:
//   direction = (cos(t + a) cos e, sin(t + a) cos e, sin e),  origin = (n cos t, n sin t, height),
//   point = origin + direction * (range from the beam origin).
// See Ouster, "Sensor Data: Lidar Range to XYZ" (there a is minus beam_azimuth_angles and n is
// lidar_origin_to_beam_origin_mm; the reported range counts from the axis, hence its range - n).
// The offsets l and u of a ring add l (-sin(t + a), cos(t + a), 0) + u (-cos(t + a) sin e, -sin(t + a) sin e, cos e) to
// the origin: Velodyne's horizontal and vertical offsets, as velodyne_pointcloud applies them (HDL-64E S2 User's
// Manual, appendix on converting data).
void fillBeams(BeamTable& table) {
  if (table.listed() != nullptr) return fillListed(table);
  if (table.rosette() != nullptr) return fillRosette(table);
  const std::size_t columns = table.columns;
  std::vector<double> cosine(columns);
  std::vector<double> sine(columns);
  for (std::uint32_t column = 0; column < table.columns; ++column) {
    const double azimuth = table.azimuth(column);
    cosine[column] = std::cos(azimuth);
    sine[column] = std::sin(azimuth);
  }

  const bool shifted = !table.originLeft.empty() || !table.originUp.empty();
  const bool offAxis = shifted || table.originOffset != 0 || table.originHeight != 0;
  table.direction.assign(table.size(), {});
  table.origin.assign(offAxis ? table.size() : 0, {});
  table.time.assign(table.size(), 0.0f);
  parallelFor(table.rings, 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t ring = first; ring < last; ++ring) {
      const double cosOffset = std::cos(table.azimuthOffset[ring]);
      const double sinOffset = std::sin(table.azimuthOffset[ring]);
      const double flat = std::cos(table.elevation[ring]);
      const double up = std::sin(table.elevation[ring]);
      const double toLeft = table.originLeft.empty() ? 0 : table.originLeft[ring];
      const double toUp = table.originUp.empty() ? 0 : table.originUp[ring];
      for (std::size_t column = 0; column < columns; ++column) {
        const std::size_t beam = ring * columns + column;
        const double x = cosine[column] * cosOffset - sine[column] * sinOffset;
        const double y = sine[column] * cosOffset + cosine[column] * sinOffset;
        table.direction[beam] = {x * flat, y * flat, up};
        table.time[beam] =
            static_cast<float>(table.columnTime(static_cast<std::uint32_t>(column)) + table.firingOffset[ring]);
        if (offAxis) {
          Vec3d origin{table.originOffset * cosine[column], table.originOffset * sine[column], table.originHeight};
          if (shifted) origin = origin + Vec3d{-y, x, 0} * toLeft + Vec3d{-x * up, -y * up, flat} * toUp;
          table.origin[beam] = static_cast<Vec3f>(origin);
        }
      }
    }
  });
}

Destagger destagger(std::span<const double> offset, double step, std::uint32_t columns, bool fullTurn) {
  // Added before rounding (columns), so that offsets halfway between two columns are rounded in the same direction in
  // all rings, despite floating-point errors.
  constexpr double kTie = 1e-6;
  std::vector<std::int64_t> shifts;
  shifts.reserve(offset.size());
  for (const double angle : offset) {
    shifts.push_back(step == 0 ? 0 : static_cast<std::int64_t>(std::floor(angle / step + 0.5 + kTie)));
  }
  Destagger image{{}, columns};
  if (shifts.empty()) return image;
  std::int64_t zero = 0;
  if (!fullTurn) {
    const auto [least, most] = std::ranges::minmax(shifts);
    zero = least;
    image.width += static_cast<std::uint32_t>(most - least);
  }
  const auto width = std::int64_t{image.width};
  for (const std::int64_t shift : shifts) {
    image.shift.push_back(static_cast<std::uint32_t>(((shift - zero) % width + width) % width));
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
