#pragma once

// Scans whose noise is known, as recordings.

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "study/noise/fit_noise.h"
#include "study/noise/noise_comparison.h"
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

// A recording of walls that was simulated, and what is fitted to it.
struct FittedWalls {
  std::shared_ptr<const BeamTable> beams = wallBeams();
  std::vector<RecordedScan> scans =
      recordedOf(wallScans(beams, {9, 9.2},
                           "[range_noise: {sigma_m: 0.012}, dropout: {probability: 0.02}, quantize: {step_m: 0.008}]"),
                 *beams);
  std::vector<FlatPatch> patches = findFlatPatches(*beams, scans);
  NoiseFit fit = fitNoise(*beams, scans, patches);
  std::string effects = effectsYaml(fit, "today");
  std::vector<ResidualComparison> comparison = compareNoise(*beams, scans, patches, fit, effects);
};

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
