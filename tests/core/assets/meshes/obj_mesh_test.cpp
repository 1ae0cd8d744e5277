#include <fmt/format.h>

#include <map>
#include <string>
#include <vector>

#include "assets/meshes/imported_file.h"
#include "scene/builder.h"
#include "tests/core/assets/meshes/triangle_files.h"
#include "tests/core/assets/read_assets.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::Pair;
using testing::UnorderedElementsAre;

// Four corners of a square of 1 m, and the statements that follow.
std::string square(const std::string& rest) {
  return "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n" + rest;
}

class ObjMesh : public AssetFiles {
 protected:
  ImportedFile obj(const std::string& text, const AssetOptions& options = {}) {
    return readObjMesh(write("a.obj", text), options);
  }

  // Returns the number of triangles by the name of their node.
  std::map<std::string, std::size_t> trianglesByNode(const std::string& text) {
    std::map<std::string, std::size_t> counts;
    for (const AssetPart& part : obj(text).parts) counts[part.node] += part.triangles.size();
    return counts;
  }

  // Returns what reading the text warns of.
  std::string told(const std::string& text) {
    const auto file = write(fmt::format("told_{}.obj", ++files_), text);
    return printedBy([&] { readObjMesh(file, {}).leftOut.warn(file.string()); });
  }

 private:
  int files_ = 0;
};

TEST_F(ObjMesh, NamesHaveSpaces) {
  EXPECT_THAT(trianglesByNode(square("o Wall North\nf 1 2 3\no Roof\nf 1 2 3 4\no Wall South \t\nf 1 3 4\n")),
              UnorderedElementsAre(Pair("Wall North", 1), Pair("Roof", 2), Pair("Wall South", 1)));
  EXPECT_THAT(trianglesByNode(square("g Building Roof\nf 1 2 3\ng Building Wall\nf 1 2 3 4\n")),
              UnorderedElementsAre(Pair("Building Roof", 1), Pair("Building Wall", 2)));
}

TEST_F(ObjMesh, AnObjectThatComesAgainIsTheSameNode) {
  const ImportedFile file = obj(square("o Wall\nf 1 2 3\no Roof\nf 1 2 3 4\no Wall\nf 1 3 4\n"));
  EXPECT_EQ(file.leftOut.text(), "1 further objects with the name of an earlier one (they are one node)");
  ASSERT_EQ(file.parts.size(), 2u);
  EXPECT_EQ(file.parts[0].node, "Wall");
  EXPECT_EQ(file.parts[0].triangles.size(), 2u);
  EXPECT_EQ(file.parts[1].node, "Roof");
}

TEST_F(ObjMesh, GroupsOfTwoObjectsAreTwoNodes) {
  const ImportedFile file = obj(square("f 1 2 3\no Left\ng walls\nf 1 2 3\no Right\nf 1 3 4\ng walls\nf 1 2 4\n"));
  std::vector<std::pair<std::string, std::uint32_t>> nodes;
  for (const AssetPart& part : file.parts) nodes.emplace_back(part.node, part.nodeIndex);
  EXPECT_THAT(nodes, ElementsAre(Pair("", 1), Pair("walls", 2), Pair("Right", 3), Pair("walls", 4)));
}

TEST_F(ObjMesh, CommentsStandBehindNumbersAndInNames) {
  EXPECT_EQ(
      trianglesByNode("v 5 5 5 # corner 1 of 4\nv 6 5 5# corner 2\nv 5 6 5\no Wall #3\nf 1 2 3 # 4\n").at("Wall #3"),
      1u);
}

TEST_F(ObjMesh, VerticesHaveThreeToEightNumbers) {
  const std::string message =
      told("v 0 0 0 # corner 1 of 4\nv 1 0 0 1\nv 1 1 0 0.5 0.5 0.5\nv 0 1 0 0.5 0.5 0.5 1\nf 1 2 3 4 # all\n");
  EXPECT_THAT(message, HasSubstr("left out: 2 colours of vertices"));
  EXPECT_EQ(trianglesByNode("v 0 0 0 1 1 1 1\nv 1 0 0 1 1 1 1\nv 1 1 0 1 1 1 1\nf 1 2 3\n").at(""), 1u);
}

TEST_F(ObjMesh, IndicesCountFromTheEndToo) {
  const ImportedFile a = obj(square("f 1 2 3 4\n"));
  const ImportedFile b = obj(square("f -4 -3 -2 -1\nv 9 9 9\n"));
  EXPECT_EQ(a.parts.at(0).positions, b.parts.at(0).positions);
  EXPECT_EQ(a.parts.at(0).triangles, b.parts.at(0).triangles);
  const ImportedFile bad = obj(square("f 1 2 5\nf 0 1 2\nf -5 1 2\nf 1 2 3 9\nf 1 2 3\n"));
  EXPECT_EQ(bad.dropped.outOfRange, 5u);
  EXPECT_EQ(bad.parts.at(0).triangles.size(), 1u);
}

// A file in coordinates of UTM has all its digits.
TEST_F(ObjMesh, CoordinatesAreReadInDouble) {
  const ImportedFile file =
      obj("v 455000.125 5427000.25 100\nv 455001.375 5427000.25 100\nv 455000.125 5427001.5 100\nf 1 2 3\n");
  const std::vector<Vec3f>& p = file.parts.at(0).positions;
  ASSERT_EQ(p.size(), 3u);
  EXPECT_EQ(file.origin, (Vec3d{455000, 5427000, 0}));
  EXPECT_EQ(p[0], (Vec3f{0.125f, 0.25f, 100}));
  EXPECT_EQ(p[1], (Vec3f{1.375f, 0.25f, 100}));
  EXPECT_EQ(p[2], (Vec3f{0.125f, 1.5f, 100}));
  const ImportedFile scaled = obj("v 1 2 3\nv 2 2 3\nv 1 3 3\nf 1 2 3\n", {.metresPerUnit = 0.5, .up = 'y'});
  EXPECT_EQ(scaled.parts.at(0).positions[0], (Vec3f{0.5f, -1.5f, 1}));
}

TEST_F(ObjMesh, LinesGoOnAfterABackslash) {
  EXPECT_EQ(trianglesByNode(square("o Long \\\r\n name\r\nf 1 \\\r\n  2 \\\r\n 3 4")).at("Long name"), 2u);
}

TEST_F(ObjMesh, WhatIsLeftOutIsTold) {
  const std::string message =
      told(square("vn 0 0 1\ns off\nf 1//1 2//1 3//1\nl 1 2\nl 2 3 4\np 1\ncstype bezier\ndeg 3 3\n"
                  "surf 0 1 0 1 1 2 3 4\nend\nfancy 1 2\n"));
  EXPECT_THAT(message,
              AllOf(HasSubstr("2 lines (l)"), HasSubstr("1 points (p)"), HasSubstr("1 free-form surfaces (surf)"),
                    HasSubstr("1 unknown 'fancy'"), Not(HasSubstr("bezier")), Not(HasSubstr("vn"))));
  EXPECT_EQ(told(square("vn 0 0 1\ns 1\nlod 2\nf 1 2 3\n")), "");
  EXPECT_THAT(told(square("call part.obj\ncsh -ls\nusemap wall\nf 1 2 3\n")),
              HasSubstr("1 images of map libraries (usemap), 2 other files and commands (call, csh)\n"));
}

TEST_F(ObjMesh, MaterialsAreThoseOfLibraries) {
  write("two words.mtl",
        "newmtl Brick #25\nKd 0.2 0.4 0.6\nd 0.5\nPr 0.3\nPm 0.7\nmap_Kd -s 2 4 -o 0.5 0.25 red brick.png\n"
        "newmtl Grey\nKd 0.3\nTr 0.25\nmap_d -imfchan m alpha.png\nKs 1 1 1\nillum 2\n"
        "newmtl Brick #25\nKd 1 1 1\n");
  const ImportedFile file =
      obj(square("mtllib two words.mtl\nvt 0.5 0.5\nusemtl Brick #25\nf 1/1 2/1 3/1\nusemtl Grey\nf 1 3 4\n"
                 "usemtl Other\nf 1 2 4\nusemtl\nf 2 3 4\n"));
  ASSERT_EQ(file.parts.size(), 4u);
  const auto material = [&](std::size_t part) { return file.materials.at(file.parts.at(part).materialIndex); };
  EXPECT_EQ(material(0).name, "Brick #25");
  EXPECT_EQ(material(0).color, (std::array<float, 3>{0.2f, 0.4f, 0.6f}));
  EXPECT_EQ(material(0).opacity, 0.5f);
  EXPECT_EQ(material(0).roughness, 0.3f);
  EXPECT_EQ(material(0).metallic, 0.7f);
  EXPECT_EQ(material(0).base.name, "red brick.png");
  EXPECT_EQ(file.parts[0].uvs.at(0), (Vec2f{1.5f, 2.25f})) << "scale and offset of the texture";
  EXPECT_EQ(material(1).name, "Grey");
  EXPECT_EQ(material(1).color, (std::array<float, 3>{0.3f, 0.3f, 0.3f}));
  EXPECT_EQ(material(1).opacity, 0.75f);
  EXPECT_EQ(material(1).opacityMap.name, "alpha.png");
  EXPECT_EQ(material(2).name, "Other");
  EXPECT_FALSE(material(2).stated) << "no library defines it";
  EXPECT_EQ(material(3).name, "");
  EXPECT_FALSE(material(3).stated);
}

TEST_F(ObjMesh, LibrariesMayStandBehindTheFaces) {
  write("late.mtl", "newmtl one\nKd 0.1 0.2 0.3\nmap_Kd -s 2 2 a.png\n");
  const ImportedFile file = obj(square("vt 0.5 0.5\nusemtl one\nf 1/1 2/1 3/1\nmtllib late.mtl\n"));
  EXPECT_EQ(file.materials.at(file.parts.at(0).materialIndex).color, (std::array<float, 3>{0.1f, 0.2f, 0.3f}));
  EXPECT_EQ(file.parts[0].uvs.at(0), (Vec2f{1, 1}));
}

TEST_F(ObjMesh, MaterialsWithoutColourHaveTheDefaultReflectance) {
  write("some.mtl", "newmtl red\nKd 0.4 0 0\nnewmtl shiny\nNs 10\n");
  const ImportedFile file =
      obj(square("mtllib some.mtl\nusemtl red\nf 1 2 3\nusemtl shiny\nf 1 2 3\nusemtl gone\nf 1 2 3\nf 1 3 4\n"));
  const auto material = [&](std::size_t part) { return file.materials.at(file.parts.at(part).materialIndex); };
  EXPECT_EQ(material(0).name, "red");
  EXPECT_EQ(material(0).color, (std::array<float, 3>{0.4f, 0, 0}));
  EXPECT_TRUE(material(0).stated);
  EXPECT_FALSE(material(1).stated);
  EXPECT_FALSE(material(2).stated);
  EXPECT_EQ(file.leftOut.text(), "1 materials that no library defines (they have the default reflectance)");
  EXPECT_EQ(obj(square("usemtl gone\nf 1 2 3\n")).leftOut.text(), "") << "without a library names are but names";
}

TEST_F(ObjMesh, FacesWithoutTextureCoordinatesAreAPartOfTheirOwn) {
  write("paint.mtl", "newmtl paint\nmap_Kd a.png\nnewmtl plain\nKd 1 1 1\n");
  const std::string faces = "f 1/1 2/1 3/1\nf 1 3 4\nf 1/7 3/1 4/1\n";
  const ImportedFile file =
      obj(square("mtllib paint.mtl\nvt 0.5 0.5\nusemtl paint\n" + faces + "usemtl plain\n" + faces));
  ASSERT_EQ(file.parts.size(), 3u);
  EXPECT_EQ(file.parts[0].triangles.size(), 1u);
  EXPECT_FALSE(file.parts[0].uvs.empty());
  EXPECT_EQ(file.parts[1].triangles.size(), 2u);
  EXPECT_TRUE(file.parts[1].uvs.empty());
  EXPECT_EQ(file.parts[1].nodeIndex, file.parts[0].nodeIndex);
  EXPECT_EQ(file.parts[2].triangles.size(), 3u) << "without an image the faces stay together";
}

TEST_F(ObjMesh, OptionsOfImagesThatAreNotReadAreCounted) {
  const auto read = [&](const std::string& material) {
    write("paint.mtl", "newmtl paint\n" + material);
    return obj(square("mtllib paint.mtl\nvt 0.5 0.5\nusemtl paint\nf 1/1 2/1 3/1\n"));
  };
  const std::string differ = "1 placements of map_d (-s, -o) that differ from that of map_Kd";
  for (const char* material : {"map_d -s 2 2 l.png\nmap_Kd g.png\n", "map_Kd g.png\nmap_d -s 2 2 l.png\n"}) {
    const ImportedFile file = read(material);
    EXPECT_EQ(file.parts.at(0).uvs.at(0), (Vec2f{0.5f, 0.5f}));
    EXPECT_EQ(file.leftOut.text(), differ);
  }
  EXPECT_TRUE(read("map_Kd -s 2 2 g.png\nmap_d -s 2 2 l.png\n").leftOut.empty());
  EXPECT_EQ(read("map_d -s 2 2 l.png\n").parts.at(0).uvs.at(0), (Vec2f{1, 1}));
  EXPECT_EQ(read("map_Kd -mm 0.2 0.5 -clamp on g.png\n").leftOut.text(),
            "1 options of images (-clamp), 1 options of images (-mm)");
  EXPECT_EQ(read("map_Kd -blendu on -blendv on -mm 0.0 1.0 -clamp off -bm 1.000 -imfchan m g.png\n").leftOut.text(), "")
      << "their defaults";
}

// Exporters name one library several times.
TEST_F(ObjMesh, TheFirstDefinitionOfANameCountsAndOthersAreCounted) {
  write("one.mtl", "newmtl paint\nKd 1 0 0\nKs 1 1 1\nnewmtl paint\nKd 1 0 0\nKs 0 0 0\n");
  write("two.mtl", "newmtl paint\nKd 0 1 0\nnewmtl other\nnewmtl paint\nd 0.5\n");
  const std::string faces = "usemtl paint\nf 1 2 3\n";
  const std::string further = " further definitions of materials (the first of a name counts)";
  EXPECT_EQ(obj(square("mtllib one.mtl\nmtllib one.mtl\n" + faces)).leftOut.text(), "1" + further) << "read once";
  const ImportedFile file = obj(square("mtllib one.mtl\nmtllib two.mtl\n" + faces));
  EXPECT_EQ(file.materials.at(file.parts.at(0).materialIndex).color, (std::array<float, 3>{1, 0, 0}));
  EXPECT_EQ(file.materials.at(file.parts.at(0).materialIndex).opacity, 1);
  EXPECT_EQ(file.leftOut.text(), "3" + further);
}

TEST_F(ObjMesh, LibrariesMayBeSeveralOrMissing) {
  write("a1.mtl", "newmtl one\nKd 1 0 0\n");
  write("b1.mtl", "newmtl two\nKd 0 1 0\n");
  const ImportedFile file = obj(square("mtllib a1.mtl b1.mtl\nmtllib gone.mtl\nusemtl two\nf 1 2 3\n"));
  EXPECT_EQ(file.materials.at(file.parts.at(0).materialIndex).color, (std::array<float, 3>{0, 1, 0}));
  EXPECT_THAT(file.missing, ElementsAre("gone.mtl"));
}

TEST_F(ObjMesh, MistakesAreNamedWithTheirLine) {
  write("bad.mtl", "newmtl one\nKd red\n");
  write("early.mtl", "Kd 1 1 1\n");
  expectRefusals([&](const std::string& text) { return messageOf([&] { obj(text); }); },
                 {{"garbage\n", "is no statement of an OBJ file"},
                  {"v 0 0\n", "a.obj:1 | has 2 numbers"},
                  {"v 0 0 0\nv 1 0,5 0\n", "a.obj:2 | decimal points"},
                  {"v 0 0 -1.#IND00\n", "'-1.#IND00' is not a number"},
                  {square("f 1 2\n"), "a.obj:5 | a face needs three"},
                  {square("f 1 2 x\n"), "'x' is not a number"},
                  {square("f 1 2 2.5\n"), "not a whole number"},
                  {square("mtllib bad.mtl\n"), "bad.mtl:2 | 'red' is not a number"},
                  {square("mtllib early.mtl\n"), "early.mtl:1 | before the first newmtl"}});
}

}  // namespace
}  // namespace scanmill
