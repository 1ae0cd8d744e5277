// `scanmill draft`: a scene file of 3D files, and a picture of it.

#include <fmt/format.h>

#include "base/file.h"
#include "tests/commands/program.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class DraftCommand : public SmallWorld {
 protected:
  void SetUp() override {
    SmallWorld::SetUp();
    folder_.write("models/oak.obj", "o crown\nv -1 0 2\nv 1 0 2\nv 0 1 9\nf 1 2 3\n");
    folder_.write("models/road.obj", "o a\nv -9 -9 0\nv 9 -9 0\nv 9 9 0\nf 1 2 3\n");
  }
};

TEST_F(DraftCommand, WritesASceneThatReadsAndAPicture) {
  const Outcome o = scanmill({"draft", at("models"), "-o", at("place.yaml")});
  ASSERT_EQ(o.code, 0) << o.error;
  EXPECT_THAT(o.out, AllOf(HasSubstr("oak.obj"), HasSubstr("2 of 2 triangles"), HasSubstr("place.png")));
  EXPECT_GT(std::filesystem::file_size(at("place.png")), 1000u);
  const Outcome info = scanmill({"info", at("place.yaml")});
  EXPECT_EQ(info.code, 0) << info.error;
  EXPECT_THAT(info.out, AllOf(HasSubstr("tree"), HasSubstr("road"), HasSubstr("2 instances")));
}

// One file that has nothing to draft does not spoil a folder, unless a user names it.
TEST_F(DraftCommand, GoesOnWithoutWhatCannotBeRead) {
  folder_.write("models/frames.urdf", "");
  const Outcome o = scanmill({"draft", at("models"), "-o", at("place.yaml")});
  ASSERT_EQ(o.code, 0) << o.error;
  EXPECT_THAT(o.error, AllOf(HasSubstr("left out: "), HasSubstr("frames.urdf: is empty")));
  expectRefused(scanmill({"draft", at("models/frames.urdf"), "-o", at("a.yaml")}), "frames.urdf: is empty");
  folder_.write("w.urdf",
                "<robot name=\"r\"><link name=\"l\"><visual><geometry><box size=\"1 1 1\"/></geometry></visual><visual>"
                "<geometry><mesh filename=\"gone.stl\"/></geometry></visual></link></robot>");
  expectRefused(scanmill({"draft", at("w.urdf"), "-o", at("w.yaml")}), "--leave-out-missing");
  const Outcome whole = scanmill({"draft", at("w.urdf"), "-o", at("w.yaml"), "--leave-out-missing"});
  ASSERT_EQ(whole.code, 0) << whole.error;
  EXPECT_THAT(whole.error, HasSubstr("missing models and meshes ('gone.stl')"));
  EXPECT_THAT(readFile(at("w.yaml")), HasSubstr("missing: leave_out"));
}

}  // namespace
}  // namespace scanmill
