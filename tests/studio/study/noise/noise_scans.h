#pragma once

// Scans whose noise is known, as recordings.

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

}  // namespace scanmill
