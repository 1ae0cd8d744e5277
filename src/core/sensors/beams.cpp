#include "sensors/beams.h"

#include "base/parallel.h"

namespace scanmill {

double BeamTable::azimuth(std::uint32_t ownColumn) const {
  const std::uint32_t column = ownColumn / raysPerBeam;
  const std::uint32_t beams = columns / raysPerBeam;
  // A full revolution ends one step before it began; a partial one is swept from edge to edge.
  double swept = 0.5;
  if (fullTurn()) {
    swept = static_cast<double>(column) / beams;
  } else if (beams > 1) {
    swept = static_cast<double>(column) / (beams - 1);
  }
  return firstAzimuth + (clockwise ? -field : field) * swept;
}

// With the head at encoder angle t, offset a and elevation e of the ring, beam origin distance n:
//   direction = (cos(t + a) cos e, sin(t + a) cos e, sin e),  origin = (n cos t, n sin t, height),
//   point = origin + direction * (range from the beam origin).
// The offsets l and u of a ring add l (-sin(t + a), cos(t + a), 0) + u (-cos(t + a) sin e, -sin(t + a) sin e, cos e):
// Velodyne's horizontal and vertical offsets, as velodyne_pointcloud applies them (HDL-64E S2 User's Manual, appendix
// on converting data).
// Ouster, "Sensor Data: Lidar Range to XYZ" (there a is minus beam_azimuth_angles and n is
// lidar_origin_to_beam_origin_mm; the reported range counts from the axis, hence its range - n).
void fillBeams(BeamTable& table) {
  const std::size_t columns = table.columns;
  std::vector<double> cosine(columns);
  std::vector<double> sine(columns);
  for (std::uint32_t column = 0; column < table.columns; ++column) {
    const double azimuth = table.azimuth(column);
    cosine[column] = std::cos(azimuth);
    sine[column] = std::sin(azimuth);
  }

  const bool own = !table.originLeft.empty() || !table.originUp.empty();
  const bool offAxis = own || table.originOffset != 0 || table.originHeight != 0;
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
          if (own) origin = origin + Vec3d{-y, x, 0} * toLeft + Vec3d{-x * up, -y * up, flat} * toUp;
          table.origin[beam] = static_cast<Vec3f>(origin);
        }
      }
    }
  });
}

}  // namespace scanmill
