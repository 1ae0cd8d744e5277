#include <fmt/format.h>

#include <functional>

#include "models/models.h"
#include "tests/support/labels.h"

namespace scanmill::models {
namespace {

// The highest point of a mesh's triangles of a surface that `counts`.
template <class Counts>
double highest(const Mesh& mesh, const Counts& counts) {
  double top = -1e9;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!counts(mesh.surfaceOf[t])) continue;
    for (const std::uint32_t corner : mesh.triangles[t]) {
      top = std::max(top, static_cast<double>(mesh.positions[corner].z));
    }
  }
  return top;
}

Scene sceneOf(const std::function<Model(SceneBuilder&)>& make) {
  SceneBuilder builder = labelledBuilder();
  builder.place(make(builder).mesh, {}, "house");
  return builder.finish();
}

// Chimneys do not count; the tiles of a ridge stand out by a decimetre. 4.5 m is all that two low storeys leave.
TEST(Buildings, RoofsAreAsHighAsAskedFor) {
  for (const Roof roof : {Roof::Flat, Roof::Gable, Roof::CrossGable, Roof::Hip}) {
    for (const auto& [floors, top] : {std::pair{1, 4.5}, {2, 6.5}, {2, 9.0}, {3, 13.0}, {6, 20.0}, {1, 15.0}}) {
      for (std::uint32_t number = 0; number < 5; ++number) {
        SCOPED_TRACE(fmt::format("roof {}, {} floors, {} m, house {}", static_cast<int>(roof), floors, top, number));
        House house;
        house.roof = roof;
        house.floors = floors;
        house.number = number;
        house.top = top;
        const Scene scene = sceneOf([&](SceneBuilder& b) { return makeHouse(b, 7, house); });
        const Mesh& mesh = scene.meshes.at(scene.instances.at(0).mesh);
        const double found = highest(mesh, [&](std::uint16_t s) {
          return roof == Roof::Flat ? s == 0 : scene.materials[mesh.surfaces[s].material].name == "roof_tile";
        });
        EXPECT_NEAR(found, top, 0.15);
      }
    }
  }
}

TEST(Buildings, RoofsRiseAsAskedFor) {
  House house;
  house.floors = 1;
  house.top = 9;
  house.rise = 1;
  const Scene scene = sceneOf([&](SceneBuilder& b) { return makeHouse(b, 7, house); });
  const Mesh& mesh = scene.meshes.at(scene.instances.at(0).mesh);
  double eaves = 1e9;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::string& material = scene.materials[mesh.surfaces[mesh.surfaceOf[t]].material].name;
    if (material != "roof_tile") continue;
    for (const std::uint32_t corner : mesh.triangles[t]) {
      if (mesh.positions[corner].z > 5) eaves = std::min(eaves, double{mesh.positions[corner].z});
    }
  }
  EXPECT_NEAR(eaves, 8 - 0.4 / 4.5 - 0.16, 0.15);
}

}  // namespace
}  // namespace scanmill::models
