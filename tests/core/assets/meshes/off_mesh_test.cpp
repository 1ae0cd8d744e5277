#include "assets/meshes/off_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/core/assets/meshes/triangle_files.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class OffMesh : public AssetFiles {
 protected:
  // Returns what the file leaves out.
  std::string leftOut(const std::string& text) { return readOffMesh(write("a.off", text), {}).leftOut.text(); }
};

const std::string kVertices = "1 0 0\n0 2 0\n0 0 3\n";

// The keyword may be missing, and files of ModelNet have it in the same word as the counts.
TEST_F(OffMesh, HeadingsOfAllKinds) {
  for (const char* head :
       {"OFF\n3 1 0\n", "OFF 3 1 0\n", "OFF3 1 0\n", "3 1\n", "# comment\n\nOFF # more\r\n3 1 3\r\n"}) {
    expectCorners(read("a.off", head + kVertices + "3 0 1 2\n"), {{1, 0, 0}, {0, 2, 0}, {0, 0, 3}}, head);
  }
  expectCorners(read("a.off", "OFF\r3 1 0\r1 0 0\r0 2 0\r0 0 3\r3 0 1 2\r"), {{1, 0, 0}, {0, 2, 0}, {0, 0, 3}}, "CR");
  expectCorners(read("a.off", "NOFF\n3 1 0\n1 0 0 0 0 1\n0 2 0 0 0 1\n0 0 3 0 0 1\n3 0 1 2\n"),
                {{1, 0, 0}, {0, 2, 0}, {0, 0, 3}}, "normals");
}

TEST_F(OffMesh, PolygonsOfManyCornersAreDivided) {
  std::string text = "OFF\n16 1 0\n";
  std::string face = "16";
  for (int i = 0; i < 16; ++i) {
    text += std::to_string(i < 8 ? i : 15 - i) + (i < 8 ? " 0 0\n" : " 1 0\n");
    face += " " + std::to_string(i);
  }
  const Asset asset = read("a.off", text + face + "\n");
  EXPECT_EQ(asset.parts.at(0).triangles.size(), 14u);
}

TEST_F(OffMesh, WhatNoSurfaceIsMadeFromIsCounted) {
  EXPECT_EQ(leftOut("OFF\n3 3 0\n" + kVertices + "3 0 1 2 255 0 0\n2 0 1\n1 2\nmore\n"),
            "1 colours of faces, 2 faces of one or two corners, 1 lines behind the faces");
  EXPECT_EQ(leftOut("COFF\n1 0 0\n1 2 3 255 0 0 255\n"), "1 colours of vertices");
  EXPECT_EQ(leftOut("OFF\n3 1 0\n" + kVertices + "3 0 1 2\n"), "");
}

TEST_F(OffMesh, MistakesAreNamedWithTheirLine) {
  EXPECT_THAT(failure(write("a.off", "OFF\n3 1 0\n1 0 0\n0 2\n")), AllOf(HasSubstr("a.off:4"), HasSubstr("three")));
  EXPECT_THAT(failure(write("a.off", "OFF\n3 1 0\n" + kVertices + "3 0 1\n")), HasSubstr("a.off:6: the face has 3"));
  EXPECT_THAT(failure(write("a.off", "OFF\n3 1 0\n" + kVertices + "3 0 1 -1\n")), HasSubstr("'-1'"));
  EXPECT_THAT(failure(write("a.off", "OFF\n3 1 0\n1 x 0\n0 2 0\n0 0 3\n3 0 1 2\n")),
              AllOf(HasSubstr("a.off:3"), HasSubstr("'x'")));
  EXPECT_THAT(failure(write("a.off", "OFF\n3 2 0\n" + kVertices + "3 0 1 2\n")), HasSubstr("ends before its 2 faces"));
  EXPECT_THAT(failure(write("a.off", "4OFF\n1 0 0\n1 2 3 4\n")), HasSubstr("convert it to PLY"));
  EXPECT_THAT(failure(write("a.off", "OFF BINARY\n")), HasSubstr("binary"));
}

}  // namespace
}  // namespace scanmill
