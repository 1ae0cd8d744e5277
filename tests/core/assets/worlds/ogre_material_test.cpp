#include "assets/worlds/ogre_material.h"

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

class OgreMaterials : public testing::Test {
 protected:
  std::map<std::string, OgreMaterial> read(const std::string& script) {
    return readOgreMaterials(folder_.write("a.material", script), leftOut_);
  }
  TemporaryFolder folder_;
  LeftOut leftOut_;
};

TEST_F(OgreMaterials, InheritWhatTheyDoNotState) {
  auto found = read(R"(
    material Leaf : Tree { technique { pass { diffuse 0 1 0 } } }
    material Tree : Base
    { technique { pass { alpha_rejection greater 51 texture_unit { texture bark.png } } } }
    material Base { technique { pass { diffuse 1 0 0 texture_unit { texture base.png } } } }
    material Lost : Gone { }
    )");
  EXPECT_EQ(found["Leaf"].texture, "bark.png");
  EXPECT_EQ(found["Leaf"].color, (std::array<float, 3>{0, 1, 0}));
  EXPECT_EQ(found["Leaf"].alphaCutoff, 0.2f);
  EXPECT_EQ(found["Tree"].texture, "bark.png");
  EXPECT_EQ(found["Tree"].color, (std::array<float, 3>{1, 0, 0}));
  EXPECT_EQ(found["Lost"].texture, "");
  EXPECT_TRUE(leftOut_.empty()) << leftOut_.text();
}

TEST_F(OgreMaterials, StatementsThatChangeTheLookAreCounted) {
  read(
      "material A\n{\n technique\n {\n  pass\n  {\n   ambient 1 1 1\n   scene_blend alpha_blend\n   texture_unit\n   "
      "{\n"
      "    anim_texture a.png 2 1\n    scale 2 2\n    scroll 1 0\n   }\n  }\n }\n}\n"
      "vertex_program B glsl\n{\n source b.vert\n}\n");
  EXPECT_EQ(leftOut_.text(),
            "1 blended materials, which are solid (scene_blend), 2 changes of texture coordinates, "
            "1 images in several files (anim_texture, cubic_texture)");
}

}  // namespace
}  // namespace scanmill
