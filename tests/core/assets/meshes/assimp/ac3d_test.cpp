#include "assets/meshes/assimp/ac3d.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/assets/meshes/triangle_files.h"

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
  LeftOut leftOut;
  for (const char* const lines :
       {"texture \"colours.png\"\n", "texture \"colours.png\" base\n",
        "texture \"colours.png\" base\ntexture empty_texture_no_mapping tiled\ntexture \"skids.png\" skids\n",
        "texture \"shade.png\" shad\ntexture \"colours.png\" base\ntexture \"shade.png\" tiled\n",
        "texture \"colours.png\" base\r\ntexture empty_texture_no_mapping shad\r\n",
        "texture empty_texture_no_mapping tiled\ntexture \"colours.png\"\ntexture \"other.png\"\n"}) {
    EXPECT_EQ(readAc3d(write("a.ac", with(lines)), leftOut), plain) << lines;
  }
  EXPECT_THAT(readAc3d(write("a.ac", with("texture empty_texture_no_mapping base\n")), leftOut),
              testing::Not(HasSubstr("texture")));
  EXPECT_TRUE(leftOut.empty());
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

TEST_F(Ac3d, HiddenObjectsAreLeftOutWithThoseBelow) {
  const std::string object = std::string(kAc).substr(std::string(kAc).find("OBJECT poly"));
  const auto named = [&](const std::string& name, const std::string& line, int kids) {
    std::string text = object;
    text.replace(text.find("\"wing\"\n"), 7, "\"" + name + "\"\n" + line);
    return text.replace(text.rfind("kids 0"), 6, "kids " + std::to_string(kids));
  };
  std::string text = kAc;
  text.resize(text.find("OBJECT poly"));
  text.replace(text.find("kids 1"), 6, "kids 3");
  const std::string rest = named("first", "locked\n", 0) + named("hidden", "hidden\n", 1) + named("below", "", 0) +
                           named("last", "data 9\nhidden\nxy\n", 0);
  testing::internal::CaptureStderr();
  const Asset asset = read("a.ac", text + rest, {.alpha = AlphaUse::Ignore});
  const std::string warnings = testing::internal::GetCapturedStderr();
  ASSERT_EQ(asset.parts.size(), 2u);
  EXPECT_EQ(asset.parts[0].node, "first");
  EXPECT_EQ(asset.parts[1].node, "last");
  EXPECT_THAT(warnings, HasSubstr("a.ac: left out: 1 hidden objects\n"));
  testing::internal::CaptureStderr();
  read("cut.ac", text + named("first", "sparkle 7\n", 0));
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              HasSubstr("cut.ac: left out: 2 objects that 'kids' counts and the file lacks, 1 unknown 'sparkle'\n"));
}

// A point p of an object stands at rot * p + loc in the frame of the object above.
TEST_F(Ac3d, TransformsHoldForSurfacesAndForKids) {
  writeColours(folder_.path() / "colours.png");
  const std::string object = std::string(kAc).substr(std::string(kAc).find("OBJECT poly"));
  std::string moved = object;
  moved.insert(moved.find("numvert"), "rot 0 1 0 -1 0 0 0 0 1\nloc 10 20 30\n");
  moved.replace(moved.rfind("kids 0"), 6, "kids 1");
  std::string text = kAc;
  text.resize(text.find("OBJECT poly"));
  text.replace(text.find("kids 1"), 6, "kids 2");
  text += moved;
  text += moved.replace(moved.rfind("kids 1"), 6, "kids 0") + object;
  const Asset asset = read("moved.ac", text, {.up = 'z'});
  ASSERT_EQ(asset.parts.size(), 3u);
  const auto corners = [](std::initializer_list<Vec3f> at) { return testing::ElementsAreArray(at); };
  EXPECT_THAT(asset.parts[0].positions, corners({{10, 19, 30}, {12, 20, 30}, {10, 20, 33}}));
  EXPECT_THAT(asset.parts[1].positions, corners({{29, 10, 60}, {30, 8, 60}, {30, 10, 63}})) << "below the first";
  EXPECT_THAT(asset.parts[2].positions, corners({{1, 0, 0}, {0, 2, 0}, {0, 0, 3}})) << "beside the first";
}

TEST_F(Ac3d, CountsThatTheFileDoesNotReachAreTold) {
  std::string text = kAc;
  text.replace(text.find("numvert 3"), 9, "numvert 4");
  text.replace(text.find("numsurf 1"), 9, "numsurf 3");
  testing::internal::CaptureStderr();
  read("short.ac", text);
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              testing::AllOf(HasSubstr("not all vertices have been parsed"),
                             HasSubstr("left out: 2 surfaces that 'numsurf' counts and the file lacks")));
}

TEST_F(Ac3d, ImagesRepeatAndShift) {
  writeColours(folder_.path() / "colours.png");
  const Asset asset = read("a.ac", with("texture \"colours.png\"\ntexrep 2 4\ntexoff 0.25 0.125\n"));
  const std::vector<Vec2f>& uvs = asset.parts.at(0).uvs;  // corner 1 has 0.75 0.25
  EXPECT_EQ(uvs.at(1).x, 1.75f);
  EXPECT_EQ(uvs.at(1).y, 1.125f);
}

TEST_F(Ac3d, MaterialsMayBeBlocks) {
  std::string text = kAc;
  const std::size_t at = text.find("MATERIAL");
  text.replace(at, text.find("OBJECT") - at,
               "MAT \"other\"\nrgb 0 0 0\namb 0 0 0\nemis 0 0 0\nspec 0 0 0\nshi 10\ntrans 0\nENDMAT\n"
               "MAT \"paint\"\nrgb 0.5 0.25 0.5\namb 0.2 0.2 0.2\nemis 0 0 0\nspec 0.5 0.5 0.5\nshi 10\ntrans 0\n"
               "data 4\nnote\nENDMAT\n");
  text.replace(text.find("mat 0"), 5, "mat 1");
  text.replace(text.find("colours.png"), 11, "(null)");
  testing::internal::CaptureStderr();
  const Asset asset = read("a.ac", text);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "(null) names no texture";
  EXPECT_EQ(asset.parts.at(0).material, "paint");
  EXPECT_EQ(asset.parts[0].color[1], 0.25f);
  EXPECT_EQ(asset.parts[0].texture, "");
}

}  // namespace
}  // namespace scanmill
