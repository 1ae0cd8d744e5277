#include "assets/asset_kinds.h"

#include <tuple>

#include "tests/core/assets/meshes/triangle_files.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// The message of a file that cannot be read says how it can be converted, or what its content looks like, if that does
// not fit its name.
TEST_F(AssetFiles, WhatCannotBeReadIsNamedWithWhatHelps) {
  using namespace std::string_literals;
  for (const auto& [name, text, words] :
       {std::tuple{"a.obj", "<?xml version=\"1.0\"?>\n<root/>\n"s, "its first bytes look like XML"},
        {"a.x", "<?xml version=\"1.0\"?>\n<root/>\n"s, "its first bytes look like XML"},
        {"a.stl", dae("Z_UP", "1"), "its first bytes look like COLLADA"},
        {"a.obj", "\n<!DOCTYPE html><html></html>"s, "look like a web page"},
        {"a.stl", "version https://git-lfs.github.com/spec/v1\noid sha256:0\n"s, "Git LFS"},
        {"a.gltf", "\xFF\xFE<\0?\0x\0m\0l\0"s, "UTF-16"},
        {"a.gltf", "PK\x03\x04 and so on"s, "look like a ZIP archive"},
        {"a.ac", glbOfTriangle(), "look like a GLB"},
        {"a.xml", "<mujoco/>"s, "MJCF of MuJoCo: convert it to URDF or SDF"},
        {"a.xml", "<?xml version=\"1.0\"?>\n<!-- an arm -->\n<mujoco/>"s, "MJCF of MuJoCo"},
        {"a.png", "\x89PNG"s, "a PNG image"},
        {"a.txt", "1 2 3\n"s, "points to XYZ"},
        {"town.osm.bz2", "x"s, "is a map of OpenStreetMap"}}) {
    EXPECT_THAT(failure(write(name, text)), AllOf(HasSubstr(name), HasSubstr(words))) << text;
  }
}

TEST_F(AssetFiles, ContentThatFitsTheNameIsNotNamed) {
  for (const auto& [name, text] : {std::pair<const char*, std::string>{"a.dae", "<?xml version=\"1.0\"?><COLLADA>"},
                                   {"a.stl", "solid a\nfacet\n"},
                                   {"a.gltf", "{\"asset\":{}}"},
                                   {"a.ac", "AC3Db\nOBJECT world\nkids 0\n"}}) {
    EXPECT_EQ(otherContent(write(name, text)), "") << name;
    EXPECT_THAT(failure(folder_.path() / name), testing::Not(HasSubstr("look like"))) << name;
  }
}

TEST_F(AssetFiles, OfAFolderOnlySureKindsAreTaken) {
  for (const char* folder : {"in", "model"}) std::filesystem::create_directory(folder_.path() / folder);
  for (const char* name :
       {"b.obj", "in/a.usdz", "c.json", "d.off", "e.3ds", "f.off", "model/model.sdf", "model/m.dae"}) {
    write(name, "x");
  }
  testing::internal::CaptureStderr();
  EXPECT_THAT(assetsIn(folder_.path()), testing::ElementsAre(folder_.path() / "b.obj", folder_.path() / "in/a.usdz",
                                                             folder_.path() / "model/model.sdf"));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("left out: 1 .3ds, 2 .off: "));
}

}  // namespace
}  // namespace scanmill
