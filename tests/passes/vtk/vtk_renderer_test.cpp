// VTK's images against closed forms, and against a reference that intersects every triangle in double precision.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <set>
#include <thread>

#include "base/random.h"
#include "passes/renderer.h"
#include "passes/vtk/vtk_geometry.h"
#include "passes/vtk/vtk_loader.h"
#include "tests/passes/ray_reference.h"
#include "tests/support/gl.h"
#include "tests/support/message_of.h"
#include "tests/support/sanitizers.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

const PassChoice kIds{Channels(Channel::Instance) | Channel::Primitive | Channel::Normal | Channel::Material, false};

#define RENDERER_OR_SKIP(name, scene)                              \
  const std::unique_ptr<PassRenderer> name = vtkRendererOf(scene); \
  if (name == nullptr) GTEST_SKIP() << "this machine has no OpenGL 4.3 by EGL"

Camera cameraAt(const Vec3d& position, double yawDeg, double pitchDeg, double rollDeg, std::uint32_t width,
                std::uint32_t height, double fieldDeg) {
  Camera camera = squareCamera(width, height, radians(fieldDeg));
  const Quat heading = fromYawPitchRoll(radians(yawDeg), radians(pitchDeg), radians(rollDeg));
  camera.worldFromCamera = {heading * vehicleFromOptical(), position};
  camera.name = "test";
  return camera;
}

std::vector<PassImage> drawn(PassRenderer& renderer, const std::vector<Camera>& cameras, const DrawLimits& limits,
                             PassChoice choice = kIds) {
  const auto source = renderer.draw(cameras, limits, choice);
  return readAll(*source, choice);
}

PassPlanes drawnOne(PassRenderer& renderer, const Camera& camera, const DrawLimits& limits = {}) {
  return drawn(renderer, {camera}, limits).front().planes;
}

bool same(const PassPlanes& a, const PassPlanes& b) {
  return a.depth == b.depth && a.instance == b.instance && a.primitive == b.primitive && a.normal == b.normal &&
         a.material == b.material;
}

std::size_t seenPixels(const PassPlanes& planes) {
  return static_cast<std::size_t>(
      std::count_if(planes.depth.begin(), planes.depth.end(), [](float depth) { return depth != kNoDepth; }));
}

// Numbers in [low, high) that follow from their index.
double uniform(std::uint32_t index, double low, double high) {
  const RandomBlock block = randomBlock({.seed = 7, .beam = index});
  return low + (high - low) * (block[0] / 4294967296.0);
}

Vec3d uniformPoint(std::uint32_t& index, double reach) {
  const double x = uniform(index++, -reach, reach);
  const double y = uniform(index++, -reach, reach);
  return {x, y, uniform(index++, -reach, reach)};
}

// Loose triangles around the origin, in meshes placed turned, stretched and mirrored.
Scene randomScene(const Vec3d& where = {}, double size = 1) {
  SceneBuilder builder = testBuilder();
  std::uint32_t next = 0;
  for (int m = 0; m < 3; ++m) {
    Mesh mesh = meshOf(builder, "thing");
    for (int t = 0; t < 25; ++t) {
      const Vec3d middle = uniformPoint(next, 6 * size);
      for (int corner = 0; corner < 3; ++corner) {
        mesh.positions.push_back(Vec3f(middle + uniformPoint(next, 2 * size)));
      }
      const auto first = static_cast<std::uint32_t>(3 * t);
      mesh.triangles.push_back({first, first + 1, first + 2});
      mesh.surfaceOf.push_back(0);
    }
    const std::uint32_t index = builder.addMesh(std::move(mesh));
    for (int i = 0; i < 2; ++i) {
      const Mat3 turn =
          toMatrix(fromYawPitchRoll(uniform(next, -3, 3), uniform(next + 1, -1, 1), uniform(next + 2, -1, 1)));
      next += 3;
      const Mat3 stretch = Mat3::scale({i == 0 ? 1.0 : -0.7, 1.3, 0.9});
      const Vec3d offset = uniformPoint(next, 2 * size);
      const Vec3d exact{std::round(offset.x * 64) / 64, std::round(offset.y * 64) / 64, std::round(offset.z * 64) / 64};
      builder.place(index, {turn * stretch, where + exact}, "placed");
    }
  }
  return builder.finish();
}

// Pixels decided by less than this (px) may go either way: vertices lie on a grid of 1/256 px.
constexpr double kEdge = 0.01;

// Every pixel sees what the reference sees at its centre, or, where an edge is that near, around it.
void expectLikeReference(const Scene& scene, const Camera& camera, const DrawLimits& limits, const PassPlanes& planes) {
  const RayReference reference(scene);
  std::vector<std::vector<ReferencePixel>> around;
  for (const auto& [dx, dy] :
       {std::pair{0., 0.}, {1., 0.}, {-1., 0.}, {0., 1.}, {0., -1.}, {.7, .7}, {-.7, .7}, {.7, -.7}, {-.7, -.7}}) {
    Camera moved = camera;
    moved.cx += dx * kEdge;
    moved.cy += dy * kEdge;
    around.push_back(reference.draw(moved, limits));
  }
  std::size_t clear = 0;
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < camera.pixels(); ++i) {
    const auto matches = [&](const ReferencePixel& pixel) {
      if (pixel.instance == 0) return planes.depth[i] == kNoDepth;
      return planes.instance[i] == scene.instances[pixel.instance - 1].firstInstanceId &&
             planes.primitive[i] == pixel.triangle;
    };
    const ReferencePixel& middle = around.front()[i];
    const bool decided = std::all_of(around.begin(), around.end(), [&](const auto& image) {
      return image[i].instance == middle.instance && image[i].triangle == middle.triangle;
    });
    if (!decided) {
      wrong += std::none_of(around.begin(), around.end(), [&](const auto& image) { return matches(image[i]); });
      continue;
    }
    ++clear;
    if (!matches(middle)) {
      ++wrong;
    } else if (middle.instance != 0) {
      ASSERT_NEAR(planes.depth[i], middle.depth, 1e-7 * middle.depth) << "pixel " << i;
    }
  }
  EXPECT_EQ(wrong, 0u);
  EXPECT_GT(clear, camera.pixels() / 2);
}

TEST(VtkRenderer, GroundIsExactToTheHorizon) {
  SceneBuilder builder = testBuilder();
  Mesh mesh = meshOf(builder, "ground");
  appendPlane(mesh, 0, {}, 1000, 1000);
  builder.place(builder.addMesh(std::move(mesh)), at(3, -2, 0), "ground");
  const Scene scene = builder.finish();
  RENDERER_OR_SKIP(renderer, scene);
  for (const double field : {10.0, 60.0, 120.0, 170.0}) {
    const Camera camera = cameraAt({0, 0, 1.9}, 30, 0, 0, 256, 200, field);
    const PassPlanes planes = drawnOne(*renderer, camera, {0.01, 200});
    for (std::size_t i = 0; i < camera.pixels(); ++i) {
      const double below = static_cast<double>(i / camera.width) + 0.5 - camera.cy;
      const double depth = below > 0 ? 1.9 * camera.fy / below : 1e9;
      if (depth > 200 * (1 + 1e-6)) {
        ASSERT_EQ(planes.depth[i], kNoDepth) << field << " degrees, pixel " << i;
      } else if (depth < 200 * (1 - 1e-6)) {
        ASSERT_NEAR(planes.depth[i], depth, 1e-7 * depth) << field << " degrees, pixel " << i;
        ASSERT_EQ(planes.normal[i], (Vec3f{0, 0, 1}));
      }
    }
  }
}

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

TEST(VtkRenderer, SphereKeepsToItsTessellation) {
  SceneBuilder builder = testBuilder();
  Mesh mesh = meshOf(builder, "thing");
  constexpr int kSegments = 64;
  appendSphere(mesh, 0, {}, 2, kSegments);
  builder.place(builder.addMesh(std::move(mesh)), at(10, 0, 1), "ball");
  const Scene scene = builder.finish();
  RENDERER_OR_SKIP(renderer, scene);
  const Camera camera = cameraAt({0, 0, 1}, 0, 0, 0, 128, 128, 40);
  const PassPlanes planes = drawnOne(*renderer, camera);
  // The tessellation's points lie between the sphere and the inscribed one that touches its faces.
  const double inner = 2 * std::pow(std::cos(kPi / kSegments), 2);
  const Vec3d center{0, 0, 10};  // camera axes
  std::size_t hits = 0;
  for (std::size_t i = 0; i < camera.pixels(); ++i) {
    const Vec3d ray = camera.ray(static_cast<double>(i % 128) + 0.5, static_cast<double>(i / 128) + 0.5);
    const double miss = length(cross(ray, center)) / length(ray);  // of the sphere's centre
    if (miss < inner * 0.999) {
      ASSERT_NE(planes.depth[i], kNoDepth) << "pixel " << i;
    }
    if (miss > 2) {
      ASSERT_EQ(planes.depth[i], kNoDepth) << "pixel " << i;
    }
    if (planes.depth[i] == kNoDepth) continue;
    ++hits;
    const double r = length(ray * double{planes.depth[i]} - center);
    ASSERT_GE(r, inner - 1e-5);
    ASSERT_LE(r, 2 + 1e-5);
  }
  EXPECT_GT(hits, 1000u);
}

TEST(VtkRenderer, SeesAllOfARoomFromInside) {
  for (const double size : {4.0, 300.0, 9000.0}) {  // the larger ones are drawn in pieces
    SceneBuilder builder = testBuilder();
    Mesh mesh = meshOf(builder, "thing");
    appendBox(mesh, 0, {}, {size, size * 0.75, size * 0.5});
    builder.place(builder.addMesh(std::move(mesh)), at(1, 2, 3), "room");
    const Scene scene = builder.finish();
    RENDERER_OR_SKIP(renderer, scene);
    const Vec3d half{size / 2, size * 0.375, size * 0.25};
    for (const double yaw : {0.0, 77.0, 190.0}) {
      const Camera camera = cameraAt({1.3, 2.1, 2.8}, yaw, 20, 5, 97, 64, 130);
      const Mat3 turn = toMatrix(camera.worldFromCamera.rotation);
      const PassPlanes planes = drawnOne(*renderer, camera, {0.001, 20000});
      const auto depthAt = [&](double u, double v) {
        const Vec3d ray = turn * camera.ray(u, v);
        const Vec3d from = camera.worldFromCamera.translation - Vec3d{1, 2, 3};
        const auto wall = [](double position, double direction, double reach) {
          return (std::copysign(reach, direction) - position) / direction;
        };
        return std::min({wall(from.x, ray.x, half.x), wall(from.y, ray.y, half.y), wall(from.z, ray.z, half.z)});
      };
      for (std::size_t i = 0; i < camera.pixels(); ++i) {
        const double u = static_cast<double>(i % camera.width) + 0.5;
        const double v = static_cast<double>(i / camera.width) + 0.5;
        const double around[] = {depthAt(u - kEdge, v), depthAt(u + kEdge, v), depthAt(u, v - kEdge),
                                 depthAt(u, v + kEdge)};
        const double exact = depthAt(u, v);
        const auto [low, high] = std::minmax_element(std::begin(around), std::end(around));
        const double slack = 2e-7 * exact + (*high - *low);  // where walls meet, either may be seen
        ASSERT_NEAR(planes.depth[i], exact, slack) << size << " m, pixel " << i;
      }
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

// Limits are depths: a wall just before the far one is seen out to the corners, where its distance is larger.
TEST(VtkRenderer, LimitsAreDepths) {
  SceneBuilder builder = testBuilder();
  Mesh mesh = meshOf(builder, "thing");
  appendPlane(mesh, 0, {toMatrix(fromYawPitchRoll(0, -kPi / 2, 0)), {9, 0, 0}}, 100, 100);
  builder.place(builder.addMesh(std::move(mesh)), {}, "wall");
  const Scene scene = builder.finish();
  RENDERER_OR_SKIP(renderer, scene);
  const Camera camera = cameraAt({}, 0, 0, 0, 40, 30, 120);
  for (const DrawLimits& limits : {DrawLimits{0.01, 9.001}, {8.999, 1000}, {8.999, 9.001}}) {
    EXPECT_EQ(seenPixels(drawnOne(*renderer, camera, limits)), camera.pixels());
  }
  for (const DrawLimits& limits : {DrawLimits{0.01, 8.999}, {9.001, 1000}}) {
    EXPECT_EQ(seenPixels(drawnOne(*renderer, camera, limits)), 0u);
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

TEST(VtkRenderer, DrawsTheSameBytesAgain) {
  const Scene scene = randomScene();
  RENDERER_OR_SKIP(renderer, scene);
  const auto other = makeVtkRenderer(scene);
  const Camera camera = cameraAt({-9, 1, 0.5}, 5, 3, 20, 200, 150, 90);
  const Camera elsewhere = cameraAt({2, 1, 0.5}, 90, 3, 20, 64, 300, 70);
  const PassPlanes first = drawnOne(*renderer, camera);
  drawnOne(*renderer, elsewhere);
  EXPECT_TRUE(same(first, drawnOne(*renderer, camera)));
  EXPECT_TRUE(same(first, drawnOne(*other, camera)));
  const std::vector<PassImage> together = drawn(*renderer, {elsewhere, camera, camera}, {});
  EXPECT_TRUE(same(first, together[1].planes));
  EXPECT_TRUE(same(first, together[2].planes));
}

TEST(VtkRenderer, TakesImagesOfAnyShape) {
  const Scene scene = randomScene();
  RENDERER_OR_SKIP(renderer, scene);
  std::vector<Camera> cameras;
  const std::pair<std::uint32_t, std::uint32_t> sizes[] = {{1, 1},    {257, 3},  {3, 129},  {64, 64},
                                                           {100, 37}, {37, 100}, {130, 90}, {65, 66}};
  for (const auto& [width, height] : sizes) {
    Camera camera = cameraAt({-9, 1, 0.5}, 5, 3, 0, width, height, 60);
    const auto k = static_cast<double>(cameras.size());
    camera.fy *= 1.1;
    camera.cx += 20 * k - 40;  // out of the image for some
    camera.cy -= 10 * k - 30;
    cameras.push_back(camera);
  }
  const std::vector<PassImage> images = drawn(*renderer, cameras, {});
  ASSERT_EQ(images.size(), 8u);
  for (std::size_t k = 3; k < images.size(); ++k) expectLikeReference(scene, cameras[k], {}, images[k].planes);
  for (std::size_t k = 0; k < images.size(); ++k) {
    EXPECT_TRUE(same(images[k].planes, drawnOne(*renderer, cameras[k]))) << k;
  }
}

TEST(VtkRenderer, FetchesAnyPixelsInAnyOrder) {
  const Scene scene = randomScene();
  RENDERER_OR_SKIP(renderer, scene);
  const std::vector<Camera> cameras{cameraAt({-9, 1, 0.5}, 5, 3, 20, 70, 50, 90),
                                    cameraAt({-9, 1, 0.5}, -40, 3, 20, 33, 90, 60)};
  const auto source = renderer->draw(cameras, {}, kIds);
  const std::vector<PassImage> images = readAll(*source, kIds);
  const std::size_t pixels = cameras[0].pixels() + cameras[1].pixels();
  std::vector<std::vector<PixelAddress>> lists(4);
  for (std::uint32_t i = 0; i < 9000; ++i) {
    const auto any = static_cast<PixelAddress>(uniform(i, 0, static_cast<double>(pixels)));
    lists[0].push_back(i % 7 == 0 ? kNoPixel : any);
  }
  for (PixelAddress i = 100; i < 3600; ++i) lists[1].push_back(i);  // a run across two images
  for (PixelAddress i = 123; i < 777; ++i) lists[2].push_back(i);   // a run inside of one
  lists[3] = {kNoPixel, kNoPixel};
  lists.push_back({});
  for (const std::vector<PixelAddress>& addresses : lists) {
    PassPlanes planes;
    PassPlanes expected;
    source->fetch(addresses, kIds, planes);
    ImageSource(images).fetch(addresses, kIds, expected);
    EXPECT_TRUE(same(planes, expected));
    EXPECT_EQ(planes.size(), addresses.size());
  }
  EXPECT_EQ(source->available(), (PassChoice{Channels::all(), true}));
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

TEST(VtkRenderer, NothingIsSeenOfNothing) {
  Scene scene;
  scene.materials.resize(1);
  RENDERER_OR_SKIP(renderer, scene);
  const PassPlanes planes = drawnOne(*renderer, cameraAt({}, 0, 0, 0, 32, 16, 90));
  EXPECT_EQ(planes.size(), 512u);
  EXPECT_EQ(seenPixels(planes), 0u);
  PassPlanes none;
  renderer->draw({}, {}, kIds)->fetch({}, kIds, none);
  EXPECT_EQ(none.size(), 0u);
}

TEST(VtkRenderer, SeesNothingBehindOrBesideIt) {
  const Scene scene = randomScene();
  RENDERER_OR_SKIP(renderer, scene);
  EXPECT_EQ(seenPixels(drawnOne(*renderer, cameraAt({40, 0, 0}, 0, 0, 0, 64, 64, 120))), 0u);
  EXPECT_EQ(seenPixels(drawnOne(*renderer, cameraAt({-40, 0, 0}, 90, 0, 0, 64, 64, 60))), 0u);
}

TEST(VtkRenderer, ThreadsTakeTurns) {
  const Scene scene = randomScene();
  RENDERER_OR_SKIP(renderer, scene);
  constexpr int kThreads = 4;
  std::vector<Camera> cameras;
  std::vector<PassPlanes> expected;
  for (int i = 0; i < kThreads; ++i) {
    cameras.push_back(cameraAt({-9, 1, 0.5}, 10 * i - 15, 3, 20, 64 + static_cast<std::uint32_t>(i), 48, 80));
    expected.push_back(drawnOne(*renderer, cameras.back()));
  }
  const int rounds = kSanitized ? 2 : 8;
  std::vector<int> right(kThreads, 0);
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < kThreads; ++i) {
      threads.emplace_back([&, i] {
        for (int round = 0; round < rounds; ++round) {
          right[i] += same(expected[i], drawnOne(*renderer, cameras[i]));
          const auto own = round == 0 ? makeVtkRenderer(scene) : nullptr;
          if (own != nullptr && !same(expected[i], drawnOne(*own, cameras[i]))) right[i] = -100;
        }
      });
    }
  }
  EXPECT_EQ(right, std::vector<int>(kThreads, rounds));
}

// A source may be used and dropped by another thread than the one that drew it.
TEST(VtkRenderer, SourcesChangeThreads) {
  const Scene scene = randomScene();
  RENDERER_OR_SKIP(renderer, scene);
  const Camera camera = cameraAt({-9, 1, 0.5}, 5, 3, 20, 64, 48, 80);
  const PassPlanes expected = drawnOne(*renderer, camera);
  std::unique_ptr<PixelSource> source = renderer->draw({camera}, {}, kIds);
  bool right = false;
  std::jthread([&] {
    right = same(readAll(*source, kIds).front().planes, expected);
    source.reset();
  }).join();
  EXPECT_TRUE(right);
  EXPECT_TRUE(same(expected, drawnOne(*renderer, camera)));
}

TEST(VtkRenderer, TellsItsDeviceAndTimes) {
  const Scene scene = randomScene();
  RENDERER_OR_SKIP(renderer, scene);
  EXPECT_THAT(renderer->device(), HasSubstr("VTK 9."));
  EXPECT_GT(renderer->seconds().at("upload"), 0);
  EXPECT_EQ(renderer->seconds().at("render"), 0);
  drawnOne(*renderer, cameraAt({-9, 1, 0.5}, 5, 3, 20, 64, 48, 80));
  EXPECT_GT(renderer->seconds().at("render"), 0);
  EXPECT_GT(renderer->seconds().at("read_back"), 0);
}

TEST(VtkRenderer, RefusesWhatCannotBeDrawn) {
  const Scene scene = randomScene();
  RENDERER_OR_SKIP(renderer, scene);
  const Camera good = cameraAt({}, 0, 0, 0, 8, 8, 80);
  const auto refused = [&](const std::vector<Camera>& cameras, const DrawLimits& limits,
                           const std::vector<std::string>& words) {
    expectInputError([&] { renderer->draw(cameras, limits, kIds); }, words);
  };
  refused(std::vector<Camera>(9, good), {}, {"9 cameras", "8"});
  for (const DrawLimits& limits : {DrawLimits{0, 10}, {-1, 10}, {5, 5}, {5, 1}, {std::nan(""), 1}, {1, INFINITY}}) {
    refused({good}, limits, {"cannot be drawn from"});
  }
  Camera camera = good;
  camera.width = 0;
  refused({camera}, {}, {"'test'", "0 x 8"});
  camera.width = 1u << 20;
  refused({camera}, {}, {"'test'", "1048576 x 8"});
  camera = good;
  camera.fy = 0;
  refused({camera}, {}, {"'test'", "focal length"});
  camera = good;
  camera.cx = std::nan("");
  refused({camera}, {}, {"'test'", "principal point"});
  const auto source = renderer->draw({good}, {}, kIds);
  PassPlanes planes;
  EXPECT_THAT(messageOf<Error>([&] { source->fetch(std::vector<PixelAddress>{64}, kIds, planes); }),
              HasSubstr("no image has"));
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

TEST(VtkRenderer, SaysWhichDevicesThereAre) {
  const Scene scene = randomScene();
  { RENDERER_OR_SKIP(renderer, scene); }
  ::setenv("SCANMILL_GL_DEVICE", "77", 1);
  const std::string message = messageOf<Error>([&] { makeVtkRenderer(scene); });
  ::setenv("SCANMILL_GL_DEVICE", "software", 1);
  const std::string software = messageOf<Error>([&] { makeVtkRenderer(scene); });
  ::unsetenv("SCANMILL_GL_DEVICE");
  EXPECT_THAT(message, HasSubstr("SCANMILL_GL_DEVICE: there is no device '77': take"));
  EXPECT_THAT(message, testing::Not(HasSubstr("libgl1-mesa-dri")));  // nothing is amiss but the number
  EXPECT_TRUE(software == "accepted" || software.find("there is no device 'software'") != std::string::npos);
}

TEST(VtkModule, SaysWhatIsMissing) {
  const TemporaryFolder folder;
  EXPECT_THAT(messageOf<Error>([&] {
                loadVtkModule({"/absent", folder.path()});
              }),
              HasSubstr("looked for /absent/libscanmill_passes.so, " + folder.path().string()));
  const std::string garbage =
      messageOf<Error>([&] { loadVtkModule({folder.write("libscanmill_passes.so", "text").parent_path()}); });
  EXPECT_THAT(garbage, HasSubstr("cannot be loaded"));
  EXPECT_THAT(garbage, HasSubstr("libvtk9-dev"));
}

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
  EXPECT_THAT(messageOf<Error>([&] { buildViewGeometry(scene, 100); }), HasSubstr("more than the 100"));
}

}  // namespace
}  // namespace scanmill
