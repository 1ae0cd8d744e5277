#include "passes/resolver.h"

#include "base/random.h"
#include "scene/texture.h"
#include "tests/core/passes/ray_reference.h"
#include "tests/support/message_of.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

constexpr PassChoice kResolvedPasses{Channels::all(), true};

// The first triangle that the line of sight through each pixel's centre meets.
struct Drawn {
  std::vector<PixelAddress> addresses;
  std::vector<VisibleTriangle> seen;
};

Drawn drawAll(const Scene& scene, const std::vector<Camera>& cameras) {
  Drawn drawn;
  for (const Camera& camera : cameras) {
    for (const ReferencePixel& pixel : RayReference(scene).draw(camera, {1e-9, 1e9})) {
      drawn.addresses.push_back(static_cast<PixelAddress>(drawn.addresses.size()));
      drawn.seen.push_back({static_cast<float>(pixel.depth), pixel.instance, pixel.triangle});
    }
  }
  return drawn;
}

Camera squareCameraAt(const Vec3d& position, double yawDegrees, double pitchDegrees, std::uint32_t size = 32,
                      double fieldDegrees = 80) {
  Camera camera = squareCamera(size, size, radians(fieldDegrees));
  camera.worldFromCamera = {fromYawPitchRoll(radians(yawDegrees), radians(pitchDegrees), 0.1) * vehicleFromOptical(),
                            position};
  return camera;
}

Affine placedAt(const Vec3d& position, const Mat3& linear) {
  return {linear, position};
}

// A sphere of radius 2 at the origin of each instance: seen from anywhere, the normal is that of its own triangle.
Scene spheres(const std::vector<Affine>& places) {
  SceneBuilder builder = testBuilder();
  Mesh mesh = meshOf(builder, "thing", "dark");
  appendSphere(mesh, 0, {}, 2, 12);
  const std::uint32_t index = builder.addMesh(mesh);
  for (const Affine& place : places) builder.place(index, place, "sphere");
  return builder.finish();
}

TEST(Resolver, NormalsAreThoseOfTheTrianglesInTheWorldTurnedToTheCamera) {
  const Mat3 turned = toMatrix(fromYawPitchRoll(0.3, -0.7, 1.1));
  const Mat3 squeezed = turned * Mat3::scale({0.5, 2, 1.25});
  const Mat3 mirrored = turned * Mat3::scale({-1, 1, 0.75});
  const Mat3 tiny = Mat3::scale({1e-4, 1e-4, 1e-4});
  const Scene scene = spheres({placedAt({10, 0, 0}, turned), placedAt({-10, 1, 0}, squeezed),
                               placedAt({0, 10, 1}, mirrored), placedAt({0.001, -0.002, 0}, tiny)});
  const std::vector<Camera> cameras{squareCameraAt({}, 0, 0), squareCameraAt({}, 180, 5), squareCameraAt({}, 90, -5),
                                    squareCameraAt({}, -63, 0, 16, 15)};
  const Drawn drawn = drawAll(scene, cameras);
  PassPlanes planes;
  Resolver(scene).resolve(cameras, drawn.addresses, drawn.seen, kResolvedPasses, planes);
  std::size_t seen[5] = {};
  std::size_t address = 0;
  for (const Camera& camera : cameras) {
    const Mat3 turn = toMatrix(camera.worldFromCamera.rotation);
    for (std::uint32_t pixel = 0; pixel < camera.pixels(); ++pixel, ++address) {
      const VisibleTriangle& s = drawn.seen[address];
      ++seen[s.instance];
      const Vec3d n(planes.normal[address]);
      if (s.instance == 0) {
        EXPECT_EQ(planes.normal[address], Vec3f{});
        continue;
      }
      EXPECT_NEAR(length(n), 1, 1e-6);
      const Vec3d sight = turn * camera.ray(pixel % camera.width + 0.5, pixel / camera.width + 0.5);
      EXPECT_LT(dot(n, sight), 0);
      const Instance& instance = scene.instances[s.instance - 1];
      const Mesh& mesh = scene.meshes[instance.mesh];
      const Triangle& corners = mesh.triangles[s.triangle];
      for (const auto& [from, to] : {std::pair{0, 1}, {1, 2}}) {
        const Vec3d edge = normalized(instance.worldFromMesh.linear *
                                      (Vec3d(mesh.positions[corners[to]]) - Vec3d(mesh.positions[corners[from]])));
        EXPECT_NEAR(dot(n, edge), 0, 1e-6);
      }
    }
  }
  for (const std::size_t count : seen) EXPECT_GT(count, 20u);
}

TEST(Resolver, SeenFromInsideNormalsPointInwards) {
  const Scene scene = spheres({placedAt({}, {})});
  const std::vector<Camera> cameras{squareCameraAt({0.5, 0, 0}, 20, 10)};
  const Drawn drawn = drawAll(scene, cameras);
  PassPlanes planes;
  Resolver(scene).resolve(cameras, drawn.addresses, drawn.seen, kResolvedPasses, planes);
  for (std::size_t i = 0; i < planes.size(); ++i) {
    ASSERT_LT(planes.depth[i], kNoDepth);
    const Camera& camera = cameras[0];
    const Vec3d sight =
        toMatrix(camera.worldFromCamera.rotation) *
        camera.ray(static_cast<double>(i % camera.width) + 0.5, static_cast<double>(i / camera.width) + 0.5);
    EXPECT_LT(dot(Vec3d(planes.normal[i]), sight), 0);
  }
}

TEST(Resolver, LabelsAreThoseOfTheSurfaceAndTheInstance) {
  SceneBuilder builder = testBuilder();
  Mesh mesh = meshOf(builder, "ground", "grey");
  mesh.surfaces.push_back(builder.surface("other", "dark"));
  appendPlane(mesh, 0, {}, 2, 2);
  appendPlane(mesh, 1, at(0, 0, 1), 2, 2);
  const std::uint32_t index = builder.addMesh(mesh);
  builder.place(index, at(0, 0, 0), "first");
  builder.place(index, at(5, 0, 0), "second");
  Scene scene = builder.finish();
  Material& dark = scene.materials[scene.meshes[0].surfaces[1].material];
  dark.roughness = 0.25f;
  dark.metallic = 1;
  dark.retroreflectance = 3;
  const std::vector<Camera> cameras{squareCameraAt({0, 0, 3}, 0, 90, 4)};
  const std::vector<VisibleTriangle> seen{{1, 1, 0}, {2, 1, 2}, {3, 2, 1}, {4, 2, 3}, {}, {5, 1, 0}};
  const std::vector<PixelAddress> addresses{3, 1, 2, 0, 15, kNoPixel};
  PassPlanes planes;
  Resolver(scene).resolve(cameras, addresses, seen, kResolvedPasses, planes);
  const float miss = kNoDepth;
  EXPECT_EQ(planes.depth, (std::vector<float>{1, 2, 3, 4, miss, miss}));
  const std::uint32_t first = scene.instances[0].firstInstanceId;
  const std::uint32_t second = scene.instances[1].firstInstanceId;
  EXPECT_EQ(planes.instance, (std::vector<std::uint32_t>{0, first, 0, second, 0, 0}));
  EXPECT_NE(first, second);
  EXPECT_EQ(planes.semantic, (std::vector<std::uint16_t>{1, 3, 1, 3, 0, 0}));
  const std::uint16_t grey = scene.meshes[0].surfaces[0].material;
  const std::uint16_t darkIndex = scene.meshes[0].surfaces[1].material;
  EXPECT_EQ(planes.material, (std::vector<std::uint16_t>{grey, darkIndex, grey, darkIndex, 0, 0}));
  EXPECT_EQ(planes.primitive, (std::vector<std::uint32_t>{0, 2, 1, 3, 0, 0}));
  EXPECT_EQ(planes.reflectance, (std::vector<float>{0.5f, 0.1f, 0.5f, 0.1f, 0, 0}));
  EXPECT_EQ(planes.roughness, (std::vector<float>{1, 0.25f, 1, 0.25f, 0, 0}));
  EXPECT_EQ(planes.metallic, (std::vector<float>{0, 1, 0, 1, 0, 0}));
  EXPECT_EQ(planes.retroreflectance, (std::vector<float>{0, 3, 0, 3, 0, 0}));
}

TEST(Resolver, OnlyWhatIsAskedForIsFilled) {
  const Scene scene = spheres({placedAt({5, 0, 0}, {})});
  const std::vector<Camera> cameras{squareCameraAt({}, 0, 0, 8)};
  const Drawn drawn = drawAll(scene, cameras);
  const Resolver resolver(scene);
  PassPlanes all;
  resolver.resolve(cameras, drawn.addresses, drawn.seen, kResolvedPasses, all);
  for (const Channel channel : {Channel::Normal, Channel::Instance, Channel::Semantic, Channel::Material,
                                Channel::Primitive, Channel::Reflectance}) {
    PassPlanes one;
    resolver.resolve(cameras, drawn.addresses, drawn.seen, {channel, false}, one);
    EXPECT_EQ(one.choice(), (PassChoice{Channel::Range | channel, false}));
    EXPECT_EQ(one.depth, all.depth);
    EXPECT_TRUE(one.normal.empty() || one.normal == all.normal);
    EXPECT_TRUE(one.semantic.empty() || one.semantic == all.semantic);
    EXPECT_TRUE(one.reflectance.empty() || one.reflectance == all.reflectance);
  }
}

// A wall x = `distance` that spans 4 m x 4 m with a texture of 4 x 4 texels: a texel is a square metre.
Scene texturedWall(const Vec3d& place, std::shared_ptr<Texture>& texture) {
  texture = std::make_shared<Texture>();
  texture->width = texture->height = 4;
  for (std::uint8_t i = 0; i < 16; ++i) {
    for (const int value : {40 + 10 * i, 200 - 5 * i, 3 * i, 255}) {
      texture->rgba.push_back(static_cast<std::uint8_t>(value));
    }
  }
  SceneBuilder builder = testBuilder();
  Mesh mesh = meshOf(builder, "thing", "grey");
  appendQuad(mesh, 0, {0, -2, -2}, {0, 2, -2}, {0, 2, 2}, {0, -2, 2});
  for (const Vec3f& p : mesh.positions) mesh.uvs.push_back({(p.y + 2) / 4, (p.z + 2) / 4});
  Material painted = builder.library().materials[0];
  painted.name = "painted";
  painted.textured = true;
  painted.texture = texture;
  painted.textureMean = meanLuminance(*texture);
  mesh.surfaces[0].material = builder.addMaterial(painted);
  builder.place(builder.addMesh(mesh), at(place.x, place.y, place.z), "wall");
  return builder.finish();
}

TEST(Resolver, TexturesScaleTheReflectanceAtThePixelsCentre) {
  for (const Vec3d& origin : {Vec3d{0, 0, 0}, Vec3d{4.5e5, 5.4e6, 300}, Vec3d{1e7, -1e7, 1e7}}) {
    std::shared_ptr<Texture> texture;
    const Scene scene = texturedWall(origin + Vec3d{3, 0, 0}, texture);
    const std::vector<Camera> cameras{squareCameraAt(origin + Vec3d{0, 0.5, -0.25}, 10, 4, 24)};
    const Drawn drawn = drawAll(scene, cameras);
    PassPlanes planes;
    Resolver(scene).resolve(cameras, drawn.addresses, drawn.seen, kResolvedPasses, planes);
    const float mean = meanLuminance(*texture);
    std::size_t checked = 0;
    for (std::size_t i = 0; i < planes.size(); ++i) {
      if (drawn.seen[i].instance == 0) continue;
      const Camera& camera = cameras[0];
      const Vec3d d =
          toMatrix(camera.worldFromCamera.rotation) *
          camera.ray(static_cast<double>(i % camera.width) + 0.5, static_cast<double>(i / camera.width) + 0.5);
      const double y = 0.5 + d.y / d.x * 3 + 2;
      const double z = -0.25 + d.z / d.x * 3 + 2;
      if (std::abs(y - std::round(y)) < 1e-3 || std::abs(z - std::round(z)) < 1e-3) continue;
      const auto texel = static_cast<std::size_t>(z) * 4 + static_cast<std::size_t>(y);
      EXPECT_FLOAT_EQ(planes.reflectance[i], std::min(1.0f, 0.5f / mean * luminance(&texture->rgba[texel * 4])));
      ++checked;
    }
    EXPECT_GT(checked, 200u);
  }
}

// What is drawn at a triangle's rim may lie a little outside of it: the texel is the nearest one inside.
TEST(Resolver, BesideTheTriangleTheNearestTexelCounts) {
  std::shared_ptr<Texture> texture;
  const Scene scene = texturedWall({3, 0, 0}, texture);
  const std::vector<Camera> cameras{squareCameraAt({}, 0, 0, 64, 150)};
  const Resolver resolver(scene);
  std::vector<PixelAddress> addresses(cameras[0].pixels());
  for (std::size_t i = 0; i < addresses.size(); ++i) addresses[i] = static_cast<PixelAddress>(i);
  PassPlanes planes;
  resolver.resolve(cameras, addresses, std::vector<VisibleTriangle>(addresses.size(), {1, 1, 0}), kResolvedPasses,
                   planes);
  const float gain = 0.5f / meanLuminance(*texture);
  for (const float r : planes.reflectance) {
    bool known = false;
    for (std::size_t t = 0; t < 16; ++t) known = known || r == std::min(1.0f, gain * luminance(&texture->rgba[t * 4]));
    EXPECT_TRUE(known) << r;
  }
}

TEST(Resolver, FarFromTheOriginNothingChanges) {
  const Mat3 turned = toMatrix(fromYawPitchRoll(0.25, 0.5, 0));
  const auto resolved = [&](const Vec3d& origin) {
    const Scene scene = spheres({placedAt(origin + Vec3d{6, 0, 0}, turned), placedAt(origin + Vec3d{0, 8, 1}, turned)});
    const std::vector<Camera> cameras{squareCameraAt(origin, 30, 0, 48)};
    const Drawn drawn = drawAll(scene, cameras);
    PassPlanes planes;
    Resolver(scene).resolve(cameras, drawn.addresses, drawn.seen, kResolvedPasses, planes);
    return planes;
  };
  const PassPlanes here = resolved({0, 0, 0});
  const PassPlanes there = resolved({1e7, -1e7, 1e7});
  EXPECT_EQ(here.depth, there.depth);
  EXPECT_EQ(here.normal, there.normal);
  EXPECT_EQ(here.instance, there.instance);
}

TEST(Resolver, ThePartsOfManyPixelsAreTheWhole) {
  const Scene scene = spheres({placedAt({6, 0, 0}, {}), placedAt({5, 3, 0}, Mat3::scale({1, -1, 1}))});
  const std::vector<Camera> cameras{squareCameraAt({}, 0, 0, 40), squareCameraAt({}, 40, 0, 24)};
  const Drawn drawn = drawAll(scene, cameras);
  const Resolver resolver(scene);
  PassPlanes whole;
  resolver.resolve(cameras, drawn.addresses, drawn.seen, kResolvedPasses, whole);
  std::vector<PixelAddress> addresses;
  std::vector<VisibleTriangle> seen;
  for (std::uint32_t i = 0; i < 20'000; ++i) {
    addresses.push_back(randomBlock({.seed = 3, .beam = i})[0] % static_cast<std::uint32_t>(whole.size()));
    seen.push_back(drawn.seen[addresses.back()]);
  }
  PassPlanes shuffled;
  resolver.resolve(cameras, addresses, seen, kResolvedPasses, shuffled);
  for (std::size_t i = 0; i < addresses.size(); ++i) {
    ASSERT_EQ(shuffled.depth[i], whole.depth[addresses[i]]);
    ASSERT_EQ(shuffled.normal[i], whole.normal[addresses[i]]);
    ASSERT_EQ(shuffled.instance[i], whole.instance[addresses[i]]);
  }
}

}  // namespace
}  // namespace scanmill
