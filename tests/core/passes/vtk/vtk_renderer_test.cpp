// VTK's images against closed forms, and against a reference that intersects every triangle in double precision.

#include <limits>
#include <map>

#include "passes/renderer.h"
#include "tests/core/passes/vtk/drawing.h"
#include "tests/support/gl.h"
#include "tests/support/sanitizers.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

// A step of 3 cm at up to 200 m: which surface is nearer, the rasteriser's own depth must tell.
TEST(VtkRenderer, CurbsAreSeenFarAway) {
  SceneBuilder builder = testBuilder();
  Mesh road = meshOf(builder, "ground");
  appendPlane(road, 0, {}, 1000, 1000);
  Mesh walk = meshOf(builder, "thing");
  appendPlane(walk, 0, at(0, 250, 0.03), 1000, 500);
  builder.place(builder.addMesh(std::move(road)), {}, "road");
  builder.place(builder.addMesh(std::move(walk)), {}, "walk");
  const Scene scene = builder.finish();
  RENDERER_OR_SKIP(renderer, scene);
  const Camera camera = cameraAt({0, 0, 1.9}, 0, 0, 0, 512, 512, 120);
  expectLikeReference(scene, camera, {0.01, 200}, drawnOne(*renderer, camera, {0.01, 200}));
}

TEST(VtkRenderer, SeesAllOfARoomFromInside) {
  for (const double size : {4.0, 300.0, 9000.0}) {  // the larger ones are drawn in pieces
    const Scene scene = oneMeshScene(
        "thing",
        [&](Mesh& room) {
          appendBox(room, 0, {}, {size, size * 0.75, size * 0.5});
        },
        at(1, 2, 3));
    RENDERER_OR_SKIP(renderer, scene);
    for (const double yaw : {0.0, 77.0, 190.0}) {
      const Camera camera = cameraAt({1.3, 2.1, 2.8}, yaw, 20, 5, 97, 64, 130);
      const DrawLimits limits{0.001, 20000};
      expectLikeReference(scene, camera, limits, drawnOne(*renderer, camera, limits));
    }
  }
}

TEST(VtkRenderer, EveryPixelSeesWhatALineOfSightMeets) {
  const Scene scene = randomScene();
  RENDERER_OR_SKIP(renderer, scene);
  for (const double field : {10.0, 45.0, 90.0, 120.0, 170.0}) {
    const Camera camera = cameraAt({-9, 1, 0.5}, 5, 3, 20, 96, 80, field);
    expectLikeReference(scene, camera, {}, drawnOne(*renderer, camera));
  }
  const Camera inside = cameraAt({0.1, 0.2, 0.3}, 100, -30, 0, 96, 80, 110);
  expectLikeReference(scene, inside, {}, drawnOne(*renderer, inside));
}

TEST(VtkRenderer, NearAndFarEndsAreSharp) {
  const Scene scene = randomScene();
  RENDERER_OR_SKIP(renderer, scene);
  const Camera camera = cameraAt({-1, 0.5, 0}, 10, 5, 0, 96, 96, 100);
  for (const DrawLimits& limits : {DrawLimits{1e-3, 10}, {1e-3, 1e4}, {1, 10}, {1, 1e4}, {0.3, 2.5}, {2, 3}}) {
    expectLikeReference(scene, camera, limits, drawnOne(*renderer, camera, limits));
  }
}

TEST(VtkRenderer, FarScenesAreAsSharpAsNearOnes) {
  const Scene scene = randomScene({}, 400);
  RENDERER_OR_SKIP(renderer, scene);
  const Camera camera = cameraAt({-4000, 100, 50}, 0, 0, 0, 96, 96, 60);
  expectLikeReference(scene, camera, {0.01, 1e4}, drawnOne(*renderer, camera, {0.01, 1e4}));
}

TEST(VtkRenderer, SensorsFarFromTheOriginSeeTheSame) {
  const Vec3d far{1e7, -2e6, 512};
  const Scene here = randomScene();
  const Scene there = randomScene(far);
  RENDERER_OR_SKIP(renderer, here);
  const auto moved = makeVtkRenderer(there);
  Camera camera = cameraAt({-9, 1, 0.5}, 5, 3, 20, 160, 120, 90);
  const PassPlanes near = drawnOne(*renderer, camera);
  camera.worldFromCamera.translation += far;
  EXPECT_TRUE(same(near, drawnOne(*moved, camera)));
  EXPECT_GT(seenPixels(near), camera.pixels() / 4);
}

// A mesh whose own coordinates are those of a map.
TEST(VtkRenderer, MeshesFarFromTheirOriginAreSharp) {
  SceneBuilder builder = testBuilder();
  Mesh mesh = meshOf(builder, "thing");
  appendSphere(mesh, 0, at(500000, 16384, 0), 3, 16);
  builder.place(builder.addMesh(std::move(mesh)), at(-500000, -16384, 0), "ball");
  const Scene scene = builder.finish();
  RENDERER_OR_SKIP(renderer, scene);
  const Camera camera = cameraAt({-8, 0, 0}, 0, 0, 0, 96, 96, 60);
  expectLikeReference(scene, camera, {}, drawnOne(*renderer, camera));
}

// A card of 8 x 8 texels, of which some let the view pass to the wall behind, repeated 2.5 times.
TEST(VtkRenderer, CutOutsLetTheViewPass) {
  auto texture = std::make_shared<Texture>();
  texture->width = 8;
  texture->height = 5;
  texture->hasAlpha = true;
  for (std::uint32_t i = 0; i < 40; ++i) {
    const auto alpha = static_cast<std::uint8_t>(uniform(i, 0, 256));
    texture->rgba.insert(texture->rgba.end(), {0, 0, 0, alpha});
  }
  SceneBuilder builder = testBuilder();
  Mesh wall = meshOf(builder, "other");
  appendPlane(wall, 0, {toMatrix(fromYawPitchRoll(0, -kPi / 2, 0)), {9, 0, 0}}, 40, 40);
  Mesh card = meshOf(builder, "thing");
  for (const float cutoff : {0.5f, 0.2f}) {
    Material leaves;
    leaves.name = "leaves";
    leaves.texture = texture;
    leaves.alphaTested = true;
    leaves.alphaCutoff = cutoff;
    Surface surface = card.surfaces[0];
    surface.material = builder.addMaterial(leaves);
    card.surfaces.push_back(surface);
  }
  for (std::uint16_t side = 0; side < 3; ++side) {  // opaque, and two kinds of leaves
    const double y = 4.0 - 3 * side;
    appendQuad(card, side, {5, y, -2}, {5, y - 2.5, -2}, {5.5, y - 2.5, 2}, {5.5, y, 2});
  }
  card.uvs.clear();
  for (int side = 0; side < 3; ++side) {
    card.uvs.insert(card.uvs.end(), {{-0.75f, -1}, {1.75f, -1}, {1.75f, 1.5f}, {-0.75f, 1.5f}});
  }
  builder.place(builder.addMesh(std::move(wall)), {}, "wall");
  const std::uint32_t index = builder.addMesh(std::move(card));
  builder.place(index, {}, "card");
  const Scene scene = builder.finish();
  RENDERER_OR_SKIP(renderer, scene);
  const Camera camera = cameraAt({0, 0, 0}, 0, 0, 0, 160, 120, 90);
  const PassPlanes planes = drawnOne(*renderer, camera);
  expectLikeReference(scene, camera, {}, planes);
  std::map<std::uint32_t, int> seen;  // per triangle of the card
  for (std::size_t i = 0; i < planes.size(); ++i) {
    if (planes.instance[i] == 2) ++seen[planes.primitive[i] / 2];
  }
  EXPECT_GT(seen[0], seen[2]);
  EXPECT_GT(seen[2], seen[1]);
  EXPECT_GT(seen[1], 100);
}

// Boxes on a grid, turned and unevenly scaled: with a reach, what lies within it is seen as without, and what lies well
// beyond it is not drawn.
TEST(VtkRenderer, LeavesOutWhatIsBeyondItsReach) {
  SceneBuilder builder = testBuilder();
  Mesh mesh = meshOf(builder, "thing");
  appendBox(mesh, 0, {}, {1, 1, 1});
  const std::uint32_t box = builder.addMesh(std::move(mesh));
  for (int x = 5; x <= 60; x += 5) {
    for (int y = -60; y <= 60; y += 5) {
      const Mat3 turned = toMatrix(fromYawPitchRoll(x, 0.2, 0.1));
      const Mat3 shape = x % 2 == 0 ? Mat3::scale({1, 1, 1}) : Mat3::scale({1, 2, 0.5});
      builder.place(box, {turned * shape, {double(x), double(y), 0.3 * (x % 7) - 1}}, "box");
    }
  }
  const Scene scene = builder.finish();
  RENDERER_OR_SKIP(renderer, scene);
  Camera camera = squareCamera(512, 128, radians(130));
  camera.worldFromCamera.rotation = vehicleFromOptical();
  constexpr double kReach = 40;
  const auto depths = [&](double reach) {
    const auto source = renderer->draw({camera}, {0.01, 100, reach}, {});
    return readAll(*source, {}).front().planes.depth;
  };
  const std::vector<float> all = depths(std::numeric_limits<double>::infinity());
  const std::vector<float> within = depths(kReach);
  std::size_t beyond = 0;
  for (std::uint32_t row = 0; row < camera.height; ++row) {
    for (std::uint32_t column = 0; column < camera.width; ++column) {
      const std::size_t i = std::size_t{row} * camera.width + column;
      const double distance = all[i] * length(camera.ray(column + 0.5, row + 0.5));
      if (distance <= kReach) {
        EXPECT_EQ(within[i], all[i]);
      }
      if (distance > kReach + 4) {  // no box is so long
        EXPECT_EQ(within[i], kNoDepth);
      }
      beyond += std::isfinite(distance) && distance > kReach + 4 ? 1 : 0;
    }
  }
  EXPECT_GT(beyond, 500u);
}

}  // namespace
}  // namespace scanmill
