#include "assets/meshes/assimp/reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "assets/meshes/assimp/fbx.h"
#include "assets/meshes/assimp/studio_3ds.h"
#include "tests/core/assets/meshes/triangle_files.h"
#include "tests/core/assets/read_assets.h"

namespace scanmill {
namespace {

using namespace std::string_literals;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string replaced(std::string text, const std::string& mark, const std::string& by) {
  const std::size_t at = text.find(mark);
  EXPECT_NE(at, std::string::npos) << mark;
  return at == std::string::npos ? text : text.replace(at, mark.size(), by);
}

// The triangle of dae() in hundredths, hung by a skin on two joints: corner 0 on `a`, corner 1 on `b`, corner 2 on
// both. In the bind pose the joints are at the origin and at (0, 1, 0).
std::string skinnedDae(const std::string& nodes) {
  std::string text = replaced(dae("Z_UP", "1"), "1 0 0 0 2 0 0 0 3", "100 0 0 0 200 0 0 0 300");
  text = replaced(text, "<library_visual_scenes>", R"(<library_controllers><controller id="c"><skin source="#g">
<bind_shape_matrix>0.01 0 0 0 0 0.01 0 0 0 0 0.01 0 0 0 0 1</bind_shape_matrix>
<source id="j"><Name_array id="ja" count="2">a b</Name_array><technique_common>
<accessor source="#ja" count="2" stride="1"><param name="JOINT" type="name"/></accessor></technique_common></source>
<source id="m"><float_array id="ma" count="32">1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 1 0 0 0 0 1 0 -1 0 0 1 0 0 0 0 1</float_array>
<technique_common><accessor source="#ma" count="2" stride="16"><param name="TRANSFORM" type="float4x4"/></accessor>
</technique_common></source>
<source id="w"><float_array id="wa" count="2">1 0.5</float_array><technique_common>
<accessor source="#wa" count="2" stride="1"><param name="WEIGHT" type="float"/></accessor></technique_common></source>
<joints><input semantic="JOINT" source="#j"/><input semantic="INV_BIND_MATRIX" source="#m"/></joints>
<vertex_weights count="3"><input semantic="JOINT" source="#j" offset="0"/><input semantic="WEIGHT" source="#w" offset="1"/>
<vcount>1 1 2</vcount><v>0 0 1 0 0 1 1 1</v></vertex_weights></skin></controller></library_controllers>
<library_visual_scenes>)");
  const std::size_t first = text.find("<node");
  return text.replace(first, text.rfind("</visual_scene>") - first,
                      nodes + R"(<node id="n" name="body"><translate>7 7 7</translate><instance_controller url="#c">
<skeleton>#A</skeleton></instance_controller></node>)");
}

class Imported : public AssetFiles {
 protected:
  Asset readQuietly(const std::string& name, const std::string& text) {
    testing::internal::CaptureStderr();
    Asset asset = read(name, text);
    warnings_ = testing::internal::GetCapturedStderr();
    return asset;
  }
  std::string warnings_;
};

// COLLADA 1.4.1, 4-7: each vertex is taken by its joints from where the bind shape matrix puts it.
TEST_F(Imported, SkinsOfColladaStandInThePoseOfTheirJoints) {
  const std::string bound =
      R"(<node id="A" name="arm" sid="a" type="JOINT"><node id="B" name="hand" sid="b" type="JOINT">
<translate>0 1 0</translate></node></node>)";
  expectCorners(readQuietly("bound.dae", skinnedDae(bound)), {{1, 0, 0}, {0, 2, 0}, {0, 0, 3}}, "bind pose");
  EXPECT_EQ(warnings_, "");
  const std::string moved = replaced(bound, "0 1 0", "0 1 4");
  expectCorners(read("moved.dae", skinnedDae(moved)), {{1, 0, 0}, {0, 2, 4}, {0, 0, 5}}, "one joint moved");
  const std::string turned = replaced(bound, "<translate>0 1 0", R"(<rotate>0 0 1 90</rotate><translate>1 0 0)");
  expectCorners(read("turned.dae", skinnedDae(turned)), {{1, 0, 0}, {-1, 1, 0}, {0.5f, 0.5f, 3}}, "one joint turned");
}

// Joints are found by their ids, since names may be absent, and several nodes may have the same.
TEST_F(Imported, JointsNeedNoNames) {
  const std::string nodes = R"(<node id="X" name="arm"><translate>50 0 0</translate></node>
<node id="A" name="arm" sid="a" type="JOINT"><node id="B" sid="b" type="JOINT"><translate>0 1 0</translate></node></node>)";
  expectCorners(readQuietly("a.dae", skinnedDae(nodes)), {{1, 0, 0}, {0, 2, 0}, {0, 0, 3}}, "names");
  EXPECT_EQ(warnings_, "");
}

// Without help the importer gives surfaces without a material the first one of the file.
TEST_F(Imported, SurfacesOfColladaWithoutAMaterialHaveNone) {
  const std::string library = R"(<library_effects><effect id="e"><profile_COMMON><technique sid="c"><lambert><diffuse>
<color>0.8 0.2 0.2 1</color></diffuse></lambert></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m" name="Wall"><instance_effect url="#e"/></material></library_materials>
<library_geometries>)";
  const auto materialOf = [&](const std::string& symbol, const std::string& bind) {
    std::string text = replaced(dae("Z_UP", "1"), "<library_geometries>", library);
    text = replaced(text, "<triangles count",
                    symbol.empty() ? "<triangles count" : "<triangles material=\"" + symbol + "\" count");
    if (!bind.empty()) {
      text = replaced(text, "<instance_geometry url=\"#g\"/>",
                      "<instance_geometry url=\"#g\"><bind_material><technique_common>" + bind +
                          "</technique_common></bind_material></instance_geometry>");
    }
    return read("a.dae", text).parts.at(0);
  };
  const std::string bind = R"(<instance_material symbol="S" target="#m"/>)";
  EXPECT_EQ(materialOf("S", bind).material, "Wall");
  EXPECT_NEAR(materialOf("S", bind).color[0], 0.8, 0.2);
  for (const auto& [symbol, bound] : {std::pair{"", ""},
                                      {"S", ""},
                                      {"Other", bind.c_str()},
                                      {"S", R"(<instance_material symbol="S" target="#no"/>)"}}) {
    EXPECT_EQ(materialOf(symbol, bound).material, "") << symbol << bound;
  }
}

TEST_F(Imported, NodesThatAreHiddenInColladaAreLeftOut) {
  std::string text = dae("Z_UP", "1");
  text = replaced(text, "</visual_scene>", R"(<node id="h" name="hidden"><instance_geometry url="#g"/>
<extra><technique profile="FCOLLADA"><visibility>0</visibility></technique></extra>
<node id="below"><instance_geometry url="#g"/></node></node>
<node id="away"><instance_node url="other.dae#n"/></node></visual_scene>)");
  const Asset asset = readQuietly("a.dae", text);
  ASSERT_EQ(asset.parts.size(), 1u);
  EXPECT_EQ(asset.parts[0].node, "wing");
  EXPECT_THAT(warnings_, HasSubstr("a.dae: left out: 2 hidden nodes, 1 references to other files\n"));
  text = std::regex_replace(text, std::regex("<visibility>0"), "<!-- --><visibility>1");
  EXPECT_EQ(read("shown.dae", text).parts.size(), 3u);
}

TEST_F(Imported, GeometryOfColladaThatIsNotReadIsCounted) {
  const std::string lines =
      R"(<lines count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1</p></lines></mesh></geometry>
<geometry id="s"><spline closed="true"/>)";
  readQuietly("a.dae", replaced(dae("Z_UP", "1"), "</mesh>", lines));
  EXPECT_THAT(warnings_, HasSubstr("a.dae: left out: 1 lines, 1 splines\n"));
}

// Hidden nodes need no id, blanks around an axis do not count, and a `lookat` does not shear.
TEST_F(Imported, TextOfColladaIsMendedForTheImporter) {
  std::string text = replaced(dae("\n  Y_UP\n", "1"), "<node id=\"n\" name=\"wing\"><translate>10 20 30</translate>",
                              "<node name=\"wing\"><lookat>0 0 0 0 0 -1 0 3 4</lookat>");
  text = replaced(text, "</visual_scene>", R"(<node><instance_geometry url="#g"/><extra><technique profile="MAYA">
<visibility>0</visibility></technique></extra></node></visual_scene>)");
  const Asset asset = readQuietly("a.dae", text);
  EXPECT_THAT(warnings_, HasSubstr("a.dae: left out: 1 hidden nodes\n"));
  expectCorners(asset, {{1, 0, 0}, {0, 0, 2}, {0, -3, 0}}, "y up, looking to -z: as without it");
  EXPECT_EQ(asset.parts.at(0).node, "wing");
}

TEST_F(Imported, LocalAxesAndUnitsOfColladaAreCounted) {
  const std::string local = "<library_geometries><asset><unit meter=\"0.01\"/><up_axis>Y_UP</up_axis></asset>";
  readQuietly("a.dae", replaced(dae("Z_UP", "1"), "<library_geometries>", local));
  EXPECT_THAT(warnings_, HasSubstr("left out: 2 axes and units of parts of the file (`asset` in libraries)\n"));
  readQuietly("b.dae", replaced(dae("Y_UP", "0.01"), "<library_geometries>", local));
  EXPECT_EQ(warnings_, "");
}

// COLLADA 1.4.1, bind_vertex_input: the set of texture coordinates that an image uses. The mesh has the sets 1 and 2.
TEST_F(Imported, ImagesOfColladaUseTheSetOfTextureCoordinatesThatTheirUseNames) {
  writeColours(folder_.path() / "colours.png");
  const auto source = [](const std::string& id, const std::string& numbers) {
    return "<source id=\"" + id + "\"><float_array id=\"" + id + "a\" count=\"6\">" + numbers +
           "</float_array><technique_common><accessor source=\"#" + id +
           "a\" count=\"3\" stride=\"2\"><param name=\"S\" type=\"float\"/><param name=\"T\" type=\"float\"/>"
           "</accessor></technique_common></source>";
  };
  std::string base =
      replaced(dae("Z_UP", "1"), "<vertices", source("t1", "0 0 2 0 0 2") + source("t2", "0 0 4 0 0 4") + "<vertices");
  base = replaced(base, "<triangles count=\"1\">", "<triangles count=\"1\" material=\"m\">");
  base = replaced(base, "<p>0 1 2", R"(<input semantic="TEXCOORD" source="#t1" offset="0" set="1"/>
<input semantic="TEXCOORD" source="#t2" offset="0" set="2"/><p>0 1 2)");
  base =
      replaced(base, "<library_geometries>", R"(<library_images><image id="i"><init_from>colours.png</init_from></image>
</library_images><library_materials><material id="p" name="p"><instance_effect url="#e"/></material></library_materials>
<library_effects><effect id="e"><profile_COMMON><newparam sid="sf"><surface type="2D"><init_from>i</init_from></surface>
</newparam><newparam sid="sa"><sampler2D><source>sf</source></sampler2D></newparam><technique sid="t"><lambert><diffuse>
<texture texture="sa" texcoord="CHANNEL1"/></diffuse></lambert></technique></profile_COMMON></effect></library_effects>
<library_geometries>)");
  const std::string plain = "<instance_geometry url=\"#g\"/>";
  const auto with = [&](const std::string& set) {
    return R"(<instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="m" target="#p">
<bind_vertex_input semantic="CHANNEL1" input_semantic="TEXCOORD" input_set=")" +
           set + "\"/></instance_material></technique_common></bind_material></instance_geometry>";
  };
  const auto width = [&](const std::string& instances) {
    return readQuietly("a.dae", replaced(base, plain, instances)).parts.at(0).uvs.at(1).x;
  };
  EXPECT_EQ(width(with("1")), 2);
  EXPECT_EQ(width(with("2")), 4);
  EXPECT_EQ(width(with("2") + with("2")), 4);
  EXPECT_EQ(warnings_, "");
  EXPECT_EQ(read("plain.dae", replaced(dae("Z_UP", "1"), plain, with("1"))).parts.size(), 1u) << "no such set";
  EXPECT_EQ(width(with("2") + with("1")), 2);
  EXPECT_THAT(warnings_, HasSubstr("a.dae: left out: 1 images with several sets of texture coordinates "
                                   "(bind_vertex_input; the first is taken)\n"));
}

// The importer refuses all files with morph controllers, even if their weights are 0.
TEST_F(Imported, BaseMeshesOfMorphsOfColladaAreRead) {
  const auto morph = [](const std::string& id, const std::string& source, const std::string& weights) {
    return "<controller id=\"" + id + "\"><morph source=\"" + source + "\" method=\"NORMALIZED\"><source id=\"t" + id +
           "\"><IDREF_array id=\"ta" + id + "\" count=\"2\">g g</IDREF_array></source><source id=\"w" + id +
           "\"><float_array id=\"wa" + id + "\" count=\"2\">" + weights +
           "</float_array></source><targets/></morph></controller>";
  };
  const auto text = [&](const std::string& weights) {
    const std::string skinned = replaced(skinnedDae(R"(<node id="A" sid="a"><node id="B" sid="b">
<translate>0 1 0</translate></node></node><node><instance_controller url="#m2"/></node>)"),
                                         "<skin source=\"#g\">", "<skin source=\"#m1\">");
    return replaced(skinned, "</library_controllers>",
                    morph("m1", "#g", weights) + morph("m2", "#m1", "0 0") + "</library_controllers>");
  };
  const Asset asset = readQuietly("a.dae", text("0 0.5"));
  EXPECT_EQ(asset.parts.size(), 2u);
  EXPECT_THAT(warnings_, HasSubstr("a.dae: left out: 1 morph targets with weights\n"));
  readQuietly("b.dae", text("0 0"));
  EXPECT_EQ(warnings_, "");
}

std::string fbxWith(const std::string& properties) {
  std::string text = replaced(fbx(2, 100), "\"Mesh\" {\n\t}\n",
                              "\"Mesh\" {\n\t\tProperties70:  {\n" + properties +
                                  "\n\t\t}\n\t}\n\tModel: 3, \"Model::below\", \"Mesh\" {\n\t}\n");
  return replaced(text, "Connections:  {\n", "Connections:  {\n\tC: \"OO\",3,2\n\tC: \"OO\",1,3\n");
}

TEST_F(Imported, HiddenObjectsOfFbxAreLeftOut) {
  const auto nodes = [&](const std::string& properties) {
    std::string names;
    for (const AssetPart& part : readQuietly("a.fbx", fbxWith(properties)).parts) names += part.node + " ";
    return names;
  };
  EXPECT_EQ(nodes(""), "wing below ");
  EXPECT_EQ(nodes("P: \"Show\", \"bool\", \"\", \"\",1\nP: \"Visibility\", \"Visibility\", \"\", \"A\",1"),
            "wing below ");
  EXPECT_EQ(nodes("P: \"Show\", \"bool\", \"\", \"\",0"), "below ");
  EXPECT_THAT(warnings_, HasSubstr("a.fbx: left out: 1 hidden nodes\n"));
  EXPECT_THAT(failure(write("b.fbx", fbxWith("P: \"Visibility\", \"Visibility\", \"\", \"A\",0"))),
              HasSubstr("has no triangle"));
}

// fbxWith() with properties of the object below, too, and an object below that, for which `wing` is scaled.
std::string fbxBelow(const std::string& properties, const std::string& lowest = "") {
  const auto object = [](int id, const std::string& more) {
    return "\tModel: " + std::to_string(id) + ", \"Model::below\", \"Mesh\" {\n\t\tProperties70:  {\n" + more +
           "\t\t}\n\t}\n";
  };
  std::string text = replaced(fbxWith("P: \"Lcl Scaling\", \"Lcl Scaling\", \"\", \"A\",2,1,1"),
                              "\tModel: 3, \"Model::below\", \"Mesh\" {\n\t}\n",
                              object(3, properties) + (lowest.empty() ? "" : object(4, lowest)));
  return lowest.empty() ? text : replaced(text, "C: \"OO\",1,3", "C: \"OO\",4,3\n\tC: \"OO\",1,4");
}

constexpr const char* kOtherMaterials =
    "materials of objects with a mesh of another object (they have the materials of that)";

constexpr const char* kTurned = "P: \"Lcl Rotation\", \"Lcl Rotation\", \"\", \"A\",0,0,90\n";

// FBX SDK, InheritType: 0 RrSs (the default), 1 RSrs, 2 Rrs. The object above is scaled by 2 along x.
TEST_F(Imported, ObjectsOfFbxInheritScalesAsTheirTypeSays) {
  const auto type = [](int value) {
    return "P: \"InheritType\", \"enum\", \"\", \"\"," + std::to_string(value) + "\n";
  };
  const auto expect = [&](const std::string& properties, const std::vector<Vec3f>& wanted) {
    Asset asset = readQuietly("a.fbx", fbxBelow(properties));
    asset.parts.erase(asset.parts.begin());
    expectCorners(asset, wanted, properties);
    EXPECT_EQ(warnings_, "");
  };
  const std::vector<Vec3f> before{{0, 2, 0}, {-2, 0, 0}, {0, 0, 3}};
  expect(kTurned, before);
  expect(kTurned + type(0), before);
  expect(kTurned + type(1), {{0, 1, 0}, {-4, 0, 0}, {0, 0, 3}});
  expect(kTurned + type(2), {{0, 1, 0}, {-2, 0, 0}, {0, 0, 3}});
  // Pivots and the geometry's transform remain where they are.
  const std::string moved =
      "P: \"Lcl Translation\", \"Lcl Translation\", \"\", \"A\",5,0,0\n"
      "P: \"GeometricTranslation\", \"Vector3D\", \"Vector\", \"\",0,1,0\n";
  expect(kTurned + type(2) + moved, {{9, 1, 0}, {7, 0, 0}, {9, 0, 3}});
  const std::string oblique = "P: \"Lcl Rotation\", \"Lcl Rotation\", \"\", \"A\",0,0,30\n";
  readQuietly("b.fbx", fbxBelow(oblique + type(1), type(1) + kTurned));
  EXPECT_EQ(warnings_, "");
  readQuietly("b.fbx", fbxBelow(oblique + type(1), type(0) + kTurned));
  EXPECT_THAT(warnings_,
              HasSubstr("left out: 1 scales that objects inherit from sheared or flat parents (InheritType)\n"));
}

TEST_F(Imported, RotationsOfFbxCountIfTheyAreActive) {
  const auto corner = [&](const std::string& more) {
    const std::string lines =
        "P: \"InheritType\", \"enum\", \"\", \"\",2\nP: \"PreRotation\", \"Vector3D\", \"Vector\", \"\",0,0,90\n" +
        (more.empty() ? "" : "P: \"" + more + "\n");
    return readQuietly("a.fbx", fbxBelow(lines)).parts.at(1).positions.at(0);
  };
  EXPECT_NEAR(corner("RotationActive\", \"bool\", \"\", \"\",1").y, 1, 1e-5);
  for (const char* off :
       {"", "RotationActive\", \"bool\", \"\", \"\",0",
        "RotationActive\", \"bool\", \"\", \"\",1\nP: \"RotationSpaceForLimitOnly\", \"bool\", \"\", \"\",1"}) {
    EXPECT_EQ(corner(off).x, 1) << off;
    EXPECT_EQ(warnings_, "");
  }
}

TEST_F(Imported, FinestLevelsOfDetailOfFbxAreRead) {
  std::string text = replaced(fbxWith(""), "\"Model::wing\", \"Mesh\"", "\"Model::wing\", \"LodGroup\"");
  text = replaced(text, "\tModel: 3", "\tModel: 4, \"Model::coarse\", \"Mesh\" {\n\t}\n\tModel: 3");
  text = replaced(text, "\tC: \"OO\",1,3\n", "\tC: \"OO\",1,3\n\tC: \"OO\", 4, 2\n\tC: \"OO\",1,4\n");
  const Asset asset = readQuietly("a.fbx", text);
  EXPECT_THAT(warnings_, HasSubstr("a.fbx: left out: 1 coarser levels of detail (LodGroup)\n"));
  EXPECT_EQ(asset.parts.size(), 2u) << "the group's own mesh, and the first below it";
  EXPECT_EQ(asset.parts.at(1).node, "below");
}

TEST_F(Imported, CurvedSurfacesOfFbxAreCounted) {
  std::string geometries;
  for (const char* kind : {"Patch", "TrimNurbsSurface", "Boundary", "NurbsSurface", "NurbsCurve"}) {
    geometries += "\tGeometry: 9" + std::to_string(geometries.size()) + ", \"Geometry::\", \"" + kind + "\" {\n\t}\n";
  }
  readQuietly("a.fbx", replaced(fbx(2, 100), "\tModel: 2", geometries + "\tModel: 2"));
  EXPECT_THAT(warnings_, HasSubstr("left out: 1 borders of curved surfaces (Boundary), 2 curved surfaces (NURBS), "
                                   "1 curved surfaces (Patch)\n"));
}

// Blender converts the text of fbxWith() to a binary file; here its records are written by hand.
std::string fbxRecord(const std::string& name, const std::vector<std::string>& properties, std::size_t at,
                      const std::vector<std::function<std::string(std::size_t)>>& children = {}) {
  std::string list;
  for (const std::string& property : properties) list += property;
  std::string nested;
  const std::size_t inside = at + 13 + name.size() + list.size();
  for (const auto& child : children) nested += child(inside + nested.size());
  if (!children.empty()) nested += std::string(13, '\0');
  const auto word = [](std::size_t value) { return bytesOf<std::uint32_t>({static_cast<std::uint32_t>(value)}); };
  return word(inside + nested.size()) + word(properties.size()) + word(list.size()) + static_cast<char>(name.size()) +
         name + list + nested;
}

TEST_F(Imported, HiddenObjectsOfBinaryFbxAreLeftOut) {
  using namespace std::string_literals;
  const auto text = [](const std::string& value) {
    return "S" + bytesOf<std::uint32_t>({static_cast<std::uint32_t>(value.size())}) + value;
  };
  const auto number = [](std::int64_t value) { return "L" + bytesOf<std::int64_t>({value}); };
  const auto real = [](double value) { return "D" + bytesOf<double>({value}); };
  const auto record = [](const std::string& name, const std::vector<std::string>& properties,
                         const std::vector<std::function<std::string(std::size_t)>>& children = {}) {
    return [=](std::size_t at) { return fbxRecord(name, properties, at, children); };
  };
  const auto file = [&](double visibility) {
    const auto reals = "d" + bytesOf<std::uint32_t>({9, 0, 72}) + bytesOf<double>({1, 0, 0, 0, 2, 0, 0, 0, 3});
    const auto corners = "i" + bytesOf<std::uint32_t>({3, 0, 12}) + bytesOf<std::int32_t>({0, 1, -3});
    const auto model = [&](int id, const std::string& name, double value) {
      return record(
          "Model", {number(id), text(name + "\0\1Model"s), text("Mesh")},
          {record("Properties70", {},
                  {record("P", {text("Visibility"), text("Visibility"), text(""), text("A"), real(value)})})});
    };
    std::string bytes = "Kaydara FBX Binary  \0\x1A\0"s + bytesOf<std::uint32_t>({7400});
    for (const auto& top :
         {record("FBXHeaderExtension", {}, {record("FBXVersion", {"I" + bytesOf<std::int32_t>({7400})})}),
          record("Objects", {},
                 {record("Geometry", {number(1), text("tri\0\1Geometry"s), text("Mesh")},
                         {record("Vertices", {reals}), record("PolygonVertexIndex", {corners})}),
                  model(2, "wing", visibility), model(3, "other", 1)}),
          record("Connections", {},
                 {record("C", {text("OO"), number(2), number(0)}), record("C", {text("OO"), number(3), number(0)}),
                  record("C", {text("OO"), number(1), number(2)}), record("C", {text("OO"), number(1), number(3)})})}) {
      bytes += top(bytes.size());
    }
    return bytes + std::string(13, '\0');
  };
  EXPECT_EQ(readQuietly("shown.fbx", file(1)).parts.size(), 2u);
  EXPECT_EQ(warnings_, "");
  const Asset asset = readQuietly("hidden.fbx", file(0));
  ASSERT_EQ(asset.parts.size(), 1u);
  EXPECT_EQ(asset.parts[0].node, "other");
  EXPECT_THAT(warnings_, HasSubstr("hidden.fbx: left out: 1 hidden nodes\n"));
}

TEST_F(Imported, MorphTargetsAndAnimationsOfFbxAreCounted) {
  std::string text = replaced(fbx(2, 100), "\tModel: 2", R"(	Geometry: 11, "Geometry::shape", "Shape" {
		Indexes: *1 {
			a: 0
		}
		Vertices: *3 {
			a: 5,0,0
		}
		Normals: *3 {
			a: 0,0,0
		}
	}
	Deformer: 12, "Deformer::bs", "BlendShape" {
	}
	Deformer: 13, "SubDeformer::ch", "BlendShapeChannel" {
		DeformPercent: 50
	}
	AnimationStack: 14, "AnimStack::Take 001", "" {
	}
	AnimationCurve: 15, "AnimCurve::", "" {
	}
	Model: 2)");
  text =
      replaced(text, "Connections:  {\n", "Connections:  {\n\tC: \"OO\",12,1\n\tC: \"OO\",13,12\n\tC: \"OO\",11,13\n");
  expectCorners(readQuietly("a.fbx", text), {{1, 0, 0}, {0, 2, 0}, {0, 0, 3}}, "at rest");
  EXPECT_THAT(warnings_,
              HasSubstr("left out: 1 animations (the file's pose is taken), 1 morph targets with weights\n"));
  readQuietly("b.fbx", replaced(replaced(text, "Percent: 50", "Percent: 0"), "\"AnimCurve::", "\"Other::"));
  EXPECT_EQ(warnings_, "");
}

// FBX: the three axes with their signs are the right, the up and the front of the file's author.
TEST_F(Imported, AxesOfFbxAreApplied) {
  const auto with = [](int up, int upSign, int front, int frontSign, int right, int rightSign) {
    std::string lines;
    for (const auto& [name, value] : {std::pair("UpAxisSign", upSign),
                                      {"FrontAxis", front},
                                      {"FrontAxisSign", frontSign},
                                      {"CoordAxis", right},
                                      {"CoordAxisSign", rightSign}}) {
      lines += "\t\tP: \"" + std::string(name) + "\", \"int\", \"Integer\", \"\"," + std::to_string(value) + "\n";
    }
    return replaced(fbx(up, 100), "\t\tP: \"UnitScaleFactor", lines + "\t\tP: \"UnitScaleFactor");
  };
  const auto expect = [&](const std::string& text, const std::vector<Vec3f>& wanted, const std::string& what) {
    expectCorners(readQuietly("a.fbx", text), wanted, what);
    EXPECT_EQ(warnings_, "") << what;
  };
  expect(with(2, 1, 1, -1, 0, 1), {{1, 0, 0}, {0, 2, 0}, {0, 0, 3}}, "3ds Max");
  expect(with(1, 1, 2, 1, 0, 1), {{1, 0, 0}, {0, 0, 2}, {0, -3, 0}}, "Maya");
  expect(with(2, 1, 1, 1, 0, -1), {{-1, 0, 0}, {0, -2, 0}, {0, 0, 3}}, "from behind");
  expect(with(2, -1, 1, 1, 0, 1), {{1, 0, 0}, {0, -2, 0}, {0, 0, -3}}, "upside down");
  expect(with(2, 1, 1, 1, 0, 1), {{1, 0, 0}, {0, 0, 3}, {0, -2, 0}}, "left-handed: the corners turn the other way");
  expectCorners(readQuietly("a.fbx", with(1, -1, 1, 1, 0, 1)), {{1, 0, 0}, {0, 0, 2}, {0, -3, 0}}, "no frame");
  EXPECT_THAT(warnings_, HasSubstr("left out: 1 negative signs of the up axis (UpAxisSign)\n"));
  EXPECT_EQ(corners(read("a.fbx", with(2, 1, 1, 1, 0, -1), {.up = 'z'}))[0].x, 1) << "the key `up` prevails";
}

// fbx() with a material, and with an image that the material uses if `use` is not empty.
std::string fbxWithMaterial(const std::string& use, const std::string& properties = "") {
  std::string text = replaced(fbx(2, 100), "\tModel: 2", R"(	Material: 3, "Material::paint", "" {
	}
	Texture: 4, "Texture::t", "" {
		TextureName: "Texture::t"
		Properties70:  {
)" + properties + R"(
		}
		RelativeFilename: "colours.png"
	}
	Model: 2)");
  text = replaced(text, "\t\tPolygonVertexIndex", R"(		LayerElementUV: 0 {
			Name: "UV"
			MappingInformationType: "ByPolygonVertex"
			ReferenceInformationType: "Direct"
			UV: *6 {
				a: 0,0,2,0,0,2
			}
		}
		LayerElementMaterial: 0 {
			MappingInformationType: "AllSame"
			ReferenceInformationType: "IndexToDirect"
			Materials: *1 {
				a: 0
			}
		}
		Layer: 0 {
			LayerElement: {
				Type: "LayerElementUV"
				TypedIndex: 0
			}
			LayerElement: {
				Type: "LayerElementMaterial"
				TypedIndex: 0
			}
		}
		PolygonVertexIndex)");
  if (!use.empty()) text = replaced(text, "Connections:  {\n", "Connections:  {\n\tC: \"OP\",4,3, \"" + use + "\"\n");
  return replaced(text, "Connections:  {\n", "Connections:  {\n\tC: \"OO\",3,2\n");
}

TEST_F(Imported, UsesOfImagesOfFbxThatAreNotReadAreCounted) {
  writeColours(folder_.path() / "colours.png");
  const auto told = [&](const std::string& text) {
    const AssetPart part = readQuietly("a.fbx", text).parts.at(0);
    EXPECT_EQ(part.uvs.at(1).x, 2) << text;
    return warnings_;
  };
  const auto number = [](const std::string& name, const std::string& type, const std::string& value) {
    return "\t\t\tP: \"" + name + "\", \"" + type + "\", \"\", \"\"," + value;
  };
  EXPECT_EQ(told(fbxWithMaterial("DiffuseColor", number("WrapModeU", "enum", "0"))), "");
  EXPECT_THAT(told(fbxWithMaterial("DiffuseColor", number("WrapModeU", "enum", "1"))),
              HasSubstr("a.fbx: left out: 1 clamped or mirrored textures (they repeat)\n"));
  EXPECT_THAT(told(fbxWithMaterial("DiffuseColor", number("Rotation", "Vector", "0,0,90"))),
              HasSubstr("a.fbx: left out: 1 rotations of images (Rotation)\n"));
  EXPECT_THAT(told(fbxWithMaterial("DiffuseColor", number("UVSwap", "bool", "1"))),
              HasSubstr("a.fbx: left out: 1 images with swapped texture coordinates (UVSwap)\n"));
  EXPECT_THAT(told(fbxWithMaterial("DiffuseFactor")), HasSubstr("a.fbx: left out: 1 images of DiffuseFactor\n"));
}

TEST_F(Imported, BinaryFbxIsSearchedAsTextIs) {
  using namespace std::string_literals;
  const auto text = [](const std::string& value) {
    return "S" + bytesOf<std::uint32_t>({static_cast<std::uint32_t>(value.size())}) + value;
  };
  const auto number = [&](const std::string& name, std::int32_t value) {
    return text(name) + text("int") + text("") + text("") + "I" + bytesOf<std::int32_t>({value});
  };
  const auto id = [](std::int64_t value) { return "L" + bytesOf<std::int64_t>({value}); };
  const auto image = [&](int which, std::int32_t wrap) {
    return "\7Texture" + id(which) + text("t\0\1Texture"s) + number("UVSwap", wrap) + number("WrapModeV", wrap) +
           text("UVSet") + text("KString") + text("") + text("") + text("set" + std::to_string(which)) +
           "RelativeFilename" + text(std::to_string(which) + ".png");
  };
  const std::filesystem::path file =
      write("a.fbx", "Kaydara FBX Binary  " + image(7, 0) + image(8, 1) + "C" + text("OP") + id(8) + id(9) +
                         text("DiffuseFactor") + text("OP") + id(5) + id(9) + text("DiffuseFactor"));
  LeftOut leftOut;
  FbxImages images;
  readFbx(file, leftOut, images);
  EXPECT_EQ(images.clamped, (std::set<std::string>{"8.png"}));
  EXPECT_EQ(images.uvSets, (std::map<std::string, std::string>{{"7.png", "set7"}, {"8.png", "set8"}}));
  EXPECT_EQ(leftOut.text(), "1 images of DiffuseFactor, 1 images with swapped texture coordinates (UVSwap)");
  const auto model = [&](int which, const std::string& kind, std::int32_t active) {
    return "\5Model" + id(which) + text("m\0\1Model"s) + text(kind) + number("RotationActive", active) +
           text("PreRotation") + text("Vector3D") + text("Vector") + text("");
  };
  const std::string levels =
      "Kaydara FBX Binary  " + model(1, "LodGroup", 1) + model(2, "Mesh", 0) + model(3, "Mesh", 1);
  const auto links = [&](const std::string& last) { return text("OO") + id(2) + id(1) + text(last) + id(3) + id(1); };
  const std::string changed = readFbx(write("b.fbx", levels + links("OO")), leftOut, images);
  EXPECT_EQ(leftOut.counts().at("coarser levels of detail (LodGroup)"), 1u);
  std::string wanted = levels + links("PP");
  wanted[wanted.find("PreRotation", wanted.find("Mesh"))] = '_';
  EXPECT_EQ(changed, wanted);
  const std::string shared = "Kaydara FBX Binary  \x08Geometry" + id(4) + text("g\0\1Geometry"s) + text("Mesh") +
                             "\x08Material" + id(5) + text("m\0\1Material"s) + text("") + model(1, "Mesh", 1) +
                             model(2, "Mesh", 1) + text("OO") + id(4) + id(1) + text("OO") + id(4) + id(2) +
                             text("OO") + id(5) + id(2);
  readFbx(write("c.fbx", shared), leftOut, images);
  EXPECT_EQ(leftOut.counts().at(kOtherMaterials), 1u);
}

// The importer reads a mesh once, with the materials of the first object.
TEST_F(Imported, ObjectsOfFbxWithTheMeshOfAnotherAndOtherMaterialsAreCounted) {
  const auto file = [](const std::string& connections) {
    const std::string text = replaced(fbxWithMaterial(""), "\tModel: 2",
                                      "\tMaterial: 5, \"Material::rust\", \"\" {\n\t}\n"
                                      "\tModel: 6, \"Model::other\", \"Mesh\" {\n\t}\n\tModel: 2");
    return replaced(text, "\tC: \"OO\",1,2\n", "\tC: \"OO\",6,0\n\tC: \"OO\",1,2\n\tC: \"OO\",1,6\n" + connections);
  };
  EXPECT_EQ(readQuietly("a.fbx", file("\tC: \"OO\",3,6\n")).parts.size(), 2u);
  EXPECT_EQ(warnings_, "");
  readQuietly("a.fbx", file("\tC: \"OO\",5,6\n"));
  EXPECT_THAT(warnings_, HasSubstr("a.fbx: left out: 1 "s + kOtherMaterials + "\n"));
}

// FBX SDK, FbxTexture::UVSet: the name of the set of texture coordinates that an image uses, in every mesh.
TEST_F(Imported, ImagesOfFbxUseTheSetOfTextureCoordinatesThatTheyName) {
  writeColours(folder_.path() / "colours.png");
  const auto file = [](const std::string& set, const std::string& second) {
    // The mesh of the first object has the sets UV and B, that of the second has B or `second`, and UV.
    const std::string uvSet = "\t\t\tP: \"UVSet\", \"KString\", \"\", \"\", \"" + set + "\"";
    std::string text = fbxWithMaterial("DiffuseColor", uvSet);
    const std::size_t at = text.find("\t\tLayerElementUV"), end = text.find("\t\tLayerElementMaterial");
    std::string other = replaced(text.substr(at, end - at), "UV: 0", "UV: 1");
    other = replaced(replaced(other, "0,0,2,0,0,2", "0,0,4,0,0,4"), "\"UV\"", "\"B\"");
    text.insert(end, other);
    text = replaced(text, "\t\tPolygonVertexIndex",
                    "\t\tLayer: 1 {\n\t\t\tLayerElement: {\n\t\t\t\tType: \"LayerElementUV\"\n\t\t\t\tTypedIndex: 1\n"
                    "\t\t\t}\n\t\t}\n\t\tPolygonVertexIndex");
    const std::size_t geometry = text.find("\tGeometry: 1"), next = text.find("\tMaterial: 3");
    std::string copy = replaced(text.substr(geometry, next - geometry), "Geometry: 1", "Geometry: 8");
    copy = replaced(replaced(copy, "\"B\"", "\"UV\""), "\"UV\"", "\"" + second + "\"");
    text.insert(next, copy + "\tModel: 9, \"Model::other\", \"Mesh\" {\n\t}\n");
    return replaced(text, "Connections:  {\n", "Connections:  {\n\tC: \"OO\",9,0\n\tC: \"OO\",8,9\n\tC: \"OO\",3,9\n");
  };
  const auto widths = [&](const std::string& set, const std::string& second) {
    std::vector<std::pair<std::string, float>> found;
    for (const AssetPart& part : readQuietly("a.fbx", file(set, second)).parts) {
      found.emplace_back(part.node, part.uvs.at(1).x);
    }
    return found;
  };
  using testing::Pair;
  using testing::UnorderedElementsAre;
  EXPECT_THAT(widths("UV", "B"), UnorderedElementsAre(Pair("wing", 2), Pair("other", 4)));
  EXPECT_THAT(widths("B", "B"), UnorderedElementsAre(Pair("wing", 4), Pair("other", 2)));
  EXPECT_EQ(warnings_, "");
  EXPECT_THAT(widths("B", "C"), UnorderedElementsAre(Pair("wing", 4), Pair("other", 2)));
  EXPECT_THAT(warnings_,
              HasSubstr("left out: 1 sets of texture coordinates that meshes lack (UVSet; their first is taken)\n"));
}

TEST_F(Imported, MaterialsOfFbxWithoutAColourHaveNone) {
  const AssetPart part = read("a.fbx", fbxWithMaterial("")).parts.at(0);
  EXPECT_EQ(part.material, "paint");
  EXPECT_EQ(part.fileMaterial.reflectance, Material().reflectance);
}

TEST_F(Imported, ElementsOfColladaThatTheImporterCannotReadAreRefused) {
  const std::string text = dae("Z_UP", "1");
  EXPECT_THAT(failure(write("a.dae", replaced(text, "<translate>", "<skew>45 0 1 0 1 0 0</skew><translate>"))),
              AllOf(HasSubstr("a.dae: has <skew> in line 12"), HasSubstr("bake"), HasSubstr("glTF")));
  const std::string sampler = "<!--\n<skew>--><sampler2D><instance_image url=\"#i\"/></sampler2D>";
  EXPECT_THAT(failure(write("b.dae", replaced(text, "<library_geometries>", sampler + "<library_geometries>"))),
              AllOf(HasSubstr("b.dae: has <instance_image> in line 5"), HasSubstr("COLLADA 1.4.1")));
}

std::string chunk3ds(std::uint16_t type, const std::string& data) {
  return bytesOf<std::uint16_t>({type}) + bytesOf<std::uint32_t>({static_cast<std::uint32_t>(6 + data.size())}) + data;
}

// The triangle twice: the objects "wing" and "other", of which the latter has the chunk OBJ_HIDDEN.
std::string studio3ds(const std::string& scale, const std::string& hidden) {
  using namespace std::string_literals;
  const std::string mesh = chunk3ds(0x4100, chunk3ds(0x4110, "\3\0"s + bytesOf<float>({1, 0, 0, 0, 2, 0, 0, 0, 3})) +
                                                chunk3ds(0x4120, bytesOf<std::uint16_t>({1, 0, 1, 2, 7})));
  return chunk3ds(0x4D4D, chunk3ds(0x3D3D, chunk3ds(0x3D3E, "\3\0\0\0"s) + scale + chunk3ds(0x4000, "wing\0"s + mesh) +
                                               chunk3ds(0x4000, "other\0"s + hidden + mesh)));
}

TEST_F(Imported, HiddenObjectsAndMasterScalesOf3dsAreTold) {
  EXPECT_EQ(readQuietly("a.3ds", studio3ds("", "")).parts.size(), 2u);
  EXPECT_EQ(warnings_, "");
  const std::string scale = chunk3ds(0x0100, bytesOf<float>({0.5f}));
  expectCorners(readQuietly("a.3ds", studio3ds(scale, chunk3ds(0x4010, ""))), {{2, 0, 0}, {0, 4, 0}, {0, 0, 6}}, "3ds");
  EXPECT_THAT(warnings_,
              HasSubstr("a.3ds: left out: 1 hidden nodes, 1 master scales of 0.5 (lengths are divided by it: "
                        "check the size)\n"));
}

// The keyframer places objects. The importer leaves out those that it does not name, and has no names without it.
TEST_F(Imported, ObjectsThatTheKeyframerOf3dsLeavesOutStandWhereTheirVerticesAre) {
  using namespace std::string_literals;
  const auto nodes = [](const Asset& asset) {
    std::string names;
    for (const AssetPart& part : asset.parts) names += part.node + " ";
    return names;
  };
  std::string text = studio3ds("", "");
  EXPECT_EQ(nodes(readQuietly("a.3ds", text)), "wing other ");
  // A matrix of the local axes, by whose inverse the importer moves vertices into the frame of a node.
  const std::string matrix = chunk3ds(0x4160, bytesOf<float>({0, 1, 0, -1, 0, 0, 0, 0, 1, 5, 6, 7}));
  const std::string faces = chunk3ds(0x4120, bytesOf<std::uint16_t>({1, 0, 1, 2, 7}));
  const std::string plain =
      chunk3ds(0x4100, chunk3ds(0x4110, "\3\0"s + bytesOf<float>({1, 0, 0, 0, 2, 0, 0, 0, 3})) + matrix + faces);
  const std::string position =
      chunk3ds(0xB020, std::string(10, '\0') + bytesOf<std::uint32_t>({1, 0}) + "\0\0"s + bytesOf<float>({0, 0, 9}));
  text =
      chunk3ds(0x4D4D, chunk3ds(0x3D3D, chunk3ds(0x3D3E, "\3\0\0\0"s) + chunk3ds(0x4000, "other\0"s + plain) +
                                            chunk3ds(0x4000, "wing\0"s + plain)) +
                           chunk3ds(0xB000, chunk3ds(0xB002, chunk3ds(0xB010, "wing\0\0\0\0\0\xFF\xFF"s) + position)));
  const Asset asset = readQuietly("b.3ds", text);
  EXPECT_EQ(warnings_, "");
  ASSERT_EQ(nodes(asset), "wing other ");
  EXPECT_EQ(asset.parts[0].positions.at(0).z, 2) << "the keyframer's place";
  EXPECT_THAT(asset.parts[1].positions, testing::ElementsAre(Vec3f{1, 0, 0}, Vec3f{0, 2, 0}, Vec3f{0, 0, 3}));
}

TEST_F(Imported, AlphaOfColoursOfXFilesIsTold) {
  const auto file = [](const std::string& alpha) {
    return "xof 0303txt 0032\nMesh {\n3; 1;0;0;, 0;2;0;, 0;0;3;;\n1; 3;0,1,2;;\nMeshMaterialList { 1; 1; 0;;\n"
           "Material { 0.5;0.5;0.5;" +
           alpha + ";; 1.0; 0;0;0;; 0;0;0;; } }\n}\n";
  };
  readQuietly("a.x", file("1.0"));
  EXPECT_EQ(warnings_, "");
  readQuietly("a.x", file("0.3"));
  EXPECT_THAT(warnings_, HasSubstr("a.x: left out: 1 opacities of materials (they are solid)\n"));
}

TEST_F(Imported, UnitsThatFilesStateAreReported) {
  EXPECT_EQ(read("a.dae", dae("Z_UP", "0.0254")).statedUnit, 0.0254);
  EXPECT_NEAR(read("a.fbx", fbx(2, 100)).statedUnit, 1, 1e-6);
  EXPECT_EQ(read("a.stl", kStl).statedUnit, 0);
}

TEST_F(Imported, ErrorsThatTheImporterReadsPastAreTold) {
  readQuietly("a.ac", replaced(kAc, "rgb 0.5", "rgx 0.5"));
  EXPECT_THAT(warnings_,
              AllOf(HasSubstr("a.ac: may be incomplete, since the importer reports: "), HasSubstr("rgb was expected")));
}

TEST_F(Imported, LinesAreCounted) {
  readQuietly("a.x", "xof 0303txt 0032\nMesh {\n3; 1;0;0;, 0;2;0;, 0;0;3;;\n2; 3;0,1,2;, 2;0,1;;\n}\n");
  EXPECT_THAT(warnings_, HasSubstr("a.x: left out: 1 lines\n"));
}

}  // namespace
}  // namespace scanmill
