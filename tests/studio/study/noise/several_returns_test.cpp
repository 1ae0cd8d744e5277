// Recordings whose beams have further returns: the noise is measured of the first ones.

#include "tests/studio/study/noise/noise_scans.h"

namespace scanmill {
namespace {

// A second return behind every third point, `behind` metres farther.
Scan withSecondReturns(const Scan& first, const BeamTable& beams, double behind) {
  Scan scan = first;
  scan.planes = 2;
  scan.position.resize(2 * first.size(), Vec3f{NAN, NAN, NAN});
  for (std::size_t beam = 0; beam < first.size(); beam += 3) {
    scan.position[first.size() + beam] =
        static_cast<Vec3f>(static_cast<Vec3d>(first.position[beam]) + beams.direction[beam] * behind);
  }
  scan[kIntensity].clear();
  for (std::size_t i = 0; i < scan.size(); ++i) scan[kIntensity].push_back(i < first.size() ? 7 : 3);
  for (auto* column : {&scan[kRing], &scan[kColumn]}) column->clear();
  scan[kTime].clear();
  return scan;
}

// As a dense scan has it: the returns of a beam follow each other. Numbered, or not.
Scan denseOf(const Scan& image, bool numbered) {
  Scan scan;
  scan.rings = image.rings;
  scan.columns = image.columns;
  const std::size_t beams = std::size_t{image.rings} * image.columns;
  for (std::size_t beam = 0; beam < beams; ++beam) {
    for (std::size_t i = beam; i < image.size(); i += beams) {
      if (!isFinite(image.position[i])) continue;
      const PointKey key = keyOf(image, i);
      scan.position.push_back(image.position[i]);
      scan[kIntensity].push_back(image[kIntensity][i]);
      scan[kRing].push_back(static_cast<std::uint16_t>(key.ring));
      scan[kColumn].push_back(static_cast<std::uint16_t>(key.column));
      if (numbered) scan[kReturn].push_back(static_cast<std::uint8_t>(key.number + 1));
    }
  }
  return scan;
}

TEST(RangesAlong, TakeTheFirstReturn) {
  const auto beams = wallBeams();
  const Scan first = noisyScan(
      beams, [&](std::size_t beam) { return wallRange(*beams, beam, 12, 0); },
      "[range_noise: {sigma_m: 0.01}, dropout: {probability: 0.1}]", 0);
  const RecordedScan expected = rangesAlong(first, *beams, "first");
  const Scan image = withSecondReturns(first, *beams, 2.5);
  ASSERT_EQ(image.height(), 2 * beams->rings);
  for (const Scan& scan : {image, denseOf(image, true), denseOf(image, false)}) {
    const RecordedScan recorded = rangesAlong(scan, *beams, "both");
    expectSameRanges(recorded, expected, 1e-5);
    ASSERT_EQ(recorded.intensity.size(), beams->size());
    for (std::size_t beam = 0; beam < beams->size(); ++beam) {
      ASSERT_EQ(recorded.intensity[beam], std::isnan(expected.range[beam]) ? 0 : 7) << beam;
    }
  }
}

}  // namespace
}  // namespace scanmill
