// Assets that are damaged, absurd or not what they say.

#include <fmt/format.h>
#include <sys/stat.h>

#include <cstdint>
#include <cstring>
#include <string>

#include "assets/meshes/references.h"
#include "base/error.h"
#include "tests/core/assets/meshes/triangle_files.h"
#include "tests/core/assets/read_assets.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST_F(AssetFiles, IndicesOutOfRangeAreDroppedAndCounted) {
  Gltf gltf;
  gltf.buffer = R"("uri":"a.bin")";
  gltf.nodes = R"([{"name":"wing","mesh":0}])";
  write("a.bin", gltfBuffer({0, 1, 4000000000u}));
  EXPECT_THAT(failure(write("a.gltf", gltf.text())), HasSubstr("a.gltf"));

  std::string ply = kPly;
  ply.replace(ply.find("element face 1"), 14, "element face 3");
  const Asset asset = read("a.ply", ply + "3 0 1 77\n4 0 1 2 9\n");
  EXPECT_EQ(asset.parts.at(0).triangles.size(), 1u);
  EXPECT_EQ(asset.dropped.outOfRange, 3u);
}

TEST_F(AssetFiles, BadRequestsAreNamed) {
  EXPECT_THAT(failure(folder_.path() / "absent.obj"), HasSubstr("absent.obj: the file does not exist"));
  EXPECT_THAT(failure(folder_.path()), HasSubstr("is not a file"));
  EXPECT_THAT(failure(write("empty.ply", "")), HasSubstr("empty.ply: is empty"));
  expectRefusals([&](const std::string& name) { return failure(write(name, "v 0 0 0\nv 1 0 0\np 1 2\n")); },
                 {{"a.docx", "unknown kind"},
                  {"a.opl", "town: {map: ...}"},
                  {"a.osm.pbf", "town: {map: ...}"},
                  {"a.dxf", "unknown kind ('.dxf') | Blender"},
                  {"a.bil", "rasters to TIF"},
                  {"noname", "unknown kind"},
                  {"points.obj", "points.obj"},
                  {"a.ac", "a.ac"},
                  {"a.dae", "or convert it to glTF"}});
}

TEST_F(AssetFiles, GltfIsCheckedBeforeItIsRead) {
  write("short.bin", gltfBuffer().substr(0, 71));
  const auto buffer = [](const char* uri) {
    Gltf gltf;
    gltf.buffer = fmt::format(R"("uri":"{}")", uri);
    return gltf.text();
  };
  const auto nodes = [](const char* json) {
    Gltf gltf;
    gltf.nodes = json;
    return gltf.text();
  };
  std::string beyond = Gltf().text();
  beyond.replace(beyond.find(R"("count":3)"), 9, R"("count":4)");
  expectRefusals([&](const std::string& text) { return failure(write("bad.gltf", text)); },
                 {{buffer("absent.bin"), "'absent.bin', which is missing"},
                  {buffer("short.bin"), "has 71"},
                  {nodes(R"([{"children":[1]},{"children":[0]}])"), "ancestor"},
                  {nodes(R"([{"mesh":7}])"), "nodes[0].mesh is 7"},
                  {nodes(R"([{"mesh":-1}])"), "nodes[0].mesh"},
                  {nodes(R"([{"mesh":0,"scale":[1,1]}])"), "scale is not 3 numbers"},
                  {beyond, "accessors[0] reaches beyond"},
                  {R"({"asset":{"version":"1.0"}})", "glTF 1.0"},
                  {"[1, 2", "not valid glTF"},
                  {std::string(100000, '['), "not valid glTF"}});
  EXPECT_THAT(failure(write("other.glb", "not a GLB at all, although it is named like one")), HasSubstr("other.glb"));
}

// Costs are known, or bounded, before they are paid.
TEST_F(AssetFiles, SmallFilesThatAskForMuchAreRefusedAtOnce) {
  std::string polygon;
  std::string face = "f";
  for (int i = 1; i <= 100000; ++i) {
    polygon += fmt::format("v {} {} 0\n", std::cos(i * 6e-5), std::sin(i * 6e-5));
    face += fmt::format(" {}", i);
  }
  EXPECT_THAT(failure(write("round.obj", polygon + face + "\n")), HasSubstr("polygons of up to 100000 corners"));

  Gltf many;
  std::string nodes = "[";
  for (int i = 0; i < 20000; ++i) nodes += R"({"mesh":0},)";
  many.nodes = nodes + R"({"mesh":0}])";
  std::string scene;
  for (int i = 0; i <= 20000; ++i) scene += fmt::format("{}{}", i > 0 ? "," : "", i);
  std::string text = many.text();
  const auto replace = [&](const std::string& from, const std::string& to) {
    ASSERT_NE(text.find(from), std::string::npos) << text.substr(0, 600);
    text.replace(text.find(from), from.size(), to);
  };
  replace(R"("nodes":[0])", R"("nodes":[)" + scene + "]");
  const std::size_t first = text.find("\"primitives\":[") + 14;
  const std::string primitive = text.substr(first, text.find("}]", first) + 1 - first);
  std::string primitives = primitive;
  for (int i = 0; i < 300; ++i) primitives += "," + primitive;
  replace(primitive, primitives);
  EXPECT_THAT(failure(write("many.gltf", text)), HasSubstr("unpacked and with all copies"));
}

TEST_F(AssetFiles, NamesThatLeadOutsideHaveToBeAllowed) {
  write("outside.mtl", "newmtl paint\nKd 0.25 0.25 0.25\n");
  write("outside.bin", gltfBuffer());
  std::filesystem::create_directory(folder_.path() / "in");
  std::string obj = kObj;
  obj.replace(obj.find("a.mtl"), 5, "../outside.mtl");
  const auto object = write("in/a.obj", obj);
  EXPECT_THAT(failure(object), AllOf(HasSubstr("a.obj: names '../outside.mtl'"), HasSubstr("allow_outside: true")));
  EXPECT_NEAR(readAsset(object, {.allowOutside = true}).parts.at(0).fileMaterial.reflectance, 0.25, 1e-6);
  Gltf gltf;
  gltf.buffer = R"("uri":"../outside.bin")";
  const auto file = write("in/a.gltf", gltf.text());
  EXPECT_THAT(failure(file), AllOf(HasSubstr("a.gltf: names '../outside.bin'"), HasSubstr("allow_outside: true")));
  EXPECT_EQ(readAsset(file, {.allowOutside = true}).parts.at(0).triangles.size(), 1u);
}

// Reading from a pipe would wait for ever.
TEST_F(AssetFiles, LibrariesOfMaterialsAreFiles) {
  ASSERT_EQ(::mkfifo((folder_.path() / "a.mtl").c_str(), 0600), 0);
  EXPECT_THAT(failure(write("a.obj", kObj)), HasSubstr("a.obj: names 'a.mtl', which is not a file"));
  std::filesystem::remove(folder_.path() / "a.mtl");
  testing::internal::CaptureStderr();
  readAsset(folder_.path() / "a.obj", {});
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("a.obj: names 'a.mtl', which is missing: "));
}

TEST(DecodeUri, DecodesEscapesOnly) {
  EXPECT_EQ(decodeUri("textures%2Fa%20b.webp"), "textures/a b.webp");
  EXPECT_EQ(decodeUri("100%"), "100%");
  EXPECT_EQ(decodeUri("%zz%4"), "%zz%4");
  EXPECT_EQ(decodeUri("%41"), "A");
}

}  // namespace
}  // namespace scanmill
