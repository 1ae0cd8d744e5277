#include <fmt/format.h>

#include <regex>
#include <string>
#include <tuple>
#include <utility>

#include "tests/core/assets/meshes/triangle_files.h"
#include "tests/core/assets/read_assets.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

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

// Hidden nodes need no id, and blanks around an axis do not count.
TEST_F(Imported, TextOfColladaIsMendedForTheImporter) {
  std::string text = replaced(dae("\n  Y_UP\n", "1"), "<node id=\"n\"", "<node");
  text = replaced(text, "</visual_scene>", R"(<node><instance_geometry url="#g"/><extra><technique profile="MAYA">
<visibility>0</visibility></technique></extra></node></visual_scene>)");
  const Asset asset = readQuietly("a.dae", text);
  EXPECT_THAT(warnings_, HasSubstr("a.dae: left out: 1 hidden nodes\n"));
  expectCorners(asset, {{11, -30, 20}, {10, -30, 22}, {10, -33, 20}}, "y up");
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

// Elements that the importer reads wrong, or not at all, are refused.
TEST_F(Imported, ElementsOfColladaThatTheImporterCannotReadAreRefused) {
  const std::string text = dae("Z_UP", "1");
  const std::string turned = "<translate>10 20 30</translate>";
  const std::string library = "<library_geometries>";
  const std::string skin =
      "<library_controllers><controller><skin/></controller></library_controllers><library_nodes>"
      "<node><instance_controller/></node></library_nodes>";
  for (const auto& [mark, added, element, line, advice] :
       {std::tuple<std::string, std::string, const char*, int, const char*>{turned, "<skew>45 0 1 0 1 0 0</skew>",
                                                                            "skew", 12, "bake"},
        {turned, "<lookat>0 0 0 0 0 -1 0 3 4</lookat>", "lookat", 12, "bake"},
        {library, skin, "skin", 4, "Blender"},
        {library, "<!--\n<skew>--><sampler2D><instance_image url=\"#i\"/></sampler2D>", "instance_image", 5,
         "COLLADA 1.4.1"}}) {
    EXPECT_THAT(failure(write("a.dae", replaced(text, mark, added + mark))),
                AllOf(HasSubstr(fmt::format("a.dae: has <{}> in line {}, which cannot be read", element, line)),
                      HasSubstr(advice), HasSubstr("glTF")));
  }
  EXPECT_EQ(
      read("a.dae", replaced(text, "<node id", "<node id=\"eye\"><lookat>0 0 0 0 0 -1 0 1 0</lookat></node><node id"))
          .parts.size(),
      1u);
}

class Ac3d : public Imported {
 protected:
  // kAc with other lines in place of its texture.
  static std::string with(const std::string& lines) { return replaced(kAc, "texture \"colours.png\"\n", lines); }
  // kAc with objects in place of its only one.
  static std::string with(int kids, const std::string& objects) {
    std::string text = kAc;
    text.resize(text.find("OBJECT poly"));
    return replaced(text, "kids 1", "kids " + std::to_string(kids)) + objects;
  }
  const std::string object_ = std::string(kAc).substr(std::string(kAc).find("OBJECT poly"));
};

TEST_F(Ac3d, TheBaseLayerIsTheTexture) {
  for (const char* const lines :
       {"texture \"colours.png\"\n", "texture \"colours.png\" base\n",
        "texture \"colours.png\" base\ntexture empty_texture_no_mapping tiled\ntexture \"skids.png\" skids\n",
        "texture \"shade.png\" shad\ntexture \"colours.png\" base\ntexture \"shade.png\" tiled\n",
        "texture \"colours.png\" base\r\ntexture empty_texture_no_mapping shad\r\n",
        "texture empty_texture_no_mapping tiled\ntexture \"colours.png\"\ntexture \"other.png\"\n"}) {
    EXPECT_EQ(read("a.acc", with(lines)).parts.at(0).texture, "colours.png") << lines;
  }
  EXPECT_EQ(read("a.ac", with("texture empty_texture_no_mapping base\n")).parts.at(0).texture, "");
}

// A point p of an object stands at rot * p + loc in the frame of the object above.
TEST_F(Ac3d, TransformsHoldForSurfacesAndForKids) {
  const std::string moved = replaced(object_, "numvert", "rot 0 1 0 -1 0 0 0 0 1\nloc 10 20 30\nnumvert");
  const Asset asset = read("moved.ac", with(2, replaced(moved, "kids 0", "kids 1") + moved + object_), {.up = 'z'});
  ASSERT_EQ(asset.parts.size(), 3u);
  const auto corners = [](std::initializer_list<Vec3f> at) { return testing::ElementsAreArray(at); };
  EXPECT_THAT(asset.parts[0].positions, corners({{10, 19, 30}, {12, 20, 30}, {10, 20, 33}}));
  EXPECT_THAT(asset.parts[1].positions, corners({{29, 10, 60}, {30, 8, 60}, {30, 10, 63}})) << "below the first";
  EXPECT_THAT(asset.parts[2].positions, corners({{1, 0, 0}, {0, 2, 0}, {0, 0, 3}})) << "beside the first";
}

TEST_F(Ac3d, WhatIsHiddenOrMissingIsTold) {
  for (const auto& [text, told] :
       {std::pair{replaced(replaced(kAc, "numvert 3", "numvert 4"), "numsurf 1", "numsurf 3"),
                  "left out: 2 surfaces that 'numsurf' counts and the file lacks"},
        {with(3, object_), "left out: 2 objects that 'kids' counts and the file lacks"},
        {replaced(kAc, "numvert", "hidden\nnumvert"), "left out: 1 marks of hidden objects (they are shown)"},
        {replaced(kAc, "rgb 0.5", "rgx 0.5"), "may be incomplete, since the importer reports: "}}) {
    readQuietly("a.ac", text);
    EXPECT_THAT(warnings_, HasSubstr(std::string("a.ac: ") + told));
  }
  EXPECT_THAT(failure(write("a.ac", replaced(kAc, "MATERIAL \"paint\" rgb", "MAT \"paint\"\nrgb"))),
              HasSubstr("a.ac: has a material of several lines"));
}

TEST_F(Ac3d, ImagesRepeatAndShift) {
  writeColours(folder_.path() / "colours.png");
  const Asset asset = read("a.ac", with("texture \"colours.png\"\ntexrep 2 4\ntexoff 0.25 0.125\n"));
  const Vec2f uv = asset.parts.at(0).uvs.at(1);  // (0.75, 0.25) in the file
  EXPECT_EQ(uv.x, 1.75f);
  EXPECT_EQ(uv.y, 1.125f);
}

}  // namespace
}  // namespace scanmill
