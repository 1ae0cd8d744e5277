#include "assets/meshes/assimp/reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <regex>
#include <string>
#include <vector>

#include "tests/core/assets/meshes/triangle_files.h"
#include "tests/core/assets/read_assets.h"

namespace scanmill {
namespace {

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

TEST_F(Imported, UnitsThatFilesStateAreReported) {
  EXPECT_EQ(read("a.dae", dae("Z_UP", "0.0254")).statedUnit, 0.0254);
  EXPECT_NEAR(read("a.fbx", fbx(2, 100)).statedUnit, 1, 1e-6);
  EXPECT_EQ(read("a.stl", kStl).statedUnit, 0);
}

// Header: three vertices, but two follow, and two faces, of which one follows.
TEST_F(Imported, ErrorsThatTheImporterReadsPastAreTold) {
  readQuietly("a.off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  EXPECT_THAT(warnings_, AllOf(HasSubstr("a.off: may be incomplete, since the importer reports: "),
                               HasSubstr("number of faces in the header is incorrect")));
}

TEST_F(Imported, LinesPointsAndColoursAreCounted) {
  readQuietly("a.off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n2 0 1\n");
  EXPECT_THAT(warnings_, HasSubstr("a.off: left out: 1 lines\n"));
  readQuietly("a.ply",
              "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
              "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n"
              "property list uchar int vertex_indices\nend_header\n1 0 0 9 9 9\n0 2 0 9 9 9\n0 0 3 9 9 9\n3 0 1 2\n");
  EXPECT_THAT(warnings_, HasSubstr("a.ply: left out: 3 colours of vertices\n"));
}

}  // namespace
}  // namespace scanmill
