#pragma once

// Recordings of a sensor in a place that is known: a wall across, a floor, and noise that is known too.

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "config/fields.h"
#include "sense/sense.h"
#include "sensors/sensor.h"
#include "tests/support/effects_of.h"

namespace scanmill {

// 64 rings over 22 deg, 256 columns over 90 deg: with stagger and an offset of the beams' origin.
constexpr const char* kWallSensor = R"(# A sensor of a test.
model: wall watcher
source: "a test"
columns: 256
rate_hz: 10
first_azimuth_deg: -45
field_deg: 90
elevation_deg: {top: 6, bottom: -16, rings: 64}
# The stagger.
azimuth_offset_deg: [-2.8, -1.4, 1.4, 2.8]
origin_offset_m: 0.0158
range_m: [0.5, 120]
)";

inline std::shared_ptr<const BeamTable> wallBeams() {
  return makeBeams(parseYaml(kWallSensor, "wall.yaml"));
}

// The nearest of the wall x = distance, turned by `yaw` about the sensor, and the floor z = -2 (m). 0 for no wall.
inline float wallRange(const BeamTable& beams, std::size_t beam, double distance, double yaw) {
  const Vec3d& u = beams.direction[beam];
  const Vec3d o = beams.origin.empty() ? Vec3d{} : static_cast<Vec3d>(beams.origin[beam]);
  const Vec3d normal{std::cos(yaw), std::sin(yaw), 0};
  double range = INFINITY;
  if (distance > 0 && dot(normal, u) > 0) range = (distance - dot(normal, o)) / dot(normal, u);
  if (u.z < 0) range = std::min(range, (-2 - o.z) / u.z);
  return range < beams.maxRange ? static_cast<float>(range) : kMiss;
}

inline Scan noisyScan(const std::shared_ptr<const BeamTable>& beams, const std::function<float(std::size_t)>& range,
                      const std::string& effects, std::uint32_t frame, bool organised = true) {
  Shot shot;
  shot.seed = 77;
  shot.frame = frame;
  shot.beams = beams;
  shot.worldFromSensor.resize(1);
  Hits hits;
  hits.reset(beams->rings, beams->columns, Channel::Range);
  for (std::size_t beam = 0; beam < hits.size(); ++beam) hits.range[beam] = range(beam);
  const Effects made = effectsOf(parseYaml(effects, "effects.yaml"));
  const ScanLayout layout{ColumnSet(kRing, kColumn, kTime), organised};
  Returns scratch;
  Scan scan;
  sense({.effects = made, .layout = layout}, hits, shot, scratch, scan);
  return scan;
}

// Walls at these distances, one a scan, each turned a little more.
inline std::vector<Scan> wallScans(const std::shared_ptr<const BeamTable>& beams, const std::vector<double>& distances,
                                   const std::string& effects) {
  std::vector<Scan> scans;
  for (std::size_t i = 0; i < distances.size(); ++i) {
    const double yaw = radians(-20.0 + 40.0 * static_cast<double>(i) / static_cast<double>(distances.size()));
    scans.push_back(noisyScan(
        beams, [&](std::size_t beam) { return wallRange(*beams, beam, distances[i], yaw); }, effects,
        static_cast<std::uint32_t>(i)));
  }
  return scans;
}

}  // namespace scanmill
