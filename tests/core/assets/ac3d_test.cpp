#include "assets/ac3d.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/assets/triangle_files.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

class Ac3d : public AssetFiles {
 protected:
  // kAc with other lines in place of its texture.
  std::string with(const std::string& lines) const {
    std::string text = kAc;
    const std::string own = "texture \"colours.png\"\n";
    text.replace(text.find(own), own.size(), lines);
    return text;
  }
};

TEST_F(Ac3d, TheBaseLayerIsTheTexture) {
  const std::string plain = kAc;
  for (const char* const lines :
       {"texture \"colours.png\"\n", "texture \"colours.png\" base\n",
        "texture \"colours.png\" base\ntexture empty_texture_no_mapping tiled\ntexture \"skids.png\" skids\n",
        "texture \"shade.png\" shad\ntexture \"colours.png\" base\ntexture \"shade.png\" tiled\n",
        "texture \"colours.png\" base\r\ntexture empty_texture_no_mapping shad\r\n",
        "texture empty_texture_no_mapping tiled\ntexture \"colours.png\"\ntexture \"other.png\"\n"}) {
    EXPECT_EQ(readAc3d(write("a.ac", with(lines))), plain) << lines;
  }
  EXPECT_THAT(readAc3d(write("a.ac", with("texture empty_texture_no_mapping base\n"))),
              testing::Not(HasSubstr("texture")));
}

TEST_F(Ac3d, RacesLayersComeIn) {
  writeColours(folder_.path() / "colours.png");
  for (const char* const kind : {"a.ac", "a.acc"}) {
    const std::string text =
        with("texture \"colours.png\" base\ntexture empty_texture_no_mapping tiled\ntexture \"x.png\" shad\n");
    EXPECT_EQ(read(kind, text).up, 'y') << kind;
    const Asset asset = read(kind, text, {.up = 'z'});
    ASSERT_EQ(asset.parts.size(), 1u);
    EXPECT_EQ(asset.parts[0].texture, "colours.png");
    expectColours(asset.parts[0], kind);
  }
}

}  // namespace
}  // namespace scanmill
