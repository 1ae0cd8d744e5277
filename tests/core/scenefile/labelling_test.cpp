#include "scenefile/labelling.h"

#include "tests/support/labels.h"
#include "tests/support/message_of.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

using testing::ElementsAre;

// A square of two triangles, its corner at `at`, in the plane z.
void addSquare(AssetPart& part, const Vec3f& at, float side, const Vec2f& uv = {0, 0}) {
  const auto first = static_cast<std::uint32_t>(part.positions.size());
  for (const auto& [x, y] : {std::pair{0.0f, 0.0f}, {side, 0.0f}, {side, side}, {0.0f, side}}) {
    part.positions.push_back({at.x + x, at.y + y, at.z});
    part.uvs.push_back(uv);
  }
  part.triangles.push_back({first, first + 1, first + 2});
  part.triangles.push_back({first, first + 2, first + 3});
}

AssetPart part(const std::string& node, const std::string& material = {}) {
  AssetPart p;
  p.node = node;
  p.material = material;
  return p;
}

struct Labelled {
  Scene scene;
  // The triangles of each class, by its name.
  std::map<std::string, std::uint64_t> classes;
};

Labelled labelled(std::vector<AssetPart> parts, const std::string& rules, const ThingBounds& things = {}) {
  SceneBuilder b = labelledBuilder();
  Labelling labelling;
  labelling.things = things;
  labelling.file = "asset.obj";
  labelling.rules = readRules(parseYaml(rules, "rules.yaml"));
  Asset asset;
  asset.parts = std::move(parts);
  for (const PlacedMesh& m : addAsset(b, std::move(asset), labelling, {"scene.yaml", 1, 1})) b.place(m.mesh, {}, "a");
  Scene scene = b.finish();
  return {scene, trianglesByClass(scene)};
}

using Classes = std::map<std::string, std::uint64_t>;

TEST(Labelling, TheFirstRuleThatMatchesWins) {
  std::vector<AssetPart> parts{part("RoadMesh"), part("GrassMesh"), part("x")};
  for (AssetPart& p : parts) addSquare(p, {0, 0, 0}, 1);
  const Labelled l = labelled(parts,
                              "- {match: {node: 'Road*'}, class: road}\n"
                              "- {match: {node: '*Mesh'}, class: terrain}\n"
                              "- {match: any, class: object}\n");
  EXPECT_EQ(l.classes, (Classes{{"road", 2}, {"terrain", 2}, {"object", 2}}));
}

TEST(Labelling, ClassAndMaterialAreLookedForApart) {
  std::vector<AssetPart> parts{part("House", "dark"), part("House", "wall"), part("Tree", "dark")};
  for (AssetPart& p : parts) addSquare(p, {0, 0, 0}, 1);
  const Labelled l = labelled(parts,
                              "- {match: {material: dark}, material: glass}\n"
                              "- {match: {node: House}, class: building}\n"
                              "- {match: any, class: object, material: wood}\n");
  EXPECT_EQ(l.classes, (Classes{{"building", 4}, {"object", 2}}));
  std::vector<std::string> materials;
  for (const Surface& s : l.scene.meshes[0].surfaces) materials.push_back(l.scene.materials[s.material].name);
  EXPECT_THAT(materials, ElementsAre("glass", "wood", "glass"));
}

TEST(Labelling, WhatIsDroppedIsGone) {
  std::vector<AssetPart> parts{part("sky"), part("ground")};
  for (AssetPart& p : parts) addSquare(p, {0, 0, 0}, 1);
  const char* const rules = "- {match: {node: sky}, drop: true}\n- {match: any, class: terrain, material: soil}\n";
  const Labelled l = labelled(parts, rules);
  EXPECT_EQ(l.classes, (Classes{{"terrain", 2}}));
  EXPECT_TRUE(l.scene.unlabeled.empty());
  expectInputError([&] { labelled({parts[0]}, rules); }, {"scene.yaml:1", "asset.obj", "rules drop 2"});
}

// A palette of four colours, one node, one material: what comes apart are squares of 2 triangles.
TEST(Labelling, APaletteComesApartByColour) {
  const auto texture = std::make_shared<Texture>();
  texture->width = texture->height = 2;
  texture->rgba = {200, 30, 30, 255, 30, 200, 30, 255, 30, 30, 200, 255, 90, 90, 90, 255};  // from the bottom row on
  AssetPart p = part("merged");
  p.fileMaterial.texture = texture;
  p.fileMaterial.textured = true;
  for (int i = 0; i < 12; ++i) {
    const Vec2f uv{0.25f + 0.5f * static_cast<float>(i % 2), 0.25f + 0.5f * static_cast<float>(i / 2 % 2)};
    addSquare(p, {static_cast<float>(2 * i), 0, 0}, 1, uv);
  }
  const Labelled l = labelled({p},
                              "- {match: {color: '#c81e1e'}, class: car}\n"
                              "- {match: {color: ['#20cc20', '#1e1ec8']}, class: tree}\n");
  EXPECT_EQ(l.classes, (Classes{{"car", 6}, {"tree", 12}, {"unlabeled", 6}}));
  // Nothing is lost, and no corner moves.
  double area = 0;
  for (const Triangle& t : l.scene.meshes[0].triangles) area += length(normalIn(l.scene.meshes[0], t)) / 2;
  EXPECT_NEAR(area, 12, 1e-5);
}

// The plain colour of a material is sRGB: half of the light is #bcbcbc.
TEST(Labelling, PlainColoursAreMatchedAsScreensShowThem) {
  AssetPart p = part("grey");
  p.color = {0.5f, 0.5f, 0.5f};
  addSquare(p, {0, 0, 0}, 1);
  EXPECT_EQ(labelled({p}, "- {match: {color: '#bcbcbc', within: 1}, class: wall}\n").classes, (Classes{{"wall", 2}}));
  EXPECT_EQ(labelled({p}, "- {match: {color: '#808080', within: 8}, class: wall}\n").classes,
            (Classes{{"unlabeled", 2}}));
}

TEST(Labelling, AMergedMeshComesApartByHeightBoxAndSizeOfConnectedParts) {
  AssetPart p = part("merged");
  addSquare(p, {0, 0, -10}, 100);  // the ground, the lowest
  addSquare(p, {5, 5, -8}, 2);     // two tables that share a corner: one part of 4 m
  addSquare(p, {7, 7, -8}, 2);
  addSquare(p, {50, 50, -8}, 0.5f);  // a crumb
  addSquare(p, {50, 60, 30}, 8);     // a ceiling
  const Labelled l = labelled({p},
                              "- {match: {height: [35, 50]}, drop: true}\n"
                              "- {match: {height: [0, 0.1]}, class: road}\n"
                              "- {match: {size: [3.9, 4.1]}, class: structure}\n"
                              "- {match: {box: [[49, 49, -9], [51, 51, -7]]}, class: object}\n");
  EXPECT_EQ(l.classes, (Classes{{"road", 2}, {"structure", 4}, {"object", 2}}));
}

TEST(Labelling, DividesAMeshIntoItsConnectedThings) {
  AssetPart p = part("merged");
  addSquare(p, {0, 0, 0}, 50);
  addSquare(p, {5, 5, 1}, 2);
  addSquare(p, {15, 5, 1}, 2);
  ThingBounds byPart;
  byPart.by = ThingBounds::By::Part;
  const Labelled l = labelled({p}, "- {match: {size: [0, 10]}, class: car}\n- {match: any, class: road}\n", byPart);
  EXPECT_EQ(l.classes, (Classes{{"car", 4}, {"road", 2}}));
  EXPECT_EQ(l.scene.things(), 2u);
  const Mesh& mesh = l.scene.meshes[0];
  std::map<std::uint32_t, Box> boxes;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t c : mesh.triangles[t]) {
      boxes[mesh.surfaces[mesh.surfaceOf[t]].object].add(Vec3d(mesh.positions[c]));
    }
  }
  EXPECT_EQ(boxes[1].low.x, 5);
  EXPECT_EQ(boxes[2].low.x, 15);
  EXPECT_EQ(boxes[0].high.x, 50) << "the road is no thing";
}

// What cannot be traced is no thing.
TEST(Labelling, SliversAreNoThings) {
  AssetPart p = part("merged");
  addSquare(p, {5, 5, 1}, 2);
  addSquare(p, {25, 5, 1}, 0);
  addSquare(p, {35, 5, 1}, 0);
  ThingBounds byPart;
  byPart.by = ThingBounds::By::Part;
  const Labelled l = labelled({p}, "- {match: any, class: car}\n", byPart);
  EXPECT_EQ(l.scene.things(), 1u);
  EXPECT_EQ(l.scene.dropped.degenerate, 4u);
}

TEST(Labelling, TellsWhatCameOfEachRule) {
  std::vector<AssetPart> parts{part("tree_1"), part("tree_2"), part("wall")};
  for (AssetPart& p : parts) addSquare(p, {0, 0, 0}, 1);
  const Labelled l = labelled(parts,
                              "- {match: {node: 'tree*'}, class: tree}\n"
                              "- {match: {node: tree_2}, class: car}\n"
                              "- {match: {node: house}, class: building}\n"
                              "- {match: any, material: wood}\n");
  ASSERT_EQ(l.scene.rules.size(), 4u);
  const auto expect = [&](std::size_t rule, std::uint64_t matched, std::uint64_t decided) {
    EXPECT_EQ(l.scene.rules[rule].matched, matched) << rule;
    EXPECT_EQ(l.scene.rules[rule].decided, decided) << rule;
    EXPECT_EQ(l.scene.rules[rule].where.line, static_cast<int>(rule) + 1);
  };
  expect(0, 4, 4);
  expect(1, 2, 0);
  expect(2, 0, 0);
  expect(3, 6, 6);
  EXPECT_EQ(l.scene.rules[0].match, "node: tree*");
  EXPECT_EQ(l.scene.rules[3].gives, "material wood");
}

}  // namespace
}  // namespace scanmill
