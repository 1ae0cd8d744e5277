#include "assets/asset.h"

#include <regex>
#include <string>
#include <vector>

#include "tests/core/assets/meshes/triangle_files.h"
#include "tests/core/assets/read_assets.h"

namespace scanmill {
namespace {

TEST_F(AssetFiles, EveryKindGivesTheSameTriangle) {
  write("a.mtl", kMtl);
  writeColours(folder_.path() / "colours.png");
  const std::vector<std::pair<std::string, std::string>> files{{"a.obj", kObj},           {"a.ply", kPly},
                                                               {"a.stl", kStl},           {"a.ac", kAc},
                                                               {"a.gltf", Gltf().text()}, {"a.glb", glbOfTriangle()}};
  for (const auto& [name, text] : files) {
    const std::vector<Vec3f> asWritten{{1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
    const std::vector<Vec3f> fromYUp{{1, 0, 0}, {0, 0, 2}, {0, -3, 0}};
    const bool yUp = name == "a.gltf" || name == "a.glb" || name == "a.ac";
    expectCorners(read(name, text), yUp ? fromYUp : asWritten, name);
    EXPECT_EQ(read(name, text).up, yUp ? 'y' : 'z') << name;
    EXPECT_EQ(read(name, text, {.up = 'x'}).up, 'x') << name;
    expectCorners(read(name, text, {.up = 'z'}), asWritten, name);
    expectCorners(read(name, text, {.metresPerUnit = 0.5, .up = 'z'}), {{0.5f, 0, 0}, {0, 1, 0}, {0, 0, 1.5f}}, name);
    expectCorners(read(name, text, {.up = 'y'}), fromYUp, name);
    expectCorners(read(name, text, {.up = 'x'}), {{0, 0, 1}, {-2, 0, 0}, {0, -3, 0}}, name);
  }
}

TEST_F(AssetFiles, ColladaDeclaresItsUnitAndUpAxis) {
  const auto at = [](float x, float y, float z) {
    return std::vector<Vec3f>{{x + 1, y, z}, {x, y + 2, z}, {x, y, z + 3}};
  };
  expectCorners(read("z.dae", dae("Z_UP", "1")), at(10, 20, 30), "Z_UP");
  expectCorners(read("y.dae", dae("Y_UP", "1")), {{11, -30, 20}, {10, -30, 22}, {10, -33, 20}}, "Y_UP");
  expectCorners(read("x.dae", dae("X_UP", "1")), {{-20, -30, 11}, {-22, -30, 10}, {-20, -33, 10}}, "X_UP");
  expectCorners(read("inch.dae", dae("Z_UP", "0.5")), {{5.5f, 10, 15}, {5, 11, 15}, {5, 10, 16.5f}}, "unit");
  expectCorners(read("scaled.dae", dae("Z_UP", "0.5"), {.metresPerUnit = 2}), at(10, 20, 30), "a scale on top");
  const std::vector<Vec3f> turned{{11, -30, 20}, {10, -30, 22}, {10, -33, 20}};
  expectCorners(read("z.dae", dae("Z_UP", "1"), {.up = 'y'}), turned, "replaced");
  expectCorners(read("y.dae", dae("Y_UP", "1"), {.up = 'y'}), turned, "confirmed");
  for (const char* declared : {"X_UP", "Y_UP", "Z_UP"}) {
    expectCorners(read("any.dae", dae(declared, "1"), {.up = 'z'}), at(10, 20, 30), declared);
    expectCorners(read("any.dae", dae(declared, "1"), {.up = 'x'}), {{-20, -30, 11}, {-22, -30, 10}, {-20, -33, 10}},
                  declared);
  }
  const std::string silent = std::regex_replace(dae("Z_UP", "1"), std::regex("<up_axis>.*</up_axis>"), "");
  expectCorners(read("silent.dae", silent), turned, "COLLADA's default");
  EXPECT_EQ(read("x.dae", dae("X_UP", "1")).up, 'x');
  EXPECT_EQ(read("y.dae", dae("Y_UP", "1")).up, 'y');
  EXPECT_EQ(read("z.dae", dae("Z_UP", "1")).up, 'z');
  EXPECT_EQ(read("z.dae", dae("Z_UP", "1"), {.up = 'y'}).up, 'y');
  EXPECT_EQ(read("silent.dae", silent).up, 'y');
  EXPECT_EQ(read("inch.dae", dae("Z_UP", "0.0254")).statedUnit, 0.0254);
  EXPECT_EQ(read("a.stl", kStl).statedUnit, 0);
}

TEST_F(AssetFiles, NamesAreTheFiles) {
  write("a.mtl", kMtl);
  writeColours(folder_.path() / "colours.png");
  for (const auto& [name, text] : std::vector<std::pair<std::string, std::string>>{
           {"a.obj", kObj}, {"a.stl", kStl}, {"a.ac", kAc}, {"a.gltf", Gltf().text()}, {"a.dae", dae("Z_UP", "1")}}) {
    EXPECT_EQ(read(name, text).parts.at(0).node, "wing") << name;
  }
  EXPECT_EQ(read("a.obj", kObj).parts.at(0).material, "paint");
  EXPECT_EQ(read("a.gltf", Gltf().text()).parts.at(0).material, "paint");
  EXPECT_EQ(read("a.ply", kPly).parts.at(0).material, "");
  EXPECT_EQ(read("a.ply", kPly).parts.at(0).node, "");
  Gltf unnamed;
  unnamed.nodes = R"([{"mesh":0}])";
  EXPECT_EQ(read("unnamed.gltf", unnamed.text()).parts.at(0).node, "");
}

TEST_F(AssetFiles, TransformsOfNodesAreAppliedInDoublePrecisionAndMirroringKeepsTheOutside) {
  Gltf gltf;
  gltf.nodes = R"([{"name":"far","translation":[1e7,0,0],"children":[1]},
                   {"name":"back","translation":[-1e7,0.25,0],"children":[2]},
                   {"name":"wing","scale":[-1,1,1],"mesh":0}])";
  const Asset asset = read("a.gltf", gltf.text());
  EXPECT_EQ(asset.parts.at(0).nodeIndex, 2u);
  expectCorners(asset, {{-1, 0, 0.25f}, {0, -3, 0.25f}, {0, 0, 2.25f}}, "mirrored");
}

TEST_F(AssetFiles, EveryPlacementOfAMeshIsAPart) {
  Gltf gltf;
  gltf.nodes = R"([{"name":"a","mesh":0},{"name":"empty"},{"name":"b","mesh":0,"translation":[0,0,5]}])";
  gltf.roots = "[0,1,2]";
  const Asset asset = read("a.gltf", gltf.text());
  ASSERT_EQ(asset.parts.size(), 2u);
  EXPECT_EQ(asset.parts[0].node, "a");
  EXPECT_EQ(asset.parts[1].node, "b");
  EXPECT_LT(asset.parts[0].nodeIndex, asset.parts[1].nodeIndex);
  EXPECT_EQ(asset.parts[1].positions[0].y - asset.parts[0].positions[0].y, -5);
}

TEST_F(AssetFiles, CornersOfTheSamePlaceAreSharedAndPolygonsAreCut) {
  std::string text = "solid fan\n";
  for (int i = 0; i < 60; ++i) {
    text += "facet normal 0 0 1\nouter loop\nvertex 0 0 0\n";
    for (const int k : {i, (i + 1) % 60}) {
      text += "vertex " + std::to_string(k) + " " + std::to_string(k * k) + " 0\n";
    }
    text += "endloop\nendfacet\n";
  }
  const Asset fan = read("fan.stl", text + "endsolid fan\n");
  EXPECT_EQ(fan.parts.at(0).triangles.size(), 60u);
  EXPECT_LE(fan.parts[0].positions.size(), 60u);
  const Asset quad = read("quad.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nl 1 2\nf 1 2 3 4\n");
  EXPECT_EQ(trianglesOf(quad), 2u);
}

}  // namespace
}  // namespace scanmill
