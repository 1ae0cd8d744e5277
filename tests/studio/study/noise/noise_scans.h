#pragma once

// Scans whose noise is known, as recordings.

#include <string>
#include <vector>

#include "study/noise/flat_patches.h"
#include "tests/support/noisy_walls.h"

namespace scanmill {

inline std::vector<RecordedScan> recordedOf(const std::vector<Scan>& scans, const BeamTable& beams) {
  std::vector<RecordedScan> recorded;
  for (const Scan& scan : scans) {
    recorded.push_back(rangesAlong(scan, beams, "scan" + std::to_string(recorded.size()) + ".pcd"));
  }
  return recorded;
}

// Both have the same beams with the same ranges (m).
inline void expectSameRanges(const RecordedScan& found, const RecordedScan& expected, double within) {
  EXPECT_EQ(found.returns, expected.returns);
  ASSERT_EQ(found.range.size(), expected.range.size());
  for (std::size_t beam = 0; beam < found.range.size(); ++beam) {
    ASSERT_EQ(std::isnan(found.range[beam]), std::isnan(expected.range[beam])) << beam;
    if (!std::isnan(expected.range[beam])) {
      ASSERT_NEAR(found.range[beam], expected.range[beam], within) << beam;
    }
  }
}

}  // namespace scanmill
