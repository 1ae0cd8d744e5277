#pragma once

// Scenes of which it is known what a ray meets, for the tests of everything that traces rays.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "base/random.h"
#include "scan/hits.h"
#include "tests/support/test_scene.h"

namespace scanmill {

// A wall of 100 m x 100 m across the x axis, 10 m ahead.
inline Scene wallAhead() {
  return oneMeshScene("ground", [](Mesh& wall) {
    appendQuad(wall, 0, {10, -50, -50}, {10, 50, -50}, {10, 50, 50}, {10, -50, 50});
  });
}

// Walls of 10 m x 10 m across the x axis at these distances (m). They share a mesh.
inline Scene wallsAhead(const std::vector<double>& distances) {
  SceneBuilder builder = testBuilder();
  Mesh wall = meshOf(builder, "thing");
  appendQuad(wall, 0, {0, -5, -5}, {0, 5, -5}, {0, 5, 5}, {0, -5, 5});
  const std::uint32_t mesh = builder.addMesh(wall);
  for (const double distance : distances) builder.place(mesh, at(distance, 0, 0), "wall");
  return builder.finish();
}

// Boxes and spheres on a wide ground 2 m below a sensor at (shift, shift, 0).
inline Scene yard(double shift = 0) {
  SceneBuilder builder = testBuilder();
  Mesh ground = meshOf(builder, "ground");
  appendPlane(ground, 0, {}, 400, 400, 8);
  builder.place(builder.addMesh(ground), at(shift, shift, -2), "ground");
  Mesh box = meshOf(builder, "thing");
  appendBox(box, 0, {}, {2, 3, 3});
  const std::uint32_t boxMesh = builder.addMesh(box);
  Mesh sphere = meshOf(builder, "other", "dark");
  appendSphere(sphere, 0, {}, 1.2, 32);
  const std::uint32_t sphereMesh = builder.addMesh(sphere);
  for (std::uint32_t i = 0; i < 50; ++i) {
    const RandomBlock b = randomBlock({11, 0, 0, 0, i, 0, Purpose::Test});
    const double r = 6 + 40 * uniform(b[0]);
    const double a = 2 * kPi * uniform(b[1]);
    builder.place(
        i % 3 == 0 ? sphereMesh : boxMesh,
        {toMatrix(fromYawPitchRoll(6 * uniform(b[2]), 0, 0)), {shift + r * std::cos(a), shift + r * std::sin(a), -0.7}},
        "object");
  }
  return builder.finish();
}

// A revolution on a vehicle that drives `metres` along x and turns by `turnDeg`, with so many poses.
inline Shot moving(std::shared_ptr<const BeamTable> beams, std::size_t poses, double metres, double turnDeg = 0) {
  Shot shot = shotAt(std::move(beams));
  shot.worldFromSensor.clear();
  for (std::size_t i = 0; i < poses; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(poses);
    shot.worldFromSensor.push_back({fromYawPitchRoll(radians(turnDeg) * share, 0, 0), {metres * share, 0, 0}});
  }
  return shot;
}

// A box of 2 m whose transform mirrors it, 5 m ahead.
inline Scene mirroredBox() {
  return oneMeshScene("thing",
                      [](Mesh& box) {
                        appendBox(box, 0, {}, {2, 2, 2});
                      },
                      {Mat3::scale({-1, 1, 1}), {5, 0, 0}});
}

// A closed ball of 30 m radius, turned, around a place near the origin, and what more(mesh) adds to its mesh.
inline Scene ballRoom(const std::function<void(Mesh&)>& more = {}) {
  const auto fill = [&](Mesh& room) {
    appendSphere(room, 0, {}, 30.0, 96);
    if (more) more(room);
  };
  return oneMeshScene("ground", fill, {toMatrix(fromYawPitchRoll(0.7, 0.4, 0.2)), {3, 2, 1}});
}

// A quad across the x axis, 5 m ahead, whose texture of two texels ends at y = 0: the left half is the first texel.
inline Mesh pictureAhead(SceneBuilder& builder, Material material, std::uint16_t semantic,
                         const std::vector<std::uint8_t>& rgba) {
  auto texture = std::make_shared<Texture>();
  texture->width = 2;
  texture->height = 1;
  texture->hasAlpha = material.alphaTested;
  texture->rgba = rgba;
  material.texture = texture;
  Mesh mesh;
  mesh.surfaces.push_back({builder.addMaterial(material), semantic, semantic == 2 ? 1u : 0u, "", "", {}});
  appendQuad(mesh, 0, {5, 5, -5}, {5, -5, -5}, {5, -5, 5}, {5, 5, 5});
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  return mesh;
}

// A curtain whose right half is a hole, an opaque strip above it (class 3) in the same mesh, and a wall 10 m ahead.
inline Scene curtain() {
  SceneBuilder builder = testBuilder();
  Material leaf;
  leaf.name = "leaf";
  leaf.alphaTested = true;
  Mesh mesh = pictureAhead(builder, leaf, 2, {255, 255, 255, 255, 255, 255, 255, 0});
  mesh.surfaces.push_back(builder.surface("other", "grey"));
  appendQuad(mesh, 1, {5, 5, 5}, {5, -5, 5}, {5, -5, 6}, {5, 5, 6});
  mesh.uvs.resize(8);
  builder.place(builder.addMesh(mesh), {}, "curtain");
  Mesh wall = meshOf(builder, "ground");
  appendQuad(wall, 0, {10, 50, -50}, {10, -50, -50}, {10, -50, 50}, {10, 50, 50});
  builder.place(builder.addMesh(wall), {}, "wall");
  return builder.finish();
}

// Directions to the curtain, to both of its halves.
inline std::vector<Vec3d> towardsTheCurtain() {
  std::vector<Vec3d> directions;
  for (int i = -40; i <= 40; ++i) {
    if (i != 0) directions.push_back({1, i * 0.02, 0.013});
  }
  return directions;
}

// A wall of the reflectance 0.4 that is painted white on the left and black on the right.
inline Scene paintedWall() {
  SceneBuilder builder = testBuilder();
  Material paint;
  paint.name = "paint";
  paint.reflectance = 0.4f;
  paint.textured = true;
  paint.textureMean = 0.5f;
  builder.place(builder.addMesh(pictureAhead(builder, paint, 1, {255, 255, 255, 255, 0, 0, 0, 255})), {}, "wall");
  return builder.finish();
}

// Two walls in one plane, cut into different triangles. The finer one is larger and turned, and covers the coarse one.
class CoplanarWalls {
 public:
  explicit CoplanarWalls(bool coarseFirst) {
    SceneBuilder builder = testBuilder();
    Mesh coarse = meshOf(builder, "thing");
    appendPlane(coarse, 0, {}, 30, 30, 1);
    Mesh fine = meshOf(builder, "other", "dark");
    appendPlane(fine, 0, {toMatrix(fromYawPitchRoll(0.3, 0, 0)), {}}, 60, 60, 13);
    const std::uint32_t a = builder.addMesh(coarse);
    const std::uint32_t b = builder.addMesh(fine);
    builder.place(coarseFirst ? a : b, place_, "first");
    builder.place(coarseFirst ? b : a, place_, "second");
    scene = builder.finish();
  }

  // Expects that the first wall is reported where both are, and that all points lie in the plane within `tolerance`
  // (m).
  template <class Range>
  void expectTheFirst(const BeamTable& beams, const Hits& hits, const std::vector<Range>& range,
                      double tolerance) const {
    const Affine planeFromWorld = inverse(place_);
    std::size_t both = 0;
    for (std::size_t i = 0; i < hits.size(); ++i) {
      if (!hits.hit(i)) continue;
      const Vec3d p = planeFromWorld * (beams.direction[i] * range[i]);
      EXPECT_NEAR(p.z, 0, tolerance);
      if (!(std::abs(p.x) < 14.999 && std::abs(p.y) < 14.999)) continue;
      ++both;
      EXPECT_EQ(hits.instance[i], 1u) << "beam " << i << " range " << range[i];
    }
    EXPECT_GT(both, 5000u);
  }

  Scene scene;

 private:
  Affine place_{toMatrix(fromYawPitchRoll(0.4, 0.9, 0.2)), {3, 1, -4}};
};

// 40 columns that look along the x axis from x = 0.25, while the sensor moves by half a metre at each of seven steps.
inline Shot steppingAhead() {
  auto beams = beamsOf(std::vector<Vec3d>(40, {1, 0, 0}));
  beams->origin.assign(40, {0.25f, 0, 0});
  Shot shot = shotAt(beams);
  for (int step = 1; step < 7; ++step) shot.worldFromSensor.push_back({{}, {0.5 * step, 0, 0}});
  return shot;
}

// The first beam misses, and all its values are zero.
inline void expectZeroedMiss(const Hits& hits) {
  EXPECT_EQ(hits.range[0], kMiss);
  EXPECT_EQ(hits.instance[0], 0u);
  EXPECT_EQ(hits.semantic[0], 0u);
  EXPECT_EQ(hits.reflectance[0], 0.0f);
  EXPECT_EQ(hits.incidence[0], 0.0f);
  EXPECT_EQ(hits.normal[0], Vec3f{});
}

}  // namespace scanmill
