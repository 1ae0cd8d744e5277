#include <map>

#include "models/models.h"
#include "tests/support/labels.h"
#include "tests/support/test_scene.h"

namespace scanmill::models {
namespace {

struct Built {
  Scene scene;
  Mesh mesh;
};

Built build(const Block& block) {
  SceneBuilder builder = labelledBuilder();
  const Model model = makeBlock(builder, 1, block);
  builder.place(model.mesh, {}, "block");
  Built built{builder.finish(), {}};
  built.mesh = built.scene.meshes[model.mesh];
  return built;
}

// m^2 that lie level, by their height in centimetres.
std::map<long, double> levels(const Mesh& mesh) {
  std::map<long, double> area;
  for (const auto& t : mesh.triangles) {
    const Vec3d n = normalIn(mesh, t);
    if (std::abs(n.z) < 0.999 * length(n) || n.z < 0) continue;
    area[std::lround(100 * cornersIn(mesh, t)[0].z)] += length(n) / 2;
  }
  return area;
}

// An L with a court: the roof and each floor are as large as the outline without the court.
TEST(Block, RoofAndFloorsFillTheOutline) {
  Block block;
  block.outline = {{0, 0}, {40, 0}, {40, 30}, {20, 30}, {20, 20}, {0, 20}};
  block.courts = {{{5, 5}, {5, 12}, {15, 12}, {15, 5}}};
  block.floors = 3;
  block.entrance = {20, -2};
  const double size = 40 * 20 + 20 * 10 - 70;
  std::size_t full = 0;
  for (const auto& [height, area] : levels(build(block).mesh)) full += std::abs(area - size) < 1e-3 ? 1 : 0;
  EXPECT_EQ(full, 4u) << "three floors and a roof";
}

TEST(Block, IsAsHighAsItSays) {
  for (const double height : {9.0, 14.5}) {
    Block block;
    block.outline = {{-8, -6}, {8, -6}, {9, 7}, {-8, 6}};
    block.floors = 3;
    block.height = height;
    const Box box = build(block).mesh.bounds();
    EXPECT_NEAR(box.high.z, height, 0.05);
    EXPECT_NEAR(box.low.x, -8, 0.3);
    EXPECT_NEAR(box.high.x, 9, 0.3);
  }
}

// Windows are panes of glass that beams pass, of which a shed has none.
TEST(Block, ShedsHaveNoWindows) {
  Block block;
  block.outline = {{0, 0}, {6, 0}, {6, 4}, {0, 4}};
  const auto panes = [&](int floors) {
    block.floors = floors;
    const Built built = build(block);
    std::size_t count = 0;
    for (const std::uint16_t s : built.mesh.surfaceOf) {
      count += built.scene.materials[built.mesh.surfaces[s].material].name.starts_with("glass") ? 1 : 0;
    }
    return count;
  };
  EXPECT_GT(panes(2), 8u);
  EXPECT_LE(panes(0), 2u) << "the door's";
}

// A podium with a tower that hangs over it: nothing of the podium is higher than its roof.
TEST(Block, PartsStandInItsPlace) {
  Block podium;
  podium.outline = {{-20, -20}, {20, -20}, {20, 20}, {-20, 20}};
  podium.height = 10;
  podium.parapet = false;
  Block tower = podium;
  tower.outline = {{-8, -8}, {8, -8}, {8, 8}, {-8, 8}};
  tower.base = 10;
  tower.height = 60;
  tower.floors = 15;
  Block block = podium;
  block.height = 60;
  block.parts = {podium, tower};
  const Mesh mesh = build(block).mesh;
  EXPECT_NEAR(mesh.bounds().high.z, 60, 1e-4);
  double beside = 0;
  for (const Vec3f& p : mesh.positions) {
    if (std::max(std::abs(p.x), std::abs(p.y)) > 9) beside = std::max(beside, double{p.z});
  }
  EXPECT_NEAR(beside, 10, 1e-4);
  EXPECT_NEAR(build(tower).mesh.bounds().low.z, 10, 1e-4);
}

// Slopes lead from the walls to the ridge, gables stand upright.
TEST(Block, RoofsRiseToTheirRidge) {
  Block block;
  block.outline = {{0, 0}, {20, 0}, {20, 12}, {0, 12}};
  block.floors = 0;
  block.height = 6;
  block.rise = 4;
  const auto tiles = [&](const Point2& a, const Point2& b) {
    block.ridge = {a, b};
    const Built built = build(block);
    EXPECT_NEAR(built.mesh.bounds().high.z, 10, 1e-4);
    double area = 0;
    for (std::size_t t = 0; t < built.mesh.triangles.size(); ++t) {
      if (built.scene.materials[built.mesh.surfaces[built.mesh.surfaceOf[t]].material].name != "roof_tile") continue;
      const Vec3d n = normalIn(built.mesh, built.mesh.triangles[t]);
      const bool roof = cornersIn(built.mesh, built.mesh.triangles[t])[2].z > 9.9;  // not the one over the door
      if (!roof) continue;
      area += n.z / 2;
      EXPECT_GT(n.z, 0);
    }
    return area;
  };
  EXPECT_NEAR(tiles({0, 6}, {20, 6}), 240, 0.1) << "gabled";
  EXPECT_NEAR(tiles({6, 6}, {14, 6}), 240, 0.1) << "hipped";
  EXPECT_NEAR(tiles({10, 6}, {10, 6}), 240, 0.1) << "pyramidal";
  EXPECT_NEAR(tiles({0, 12}, {20, 12}), 240, 0.1) << "skillion";
}

}  // namespace
}  // namespace scanmill::models
