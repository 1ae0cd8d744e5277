#include "assets/meshes/asset_parts.h"

namespace scanmill {
namespace {

TEST(Weld, RemovesVerticesThatNoTriangleUsesAndMergesEqualOnes) {
  std::vector<Vec3f> positions{{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  std::vector<Vec2f> uvs;
  std::vector<Triangle> triangles{{1, 2, 3}, {4, 5, 6}};
  weld(positions, uvs, triangles);
  EXPECT_EQ(positions, (std::vector<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}));
  EXPECT_EQ(triangles, (std::vector<Triangle>{{0, 1, 2}, {1, 3, 2}}));
}

}  // namespace
}  // namespace scanmill
