#include "assets/content_kind.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/core/assets/meshes/triangle_files.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// The message of a file that cannot be read says what its content looks like, if that does not fit its name.
TEST_F(AssetFiles, ContentThatDoesNotFitTheNameIsNamed) {
  const auto said = [&](const std::string& name, const std::string& text) { return failure(write(name, text)); };
  EXPECT_THAT(said("a.obj", "<?xml version=\"1.0\"?>\n<root/>\n"),
              AllOf(HasSubstr("a.obj"), HasSubstr("its first bytes look like XML")));
  EXPECT_THAT(said("a.x", "<?xml version=\"1.0\"?>\n<root/>\n"), HasSubstr("its first bytes look like XML"))
      << ".x is no part of .xml, .xacro or .x3d";
  EXPECT_THAT(said("a.stl", dae("Z_UP", "1")), HasSubstr("its first bytes look like COLLADA"));
  EXPECT_THAT(said("a.obj", "\n<!DOCTYPE html><html></html>"), HasSubstr("look like a web page"));
  EXPECT_THAT(said("a.fbx", "version https://git-lfs.github.com/spec/v1\noid sha256:0\n"), HasSubstr("Git LFS"));
  EXPECT_THAT(said("a.dae", std::string("\xFF\xFE<\0?\0x\0m\0l\0", 12)), HasSubstr("UTF-16"));
  EXPECT_THAT(said("a.gltf", "PK\x03\x04 and so on"), HasSubstr("look like a ZIP archive"));
  EXPECT_THAT(said("a.ac", glbOfTriangle()), HasSubstr("look like a GLB"));
  for (const char* start : {"", "<?xml version=\"1.0\"?>\n<!-- an arm -->\n"}) {
    EXPECT_THAT(said("a.xml", std::string(start) + "<mujoco/>"),
                HasSubstr("MJCF of MuJoCo: convert it to URDF or SDF"));
  }
  EXPECT_THAT(said("a.png", "\x89PNG"), AllOf(HasSubstr("unknown kind"), HasSubstr("a PNG image")));
}

TEST_F(AssetFiles, ContentThatFitsTheNameIsNotNamed) {
  for (const auto& [name, text] : {std::pair<const char*, std::string>{"a.dae", "<?xml version=\"1.0\"?><COLLADA>"},
                                   {"a.stl", "solid a\nfacet\n"},
                                   {"a.gltf", "{\"asset\":{}}"},
                                   {"a.ac", "AC3Db\nOBJECT world\nkids 0\n"},
                                   {"a.off", "OFF\n1 1 0\n"}}) {
    EXPECT_EQ(otherContent(write(name, text), std::string(name).substr(1)), "") << name;
    EXPECT_THAT(failure(folder_.path() / name), testing::Not(HasSubstr("look like"))) << name;
  }
}

}  // namespace
}  // namespace scanmill
