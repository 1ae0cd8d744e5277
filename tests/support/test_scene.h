#pragma once

// Small scenes and beam tables made in code.

#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "base/vec.h"
#include "scene/builder.h"
#include "scene/primitives.h"
#include "sensors/beams.h"
#include "sensors/shot.h"

namespace scanmill {

inline Ontology testOntology() {
  Ontology ontology;
  ontology.name = "test";
  ontology.classes = {{0, "unlabeled", {0, 0, 0}, false, {}},
                      {1, "ground", {1, 2, 3}, false, {}},
                      {2, "thing", {4, 5, 6}, true, {}},
                      {3, "other", {7, 8, 9}, true, {}}};
  return ontology;
}

inline MaterialLibrary testMaterials() {
  MaterialLibrary library;
  for (const auto& [name, reflectance] : {std::pair{"grey", 0.5f}, {"dark", 0.1f}}) {
    Material& material = library.materials.emplace_back();
    material.name = name;
    material.reflectance = reflectance;
  }
  return library;
}

inline SceneBuilder testBuilder() {
  return SceneBuilder("test", 1, testOntology(), testMaterials());
}

inline Mesh meshOf(SceneBuilder& builder, const char* className, const char* material = "grey") {
  Mesh mesh;
  mesh.name = className;
  mesh.surfaces.push_back(builder.surface(className, material));
  return mesh;
}

// The scene with this mesh alone.
inline Scene sceneWith(SceneBuilder& builder, const Mesh& mesh, const Affine& place = {}) {
  builder.place(builder.addMesh(mesh), place, mesh.name);
  return builder.finish();
}

// The corners of a triangle in its mesh's frame.
inline std::array<Vec3d, 3> cornersIn(const Mesh& mesh, const Triangle& t) {
  return {Vec3d(mesh.positions[t[0]]), Vec3d(mesh.positions[t[1]]), Vec3d(mesh.positions[t[2]])};
}

// A vector of twice the triangle's area (m^2), to the side from which its corners go counter-clockwise.
inline Vec3d normalIn(const Mesh& mesh, const Triangle& t) {
  const auto [a, b, c] = cornersIn(mesh, t);
  return cross(b - a, c - a);
}

inline Affine at(double x, double y, double z) {
  return {{}, {x, y, z}};
}

// A scene of one mesh of a class, to which fill(mesh) appends the triangles.
template <class Fill>
Scene oneMeshScene(const char* className, const Fill& fill, const Affine& place = {}) {
  SceneBuilder builder = testBuilder();
  Mesh mesh = meshOf(builder, className);
  fill(mesh);
  builder.place(builder.addMesh(std::move(mesh)), place, className);
  return builder.finish();
}

// A flat ground of `size` x `size` metres, cut into `cells` x `cells` squares.
inline Scene flatGround(const Vec3d& middle, double size, std::uint32_t cells) {
  const auto fill = [&](Mesh& ground) { appendPlane(ground, 0, {}, size, size, cells); };
  return oneMeshScene("ground", fill, {{}, middle});
}

// A beam table with given directions, as one ring.
inline std::shared_ptr<BeamTable> beamsOf(const std::vector<Vec3d>& directions, double minRange = 0,
                                          double maxRange = 1000) {
  auto beams = std::make_shared<BeamTable>();
  beams->model = "test";
  beams->rings = 1;
  beams->columns = static_cast<std::uint32_t>(directions.size());
  for (const Vec3d& d : directions) beams->direction.push_back(normalized(d));
  beams->time.assign(directions.size(), 0.0f);
  beams->minRange = minRange;
  beams->maxRange = maxRange;
  beams->period = 0.1;
  beams->elevation = {0};
  return beams;
}

// Rings spread evenly over [low, high] degrees, full turns.
inline std::shared_ptr<BeamTable> spinning(std::uint32_t rings, std::uint32_t columns, double low, double high,
                                           double maxRange = 1000) {
  auto beams = std::make_shared<BeamTable>();
  beams->model = "test";
  beams->rings = rings;
  beams->columns = columns;
  beams->maxRange = maxRange;
  beams->period = 0.1;
  for (std::uint32_t r = 0; r < rings; ++r) {
    const double share = rings == 1 ? 0.5 : static_cast<double>(r) / (rings - 1);
    beams->elevation.push_back(radians(high + (low - high) * share));
  }
  for (std::uint32_t r = 0; r < rings; ++r) {
    for (std::uint32_t c = 0; c < columns; ++c) {
      const double azimuth = 2 * kPi * c / columns;
      const double e = beams->elevation[r];
      beams->direction.push_back({std::cos(e) * std::cos(azimuth), std::cos(e) * std::sin(azimuth), std::sin(e)});
      beams->time.push_back(static_cast<float>(0.1 * c / columns));
    }
  }
  return beams;
}

inline Shot shotAt(std::shared_ptr<const BeamTable> beams, const Pose& worldFromSensor = {}) {
  Shot shot;
  shot.seed = 1;
  shot.sensorName = "lidar";
  shot.beams = std::move(beams);
  shot.worldFromSensor = {worldFromSensor};
  return shot;
}

}  // namespace scanmill
