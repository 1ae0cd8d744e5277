#include "methods/interface/light_paths.h"

#include "tests/core/methods/trace.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

constexpr double kGlass = 1.52;

TEST(LightPaths, FresnelAtZeroAndSixtyDegrees) {
  EXPECT_NEAR(fresnel(1, kGlass), 0.52 * 0.52 / (2.52 * 2.52), 1e-12);
  // By the sine and tangent forms: half of sin^2(a - b) / sin^2(a + b) + tan^2(a - b) / tan^2(a + b).
  const double a = radians(60);
  const double b = std::asin(std::sin(a) / kGlass);
  const double across = std::pow(std::sin(a - b) / std::sin(a + b), 2);
  const double along = std::pow(std::tan(a - b) / std::tan(a + b), 2);
  EXPECT_NEAR(fresnel(0.5, kGlass), (across + along) / 2, 1e-12);
  EXPECT_NEAR(fresnel(0.5, kGlass), 0.0925, 1e-4);
  EXPECT_NEAR(fresnel(0, kGlass), 1, 1e-12);
  // At Brewster's angle only light polarised across the plane of incidence is left.
  const double brewster = std::atan(kGlass);
  const double inside = std::asin(std::sin(brewster) / kGlass);
  EXPECT_NEAR(fresnel(std::cos(brewster), kGlass), std::pow(std::sin(brewster - inside), 2) / 2, 1e-12);
}

// A clear pane loses nothing; one that absorbs loses what it says where it does not reflect.
TEST(LightPaths, PanesConserveEnergy) {
  for (double cosine = 0.02; cosine <= 1; cosine += 0.02) {
    const Pane clear = paneOf(cosine, kGlass, 1);
    EXPECT_NEAR(clear.reflected + clear.transmitted, 1, 1e-12);
    const Pane tinted = paneOf(cosine, kGlass, 0.4);
    EXPECT_LT(tinted.reflected + tinted.transmitted, 1);
    EXPECT_NEAR(paneOf(cosine, 1, 0.4).transmitted, 0.4, 1e-12);
  }
  EXPECT_NEAR(paneOf(1, kGlass, 1).reflected, 2 * 0.0426 / 1.0426, 1e-3) << "8.2 %, as the table of materials says";
}

// A pane at x = 5 and a wall at x = 12 behind it; a mirror at y = -6 and a wall at y = 9, which it shows.
Scene rooms(double shift = 0) {
  MaterialLibrary library = testMaterials();
  Material glass;
  glass.name = "pane";
  glass.reflectance = 0.08f;
  glass.roughness = 0;
  glass.transmission = 0.5f;
  glass.index = static_cast<float>(kGlass);
  Material mirror;
  mirror.name = "mirror";
  mirror.reflectance = 0.9f;
  mirror.roughness = 0;
  mirror.metallic = 1;
  library.materials.push_back(glass);
  library.materials.push_back(mirror);
  SceneBuilder builder("test", 1, testOntology(), std::move(library));
  const auto wall = [&](const char* className, const char* material, const Vec3d& corner, const Vec3d& u,
                        const Vec3d& v) {
    Mesh mesh = meshOf(builder, className, material);
    appendQuad(mesh, 0, corner, corner + u, corner + u + v, corner + v);
    builder.place(builder.addMesh(std::move(mesh)), at(shift, 0, 0), className);
  };
  wall("thing", "pane", {5, -2, -3}, {0, 4, 0}, {0, 0, 6});
  wall("other", "grey", {12, -4, -3}, {0, 8, 0}, {0, 0, 6});
  wall("thing", "mirror", {-10, -6, -3}, {40, 0, 0}, {0, 0, 6});
  wall("ground", "grey", {-20, 9, -3}, {40, 0, 0}, {0, 0, 6});
  return builder.finish();
}

Hits followed(const Scene& scene, const Shot& shot, const LightPaths& paths) {
  const auto method = rayTracing(scene);
  Hits hits = traced(*method, shot);
  followLight(*method, shot, scene.materials, paths, hits);
  return hits;
}

TEST(LightPaths, GoOnBehindGlass) {
  for (const double shift : {0.0, 456789.0}) {
    const Scene scene = rooms(shift);
    const Vec3d direction = normalized(Vec3d{1, 0.2, 0.1});
    const Shot shot = shotAt(beamsOf({direction, {-1, 0.5, 0}}), Pose{{}, {shift, 0, 0}});
    const Hits hits = followed(scene, shot, {.bounces = 0});
    ASSERT_EQ(hits.rays(), 3u);
    EXPECT_EQ(hits.beamOfRay, (std::vector<std::uint32_t>{0, 1, 0}));
    EXPECT_NEAR(hits.range[0], 5 / direction.x, 1e-5);
    EXPECT_EQ(hits.pathOfRay[0], RayPath::Direct);
    EXPECT_NEAR(hits.range[2], 12 / direction.x, 1e-5);
    EXPECT_EQ(hits.pathOfRay[2], RayPath::ThroughGlass);
    EXPECT_EQ(hits.semantic[2], 3);
    const double through = paneOf(direction.x, kGlass, 0.5).transmitted;
    EXPECT_NEAR(hits.weightOfRay[2], through * through, 1e-6);
  }
}

// Where the sensor believes a ghost to be: at the mirror image of what the mirror shows, y = -6 - (9 + 6).
TEST(LightPaths, GhostsLieAtTheMirrorImage) {
  for (const double shift : {0.0, 456789.0}) {
    const Scene scene = rooms(shift);
    for (const double slant : {-1.6, -0.7, 0.1, 0.4}) {
      const Vec3d direction = normalized(Vec3d{slant, -2, 0.1});
      auto beams = beamsOf({direction});
      beams->origin = {Vec3f{0.1f, -0.2f, 0.3f}};
      const Hits hits = followed(scene, shotAt(beams, Pose{{}, {shift, 1, 0}}), {});
      ASSERT_EQ(hits.rays(), 2u) << slant;
      EXPECT_EQ(hits.pathOfRay[1], RayPath::Mirrored);
      EXPECT_EQ(hits.semantic[1], 1);
      const Vec3d ghost = Vec3d{0.1f, 0.8f, 0.3f} + direction * double{hits.range[1]};
      EXPECT_NEAR(ghost.y, -21, 1e-5);
      const double reflected = 0.9f + (1 - 0.9f) * std::pow(1 - std::abs(direction.y), 5);
      EXPECT_NEAR(hits.weightOfRay[1], reflected * reflected, 1e-5);
    }
  }
}

TEST(LightPaths, HaveTheirClassOrNone) {
  const Scene scene = rooms();
  const Shot shot = shotAt(beamsOf({{0.3, -2, 0.1}}));
  const Hits hits = followed(scene, shot, {.mirroredUnlabelled = true});
  ASSERT_EQ(hits.rays(), 2u);
  EXPECT_EQ(hits.semantic[1], 0);
  EXPECT_EQ(hits.instance[1], 0u);
}

TEST(LightPaths, EndWhereTheyAreTold) {
  const Scene scene = rooms();
  const auto rays = [&](const Vec3d& direction, const LightPaths& paths, double farthest = 1000) {
    return followed(scene, shotAt(beamsOf({direction}, 0, farthest)), paths).rays();
  };
  EXPECT_EQ(rays({1, 0, 0}, {}), 2u) << "the wall; the pane mirrors to where nothing is";
  EXPECT_EQ(rays({1, 0, 0}, {.panes = 0}), 1u);
  EXPECT_EQ(rays({1, 0, 0}, {}, 11.9), 1u) << "beyond the sensor's range";
  EXPECT_EQ(rays({1, 0, 0}, {.least = 0.5}), 1u) << "too faint";
  EXPECT_EQ(rays({0.3, -2, 0.1}, {.bounces = 0}), 1u);
}

}  // namespace
}  // namespace scanmill
