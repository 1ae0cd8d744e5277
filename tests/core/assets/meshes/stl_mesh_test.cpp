#include <cctype>
#include <cstdint>
#include <string>
#include <vector>

#include "assets/meshes/imported_file.h"
#include "tests/core/assets/meshes/triangle_files.h"
#include "tests/core/assets/read_assets.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::vector<Vec3f> kStlWing{{1, 0, 0}, {0, 2, 0}, {0, 0, 3}};

std::string binary(const std::string& header, std::uint32_t stated = 1, std::uint16_t attribute = 0) {
  std::string head = header;
  head.resize(80, ' ');
  return head + bytesOf<std::uint32_t>({stated}) + bytesOf<float>({0, 0, 1, 1, 0, 0, 0, 2, 0, 0, 0, 3}) +
         bytesOf<std::uint16_t>({attribute});
}

class StlMesh : public AssetFiles {
 protected:
  // Returns the warnings that reading the file prints.
  std::string warnings(const std::string& name, const std::string& text) {
    testing::internal::CaptureStderr();
    read(name, text);
    return testing::internal::GetCapturedStderr();
  }
};

TEST_F(StlMesh, KeywordsMayBeInUpperCase) {
  std::string upper = kStl;
  std::transform(upper.begin(), upper.end(), upper.begin(), [](unsigned char c) { return std::toupper(c); });
  const Asset asset = read("a.stl", "\xEF\xBB\xBF" + upper);
  expectCorners(asset, kStlWing, "upper case");
  EXPECT_EQ(asset.parts.at(0).node, "WING");
}

TEST_F(StlMesh, SolidsAreNodesAndLongLoopsAreDivided) {
  const std::string two =
      "solid left wing  \nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\n"
      "endloop\nendfacet\nendsolid left wing\n";
  const Asset asset = read("a.stl", two + kStl);
  ASSERT_EQ(asset.parts.size(), 2u);
  EXPECT_EQ(asset.parts[0].node, "left wing");
  EXPECT_EQ(asset.parts[0].triangles.size(), 2u);
  EXPECT_EQ(asset.parts[1].node, "wing");
  EXPECT_NE(asset.parts[0].nodeIndex, asset.parts[1].nodeIndex);
}

TEST_F(StlMesh, CoordinatesOfTextsKeepTheirDigits) {
  std::string far = kStl;
  far.replace(far.find("vertex 1 0 0"), 12, "vertex 5400001.25 0 0");
  far.replace(far.find("vertex 0 2 0"), 12, "vertex 5400000.50 2 0");
  far.replace(far.find("vertex 0 0 3"), 12, "vertex 5400000.50 0 3");
  const Asset asset = read("a.stl", far);
  EXPECT_NEAR(asset.origin.x + double{asset.parts.at(0).positions[0].x}, 5400001.25, 1e-6);
}

// Programs write "solid" at the beginning of binary files, too.
TEST_F(StlMesh, BinaryFilesAreKnownByTheirSize) {
  for (const char* header : {"", "solid wing", "SOLID"}) {
    expectCorners(read("a.stl", binary(header)), kStlWing, header);
    expectCorners(read("a.stl", binary(header) + "end"), kStlWing, header);
  }
  EXPECT_THAT(failure(write("short.stl", binary("solid", 2))),
              AllOf(HasSubstr("short.stl: is truncated"), HasSubstr("states 2 triangles, 1 follow")));
  EXPECT_THAT(failure(write("tiny.stl", "no STL file")), HasSubstr("tiny.stl: is truncated, or not an STL file"));
}

TEST_F(StlMesh, WhatIsLeftOutIsCounted) {
  EXPECT_EQ(warnings("plain.stl", binary("")), "");
  EXPECT_EQ(warnings("plain.stl", kStl), "");
  EXPECT_THAT(warnings("colours.stl", binary("COLOR=1234", 1, 0x8012) + "xx"),
              HasSubstr("left out: 2 bytes behind the triangles, 1 colours in the header (COLOR=), 1 colours of "
                        "triangles (attribute bytes)"));
  std::string other = kStl;
  other.insert(other.find("outer"), "color 1 0 0\n");
  EXPECT_THAT(warnings("color.stl", other), HasSubstr("color.stl: left out: 1 unknown 'color'\n"));
  std::string open = kStl;
  open.resize(open.find("endsolid"));
  EXPECT_THAT(warnings("open.stl", open), HasSubstr("open.stl: may be incomplete"));
}

TEST_F(StlMesh, CarriageReturnsEndLines) {
  std::string text = kStl;
  std::replace(text.begin(), text.end(), '\n', '\r');
  expectCorners(read("a.stl", text), kStlWing, "old Mac OS");
}

TEST_F(StlMesh, DamagedTextsAreRefusedWithTheirLine) {
  std::string text = kStl;
  EXPECT_THAT(failure(write("cut.stl", text.substr(0, text.find("vertex 0 0 3")))),
              HasSubstr("ends within a facet: is it truncated?"));
  text.replace(text.find("vertex 0 2 0"), 12, "vertex 0 two 0");
  EXPECT_THAT(failure(write("word.stl", text)), HasSubstr("word.stl:5: 'two' is not a number"));
}

}  // namespace
}  // namespace scanmill
