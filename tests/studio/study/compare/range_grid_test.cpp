#include "study/compare/patches.h"
#include "tests/studio/study/compare/compare_scans.h"

namespace scanmill {
namespace {

// The points of a row, in its order, as their indices in the whole scan.
std::vector<std::uint32_t> rowOf(const RangeGrid& grid, std::uint32_t row) {
  std::vector<std::uint32_t> points;
  for (std::uint32_t c = 0; c < grid.columns; ++c) points.push_back(grid.point[grid.at(row, c)]);
  return points;
}

TEST(RangeGrid, HasAPixelForEachBeam) {
  const Scan scan = flawedScan({}, 1);
  const RangeGrid grid = rangeGrid(scan);
  ASSERT_EQ(grid.rows, kTestRings);
  ASSERT_EQ(grid.columns, kTestColumns);
  EXPECT_TRUE(grid.wraps && grid.knowsRings && grid.knowsMisses);
  for (std::size_t i = 0; i < scan.size(); ++i) {
    ASSERT_EQ(grid.point[grid.at(scan[kRing][i], scan[kColumn][i])], i);
  }
  EXPECT_EQ(grid.beside(3, 0, -1), grid.at(3, kTestColumns - 1));
}

// Whatever the order of rings and however the columns are shifted, neighbours stay neighbours.
TEST(RangeGrid, RingsFromBelowAndStaggeredColumnsChangeNothing) {
  const Scan scan = flawedScan({}, 1);
  Scan other = scan;
  for (std::size_t i = 0; i < other.size(); ++i) {
    const std::uint32_t stagger = 3 * (other[kRing][i] % 4);
    other[kColumn][i] = static_cast<std::uint16_t>((other[kColumn][i] + stagger) % kTestColumns);
    other[kRing][i] = static_cast<std::uint16_t>(kTestRings - 1 - other[kRing][i]);
  }
  const RangeGrid grid = rangeGrid(scan), same = rangeGrid(other);
  const std::vector<std::uint32_t> first = rowOf(grid, 0), shifted = rowOf(same, 0);
  const auto shift = static_cast<std::size_t>(std::ranges::find(shifted, first[0]) - shifted.begin());
  ASSERT_LT(shift, shifted.size());
  for (std::uint32_t r = 0; r < kTestRings; ++r) {
    const std::vector<std::uint32_t> own = rowOf(grid, r), others = rowOf(same, r);
    for (std::size_t c = 0; c < own.size(); ++c) ASSERT_EQ(own[c], others[(c + shift) % own.size()]) << r << " " << c;
  }
}

// Rings alone: points are set down in the order of their azimuths, and beams that are lost leave a gap.
TEST(RangeGrid, ColumnsAreFoundByAzimuth) {
  Scan scan = flawedScan({.lost = 0.1}, 1);
  const RangeGrid exact = rangeGrid(scan);
  scan[kColumn].clear();
  const RangeGrid grid = rangeGrid(scan);
  ASSERT_EQ(grid.columns, kTestColumns);
  EXPECT_TRUE(grid.knowsRings && grid.knowsMisses);
  std::size_t same = 0, filled = 0;
  for (std::uint32_t r = 0; r < kTestRings; ++r) {
    for (std::uint32_t c = 0; c < kTestColumns; ++c) {
      if (grid.point[grid.at(r, c)] == RangeGrid::kNone) continue;
      ++filled;
      same += exact.point[exact.at(r, (c + kTestColumns / 2) % kTestColumns)] == grid.point[grid.at(r, c)] ? 1 : 0;
    }
  }
  EXPECT_GT(filled, scan.size() * 995 / 1000);
  EXPECT_GT(same, filled * 99 / 100);
}

TEST(RangeGrid, WithoutRingsRowsAreStepsOfElevation) {
  Scan scan = flawedScan({}, 1);
  scan[kColumn].clear();
  scan[kRing].clear();
  const RangeGrid grid = rangeGrid(scan);
  EXPECT_FALSE(grid.knowsRings || grid.knowsMisses);
  double before = 1;
  for (std::uint32_t r = 0; r < grid.rows; ++r) {
    for (const std::uint32_t point : rowOf(grid, r)) {
      if (point == RangeGrid::kNone) continue;
      const Vec3d p(scan.position[point]);
      const double sine = p.z / length(p);
      ASSERT_LE(sine, before + 0.01);
      before = sine;
      break;
    }
  }
  EXPECT_EQ(rangeGrid(Scan()).size(), 0u);
}

TEST(RangeGrid, OfSeveralReturnsTheNearestIsTaken) {
  Scan scan = flawedScan({}, 1);
  const std::size_t points = scan.size();
  for (std::size_t i = 0; i < points; i += 7) {  // a second return behind the first, listed before others are
    scan.position.push_back(scan.position[i] * 1.5f);
    for (auto* column : {&scan[kRing], &scan[kColumn], &scan[kLabel]}) column->push_back((*column)[i]);
    scan[kIntensity].push_back(1);
  }
  const RangeGrid grid = rangeGrid(scan);
  for (std::size_t i = 0; i < points; ++i) {
    const std::size_t pixel = grid.at(scan[kRing][i], scan[kColumn][i]);
    ASSERT_EQ(grid.point[pixel], i);
    ASSERT_EQ(grid.returns[pixel], i % 7 == 0 ? 2 : 1);
  }
}

}  // namespace
}  // namespace scanmill
