#pragma once

// Scans whose noise is known, as recordings.

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "study/noise/recorded_scan.h"
#include "tests/support/noisy_walls.h"

namespace scanmill {

inline std::vector<RecordedScan> recordedOf(const std::vector<Scan>& scans, const BeamTable& beams) {
  std::vector<RecordedScan> recorded;
  for (const Scan& scan : scans) {
    recorded.push_back(rangesAlong(scan, beams, "scan" + std::to_string(recorded.size()) + ".pcd"));
  }
  return recorded;
}

// A corner of two walls and a floor, seen from a place that moves by `there` (the first scan's frame).
inline std::vector<Scan> cornerScans(const std::shared_ptr<const BeamTable>& beams, const Pose& there) {
  struct Plane {
    Vec3d normal;
    double distance;
  };
  const Plane planes[] = {{{std::cos(radians(40)), std::sin(radians(40)), 0}, 8},
                          {{std::cos(radians(40)), -std::sin(radians(40)), 0}, 9},
                          {{0, 0, -1}, 2}};
  std::vector<Scan> scans;
  for (const Pose& pose : {Pose{}, there}) {
    const auto range = [&](std::size_t beam) {
      const Vec3d o = pose * static_cast<Vec3d>(beams->origin[beam]);
      const Vec3d u = toMatrix(pose.rotation) * beams->direction[beam];
      double nearest = INFINITY;
      for (const Plane& p : planes) {
        const double towards = dot(p.normal, u);
        if (towards > 0) nearest = std::min(nearest, (p.distance - dot(p.normal, o)) / towards);
      }
      return static_cast<float>(nearest);
    };
    scans.push_back(noisyScan(beams, range, "[range_noise: {sigma_m: 0.008}, quantize: {step_m: 0.004}]",
                              static_cast<std::uint32_t>(scans.size())));
  }
  return scans;
}

}  // namespace scanmill
