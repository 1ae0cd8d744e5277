#include "passes/vtk/vtk_geometry.h"

#include <set>

#include "passes/renderer.h"
#include "tests/core/passes/vtk/drawing.h"
#include "tests/support/gl.h"
#include "tests/support/message_of.h"
#include "tests/support/sanitizers.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

TEST(VtkGeometry, HoldsEveryTriangleAndItsPieces) {
  SceneBuilder builder = testBuilder();
  Mesh mesh = meshOf(builder, "ground");
  appendSphere(mesh, 0, {}, 5, 128);              // more than a chunk
  appendPlane(mesh, 0, at(0, 0, 9), 1000, 1000);  // larger than a piece
  const std::size_t triangles = mesh.triangles.size();
  const std::uint32_t index = builder.addMesh(std::move(mesh));
  builder.place(index, {}, "once");
  builder.place(index, at(1, 2, 3), "twice");
  const Scene scene = builder.finish();
  const ViewGeometry geometry = buildViewGeometry(scene, 1u << 20);
  const ViewBatch& batch = geometry.solid;
  EXPECT_TRUE(geometry.cut.original.empty());
  EXPECT_EQ(std::set<std::uint32_t>(batch.original.begin(), batch.original.end()).size(), triangles);
  EXPECT_EQ(batch.positions.size(), batch.original.size() * 9);
  double area = 0;
  std::uint32_t next = 0;
  for (const ViewChunk& chunk : batch.chunks) {
    EXPECT_EQ(chunk.firstTriangle, next);
    next += chunk.triangles;
    for (std::uint32_t t = chunk.firstTriangle; t < next; ++t) {
      const float* p = &batch.positions[std::size_t{t} * 9];
      const Vec3d a{p[0], p[1], p[2]};
      const Vec3d b{p[3], p[4], p[5]};
      const Vec3d c{p[6], p[7], p[8]};
      for (const Vec3d& corner : {a, b, c}) {
        EXPECT_TRUE(corner.x >= double{chunk.low.x} && corner.y >= double{chunk.low.y} &&
                    corner.z >= double{chunk.low.z} && corner.x <= double{chunk.high.x} &&
                    corner.y <= double{chunk.high.y} && corner.z <= double{chunk.high.z});
      }
      EXPECT_LE(std::max({length(b - a), length(c - b), length(a - c)}), 256.0 + 1e-3);
      if (batch.original[t] >= triangles - 2) area += length(cross(b - a, c - a)) / 2;
    }
  }
  EXPECT_EQ(next, batch.original.size());
  EXPECT_NEAR(area, 1e6, 1e-3);
  EXPECT_THAT(messageOf<Error>([&] { buildViewGeometry(scene, 100); }), testing::HasSubstr("more than the 100"));
}

}  // namespace
}  // namespace scanmill
