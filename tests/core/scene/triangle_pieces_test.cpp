#include "scene/triangle_pieces.h"

#include <map>
#include <random>
#include <vector>

namespace scanmill {
namespace {

using Corners = std::array<Vec3d, 3>;
using Voxel = std::array<std::int64_t, 3>;

const VoxelRange kRange{{0, 0, 0}, {20, 15, 10}};

double areaOf(const Corners& c) {
  return length(cross(c[1] - c[0], c[2] - c[0])) / 2;
}

std::map<Voxel, double> piecesOf(const Corners& corners, const VoxelRange& range = kRange) {
  std::map<Voxel, double> pieces;
  std::vector<Voxel> order;
  forEachPiece(corners, range, [&](const Voxel& voxel, double area) {
    EXPECT_GT(area, 0);
    EXPECT_TRUE(pieces.emplace(voxel, area).second) << "each voxel once";
    order.push_back(voxel);
  });
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
  return pieces;
}

double sumOf(const std::map<Voxel, double>& pieces) {
  double sum = 0;
  for (const auto& [voxel, area] : pieces) sum += area;
  return sum;
}

Corners someTriangle(std::mt19937& random, double low, double high, double size) {
  std::uniform_real_distribution<double> place(low, high);
  std::uniform_real_distribution<double> offset(-size, size);
  const Vec3d first{place(random) * 20, place(random) * 15, place(random) * 10};
  const auto near = [&] { return first + Vec3d{offset(random), offset(random), offset(random)}; };
  return {first, near(), near()};
}

TEST(TrianglePieces, AreasAddUpToTheTriangle) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> tiny(-1e-13, 1e-13);
  const auto shaken = [&](const Vec3d& p) { return p + Vec3d{tiny(random), tiny(random), tiny(random)}; };
  for (int i = 0; i < 20000; ++i) {
    // Needles and slivers along diagonals too, where rounding does its worst.
    const Corners sliver{shaken({1, 1, 1}), shaken({9, 9, 9}), shaken({5, 5, 5})};
    for (const Corners& corners : {someTriangle(random, 0.25, 0.75, i % 2 == 0 ? 2 : 0.2), sliver}) {
      EXPECT_NEAR(sumOf(piecesOf(corners)), areaOf(corners), 1e-12);
    }
  }
}

TEST(TrianglePieces, AVoxelHasAPieceWhereAPointOfTheTriangleIsInIt) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 500; ++i) {
    const Corners c = someTriangle(random, 0.25, 0.75, 2);
    const std::map<Voxel, double> pieces = piecesOf(c);
    std::map<Voxel, int> sampled;
    for (int k = 0; k < 2000; ++k) {
      double u = unit(random);
      double v = unit(random);
      if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
      }
      const Vec3d p = c[0] + (c[1] - c[0]) * u + (c[2] - c[0]) * v;
      ++sampled[{static_cast<std::int64_t>(p.x), static_cast<std::int64_t>(p.y), static_cast<std::int64_t>(p.z)}];
    }
    for (const auto& [voxel, times] : sampled) EXPECT_TRUE(pieces.contains(voxel)) << times;
    for (const auto& [voxel, area] : pieces) {
      EXPECT_TRUE(area < 0.02 * areaOf(c) || sampled.contains(voxel)) << area;
    }
  }
}

// What lies in a face belongs to the voxel above it, what ends at one to the voxel below.
TEST(TrianglePieces, LieInOneOfTheVoxelsAtAFace) {
  const auto only = [](const Corners& corners) {
    std::vector<Voxel> voxels;
    for (const auto& [voxel, area] : piecesOf(corners)) voxels.push_back(voxel);
    return voxels;
  };
  EXPECT_THAT(only({Vec3d{2.2, 3.2, 4}, {2.8, 3.2, 4}, {2.2, 3.8, 4}}), testing::ElementsAre(Voxel{2, 3, 4}));
  EXPECT_THAT(only({Vec3d{2, 3, 4}, {3, 3, 4}, {2, 4, 4}}), testing::ElementsAre(Voxel{2, 3, 4}));
  EXPECT_THAT(only({Vec3d{2.5, 3.5, 4.2}, {3, 3.5, 4.2}, {3, 3.7, 4.8}}), testing::ElementsAre(Voxel{2, 3, 4}))
      << "one edge touches the next";
  EXPECT_THAT(only({Vec3d{2.5, 3.5, 5}, {2.9, 3.5, 4.2}, {2.5, 3.7, 4.8}}), testing::ElementsAre(Voxel{2, 3, 4}))
      << "one corner touches the next";
}

TEST(TrianglePieces, OfARangeAreThoseOfTheWholeInIt) {
  std::mt19937 random(4);
  const VoxelRange everything{{-100, -100, -100}, {100, 100, 100}};
  for (int i = 0; i < 5000; ++i) {
    const Corners corners = someTriangle(random, -0.2, 1.2, 6);
    std::map<Voxel, double> expected = piecesOf(corners, everything);
    EXPECT_NEAR(sumOf(expected), areaOf(corners), 1e-11);
    std::erase_if(expected, [](const auto& piece) {
      for (std::size_t k = 0; k < 3; ++k) {
        if (piece.first[k] < kRange.low[k] || piece.first[k] >= kRange.high[k]) return true;
      }
      return false;
    });
    const std::map<Voxel, double> pieces = piecesOf(corners);
    // Pieces of next to nothing may come and go with rounding.
    for (const auto& [voxel, area] : expected) {
      EXPECT_NEAR(pieces.contains(voxel) ? pieces.at(voxel) : 0, area, 1e-12);
    }
    EXPECT_NEAR(sumOf(pieces), sumOf(expected), 1e-11);
  }
}

}  // namespace
}  // namespace scanmill
