#include "assets/meshes/asset_parts.h"

namespace scanmill {
namespace {

TEST(Weld, RemovesVerticesThatNoTriangleUsesAndMergesEqualOnes) {
  AssetPart part;
  part.positions = {{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  part.triangles = {{1, 2, 3}, {4, 5, 6}};
  weld(part);
  EXPECT_EQ(part.positions, (std::vector<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}));
  EXPECT_EQ(part.triangles, (std::vector<Triangle>{{0, 1, 2}, {1, 3, 2}}));
}

}  // namespace
}  // namespace scanmill
