#include "assets/meshes/ply_mesh.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "assets/asset.h"
#include "base/error.h"
#include "tests/core/assets/read_assets.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

template <class T>
std::string bytesOfValue(T value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

// A fan of triangles around the z axis, little-endian, of which each test changes what it is about.
struct Fan {
  std::string vertexProperties = "property float x\nproperty float y\nproperty float z\nproperty uchar red\n";
  std::string faceProperties = "property list uchar int vertex_indices\nproperty short mark\n";
  bool exact = false;  // x, y and z in double
  double east = 0;     // m, added to x

  static constexpr int kTriangles = 40;

  std::string header() const {
    return "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(kTriangles + 1) + "\n" +
           vertexProperties + "element face " + std::to_string(kTriangles) + "\n" + faceProperties + "end_header\n";
  }

  std::string body() const {
    std::string out;
    for (int i = 0; i <= kTriangles; ++i) {
      const double angle = 0.1 * i;
      const double radius = i == 0 ? 0 : 3;
      for (const double p : {east + radius * std::cos(angle), radius * std::sin(angle), 0.01 * i}) {
        out += exact ? bytesOfValue(p) : bytesOfValue(static_cast<float>(p));
      }
      out += static_cast<char>(i);
    }
    for (int i = 0; i < kTriangles; ++i) {
      out += '\3';
      for (const int corner : {0, 1 + i, i + 1 < kTriangles ? 2 + i : 2}) out += bytesOfValue(corner);
      out += bytesOfValue(std::int16_t{7});
    }
    return out;
  }

  std::string text() const { return header() + body(); }
};

class PlyMesh : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& text) const { return folder_.write("a.ply", text); }

  TemporaryFolder folder_;
};

const std::string kDoubles = "property double x\nproperty double y\nproperty double z\nproperty uchar red\n";

TEST_F(PlyMesh, LargeCoordinatesInDoubleLoseNothing) {
  Fan near;
  near.exact = true;
  near.vertexProperties = kDoubles;
  Fan far = near;
  far.east = 4'500'000;
  const auto here = readPlyMesh(write(near.text()), {});
  const auto there = readPlyMesh(write(far.text()), {});
  EXPECT_EQ(here.origin, Vec3d());
  EXPECT_NEAR(there.origin.x, 4'500'000, 10);
  EXPECT_EQ(there.origin.y, 0);
  for (std::size_t i = 0; i < here.parts[0].positions.size(); ++i) {
    const Vec3d moved = Vec3d(there.parts[0].positions[i]) + there.origin - Vec3d{far.east, 0, 0};
    EXPECT_LT(length(Vec3d(here.parts[0].positions[i]) - moved), 1e-6) << i;
  }
  EXPECT_EQ(readAsset(write(far.text()), {}).origin, there.origin);
}

TEST_F(PlyMesh, OneStrayVertexDoesNotCostTheOthersTheirDigits) {
  Fan fan;
  fan.exact = true;
  fan.vertexProperties = kDoubles;
  fan.east = 4'500'000;
  const std::string sound = fan.body();
  for (const double stray : {0.0, 1e300, std::numeric_limits<double>::infinity()}) {
    std::string body = sound;
    for (std::size_t axis = 0; axis < 3; ++axis) body.replace(axis * 8, 8, bytesOfValue(stray));
    const auto read = readPlyMesh(write(fan.header() + body), {});
    const Vec3d second = Vec3d(read.parts[0].positions[1]) + read.origin - Vec3d{fan.east, 0, 0};
    EXPECT_LT(length(second - Vec3d{3 * std::cos(0.1), 3 * std::sin(0.1), 0.01}), 1e-6) << stray;
  }
}

TEST_F(PlyMesh, CoarseCoordinatesAreWarnedOf) {
  Fan fan;
  readAsset(write(fan.text()), {});
  testing::internal::CaptureStderr();
  readAsset(write(fan.text()), {});
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  fan.east = 4'500'000;
  testing::internal::CaptureStderr();
  readAsset(write(fan.text()), {});
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              HasSubstr("its coordinates reach 4500003 m, where single precision, in which this kind of file "
                        "is read, has steps of 0.5 m"));
}

TEST_F(PlyMesh, WhatHasNoPlaceIsKept) {
  Fan fan;
  std::string body = fan.body();
  const float nowhere = std::numeric_limits<float>::quiet_NaN();
  body.replace(0, 4, bytesOfValue(nowhere));
  const auto read = readPlyMesh(write(fan.header() + body), {});
  EXPECT_TRUE(std::isnan(read.parts[0].positions[0].x));
  EXPECT_EQ(read.parts[0].triangles.size(), std::size_t{Fan::kTriangles});
}

// The head of a text of a square, with properties of its two faces.
std::string squareHead(const std::string& comments, const std::string& vertex, const std::string& face) {
  return "ply\nformat ascii 1.0\n" + comments +
         "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n" + vertex +
         "element face 2\nproperty list uchar int vertex_indices\n" + face;
}

constexpr const char* kSquare = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
constexpr const char* kTexcoord = "property list uchar float texcoord\n";

// Two faces that share vertices may show different places of an image, as MeshLab writes them.
TEST_F(PlyMesh, CornersHaveTextureCoordinatesOfTheirOwn) {
  const ImportedFile read = readPlyMesh(
      write(squareHead("comment TextureFile a wall.png\n", "property float s\nproperty float t\n", kTexcoord) +
            "end_header\n0 0 0 9 9\n1 0 0 9 9\n1 1 0 9 9\n0 1 0 9 9\n3 0 1 2 6 0 0 1 0 1 1\n3 0 2 3 6 0.5 0 1.5 1 0.5 "
            "1\n"),
      {});
  ASSERT_EQ(read.parts.size(), 1u);
  const AssetPart& part = read.parts[0];
  EXPECT_EQ(read.materials.at(part.materialIndex).base.name, "a wall.png");
  ASSERT_EQ(part.triangles.size(), 2u);
  EXPECT_EQ(part.positions.size(), 6u);
  EXPECT_EQ(part.positions[part.triangles[0][0]], part.positions[part.triangles[1][0]]);
  EXPECT_EQ(part.uvs.at(part.triangles[0][0]), (Vec2f{0, 0}));
  EXPECT_EQ(part.uvs.at(part.triangles[1][0]), (Vec2f{0.5f, 0}));
  EXPECT_EQ(part.uvs.at(part.triangles[1][1]), (Vec2f{1.5f, 1}));
}

TEST_F(PlyMesh, VerticesHaveTextureCoordinates) {
  for (const auto& [u, v] : {std::pair("s", "t"), {"u", "v"}, {"texture_u", "texture_v"}}) {
    const ImportedFile read =
        readPlyMesh(write(squareHead("", fmt::format("property float {}\nproperty float {}\n", u, v), "") +
                          "end_header\n0 0 0 0.1 0.2\n1 0 0 0 0\n1 1 0 0 0\n0 1 0 0 0\n3 0 1 2\n3 0 2 3\n"),
                    {});
    EXPECT_EQ(read.parts.at(0).uvs.at(0), (Vec2f{0.1f, 0.2f})) << u;
  }
}

TEST_F(PlyMesh, FacesNameTheirImages) {
  const std::string images = "comment TextureFile a.png\ncomment TextureFile b.png\n";
  const std::string faces = std::string(kTexcoord) + "property int texnumber\n";
  ImportedFile read = readPlyMesh(write(squareHead(images, "", faces) + "end_header\n" + kSquare +
                                        "3 0 1 2 6 0 0 1 0 1 1 0\n3 0 2 3 6 0 0 1 1 0 1 1\n"),
                                  {});
  ASSERT_EQ(read.parts.size(), 2u);
  EXPECT_EQ(read.materials.at(read.parts[0].materialIndex).base.name, "a.png");
  EXPECT_EQ(read.materials.at(read.parts[1].materialIndex).base.name, "b.png");
  EXPECT_TRUE(read.leftOut.empty()) << read.leftOut.text();
  read = readPlyMesh(
      write(squareHead(images, "", faces) + "end_header\n" + kSquare + "3 0 1 2 6 0 0 1 0 1 1 0\n3 0 2 3 0 -1\n"), {});
  ASSERT_EQ(read.parts.size(), 2u);
  EXPECT_EQ(read.materials.at(read.parts[1].materialIndex).base.name, "");
  EXPECT_TRUE(read.parts[1].uvs.empty());
  EXPECT_EQ(read.leftOut.text(), "1 images that no face shows (TextureFile)");
}

TEST_F(PlyMesh, FacesNameTheirMaterials) {
  const ImportedFile read = readPlyMesh(
      write(
          squareHead("", "property int material_index\n", "property int material_index\n") +
          "element material 2\nproperty uchar diffuse_red\nproperty uchar diffuse_green\nproperty uchar diffuse_blue\n"
          "end_header\n0 0 0 0\n1 0 0 0\n1 1 0 0\n0 1 0 0\n4 0 1 2 3 1\n3 0 2 3 7\n51 51 51\n204 204 0\n"),
      {});
  ASSERT_EQ(read.parts.size(), 2u);
  EXPECT_EQ(read.parts[0].triangles.size(), 2u);
  EXPECT_EQ(read.materials.at(0).color, (std::array<float, 3>{0.8f, 0.8f, 0}));
  EXPECT_TRUE(read.materials[0].stated);
  EXPECT_FALSE(read.materials.at(1).stated) << "there is no material 7";
  EXPECT_EQ(read.leftOut.text(), "1 'material_index' of vertices");
}

TEST_F(PlyMesh, WhatNoSurfaceIsMadeFromIsTold) {
  const std::string text =
      squareHead("comment units: mm\n", "property uchar red\nproperty uchar green\nproperty int label\n",
                 "property uchar red\nproperty int object_id\n") +
      "element edge 1\nproperty int vertex1\nend_header\n0 0 0 1 1 1\n1 0 0 1 1 1\n1 1 0 1 1 1\n"
      "0 1 0 1 1 1\n3 0 1 2 1 1\n2 0 1 1 1\n5\n";
  testing::internal::CaptureStderr();
  readAsset(write(text), {});
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              AllOf(HasSubstr("left out: 2 colours of faces, 4 colours of vertices, 2 columns of labels "
                              "or instances (without its faces, as a cloud, the file keeps them), 1 elements 'edge', 1 "
                              "faces of fewer than three corners\n"),
                    HasSubstr("its comment says that units are mm: `unit: 0.001` reads it so")));
}

// A tetrahedron, with a quality after each list and an element after the faces.
struct Ply {
  std::string format = "binary_little_endian";
  std::string newline = "\n";
  std::string countType = "uchar";
  std::vector<int> lengths{3, 3, 3, 3};  // as written; each list has three indices all the same
  float firstX = 0;

  std::string header() const {
    std::string text;
    for (const std::string& line :
         {std::string("ply"), "format " + format + " 1.0", std::string("comment of no use"),
          std::string("element vertex 4"), std::string("property float x"), std::string("property float y"),
          std::string("property float z"), std::string("element face 4"),
          "property list " + countType + " int vertex_indices", std::string("property double quality"),
          std::string("element end 1"), std::string("property short mark"), std::string("end_header")}) {
      text += line + newline;
    }
    return text;
  }

  template <class T>
  std::string bytes(T value) const {
    std::string out(reinterpret_cast<const char*>(&value), sizeof value);
    const bool swapped = (format == "binary_big_endian") == (std::endian::native == std::endian::little);
    if (swapped) std::reverse(out.begin(), out.end());
    return out;
  }

  std::string length(int value) const {
    if (countType == "float") return bytes(static_cast<float>(value));
    if (countType == "double") return bytes(static_cast<double>(value));
    if (countType == "char" || countType == "uchar") return bytes(static_cast<std::int8_t>(value));
    if (countType == "short" || countType == "ushort") return bytes(static_cast<std::int16_t>(value));
    return bytes(value);
  }

  std::string body() const {
    static constexpr int kFaces[4][3] = {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}};
    std::string out;
    if (format == "ascii") {
      for (const char* vertex : {"0 0 0", "1 0 0", "0 1 0", "0 0 1"}) out += vertex + newline;
      for (std::size_t i = 0; i < 4; ++i) {
        out += std::to_string(lengths[i]);
        for (const int index : kFaces[i]) out += " " + std::to_string(index);
        out += " 0.25" + newline;
      }
      return out + "-7" + newline;
    }
    for (const float value : {firstX, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f}) out += bytes(value);
    for (std::size_t i = 0; i < 4; ++i) {
      out += length(lengths[i]);
      for (const int index : kFaces[i]) out += bytes(index);
      out += bytes(0.25);
    }
    return out + bytes(std::int16_t{-7});
  }
};

class PlyDamage : public testing::Test {
 protected:
  void accept(const std::string& text, const std::string& what) {
    EXPECT_EQ(trianglesOf(readAsset(folder_.write("a.ply", text), {})), 4u) << what;
  }

  std::string failure(const std::string& text) {
    return messageOf([&] { readPlyMesh(folder_.write("a.ply", text), {}); });
  }

  TemporaryFolder folder_;
};

TEST_F(PlyDamage, WholeFilesAreRead) {
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    for (const char* newline : {"\n", "\r\n"}) {
      for (const char* type : {"char", "uchar", "short", "ushort", "int", "uint", "float", "double"}) {
        const Ply ply{.format = format, .newline = newline, .countType = type};
        accept(ply.header() + ply.body(), ply.header());
        accept(ply.header() + ply.body() + "more", ply.header());
      }
    }
  }
}

TEST_F(PlyDamage, ALineFeedAfterAMacHeaderIsData) {
  Ply ply{.newline = "\r"};
  ply.firstX = std::bit_cast<float>(std::uint32_t{0x3f00000a});
  EXPECT_EQ(readPlyMesh(folder_.write("a.ply", ply.header() + ply.body()), {}).parts.at(0).positions.size(), 4u);
  ply.format = "ascii";
  EXPECT_EQ(readPlyMesh(folder_.write("a.ply", ply.header() + ply.body()), {}).parts.at(0).positions.size(), 4u);
}

TEST_F(PlyDamage, WhatNoFaceUsesIsCounted) {
  for (const char* format : {"ascii", "binary_little_endian"}) {
    const Ply ply{.format = format};
    const auto told = [&](const std::string& bytes) {
      return readPlyMesh(folder_.write("a.ply", bytes), {}).leftOut.text();
    };
    const std::string whole = ply.header() + ply.body();
    EXPECT_EQ(told(whole), told(whole + "\n\n"));
    EXPECT_THAT(told(whole + "1 2 3\n"), HasSubstr("6 bytes behind the stated contents"));
  }
  const std::string points =
      "ply\nformat ascii 1.0\nelement vertex 7\nproperty float x\nproperty float y\nproperty float "
      "z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  std::string body;
  for (const char* p : {"0 0 0", "1 0 0", "0 1 0", "5 5 5", "6 5 5", "7 5 5", "8 5 5"}) body += std::string(p) + "\n";
  EXPECT_EQ(readPlyMesh(folder_.write("b.ply", points + body + "3 0 1 2\n"), {}).leftOut.text(),
            "4 vertices that no face uses");
}

TEST_F(PlyDamage, EveryCutIsRefused) {
  for (const Ply& ply : {Ply{}, Ply{.format = "binary_big_endian", .countType = "int"}}) {
    const std::string header = ply.header();
    const std::string whole = header + ply.body();
    for (std::size_t size = 0; size < whole.size(); size += size < header.size() - 10 ? 10 : 1) {
      EXPECT_THAT(failure(whole.substr(0, size)), AllOf(HasSubstr("a.ply"), HasSubstr("truncated"))) << size;
    }
  }
  const Ply ply;
  const std::string body = ply.body();
  EXPECT_THAT(failure(ply.header() + body.substr(0, 47)), HasSubstr("it ends within 'vertex' 4 of 4"));
  EXPECT_THAT(failure(ply.header() + body.substr(0, 48)), HasSubstr("it ends within 'face' 1 of 4"));
  EXPECT_THAT(failure(ply.header() + body.substr(0, 48 + 3 * 21)), HasSubstr("it ends within 'face' 4 of 4"));
  EXPECT_THAT(failure(ply.header() + body.substr(0, body.size() - 1)), HasSubstr("it ends within 'end' 1 of 1"));
  EXPECT_THROW(readAsset(folder_.path() / "a.ply", {}), InputError);
}

TEST_F(PlyDamage, EveryMissingWordIsRefused) {
  for (const char* newline : {"\n", "\r\n"}) {
    const Ply ply{.format = "ascii", .newline = newline};
    const std::string body = ply.body();
    accept(ply.header() + body.substr(0, body.size() - ply.newline.size()), "without its last newline");
    EXPECT_THAT(failure(ply.header() + newline + body), HasSubstr("a.ply:14: 'vertex' 1 of 4 lacks values"));
    for (std::size_t size = 0; size < body.size(); ++size) {
      if (body[size] != ' ') continue;
      EXPECT_THAT(failure(ply.header() + body.substr(0, size)), HasSubstr("truncated")) << size;
      std::string gap = body;  // the line lacks one word, the file goes on
      while (gap[size] != newline[0]) gap.erase(size, 1);
      EXPECT_THAT(failure(ply.header() + gap), HasSubstr("truncated")) << size;
    }
  }
}

TEST_F(PlyDamage, ListsThatAreTooLongAreRefused) {
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    Ply ply{.format = format, .countType = "int"};
    for (const int length : {1 << 30, 2000, -3}) {
      ply.lengths[1] = length;
      EXPECT_THAT(failure(ply.header() + ply.body()), HasSubstr("'face' 2 of 4")) << format << " " << length;
    }
  }
}

TEST_F(PlyDamage, WhatSurfacesNeedIsRequired) {
  const Ply ply{.format = "ascii"};
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = ply.header() + ply.body();
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  EXPECT_THAT(failure(with("float z", "float height")), HasSubstr("its vertices have no property z"));
  EXPECT_THAT(failure(with("element face 4", "element tristrips 4")), HasSubstr("export it with faces"));
  EXPECT_THAT(failure(with("element end 1", "element vertex 1\nproperty int x\nproperty int y\nproperty int z")),
              HasSubstr("has two elements 'vertex'"));
  EXPECT_THAT(failure(with("vertex_indices", "corners")), HasSubstr("its faces have no list vertex_indices"));
  EXPECT_THAT(failure(with("element vertex 4", "element vertex 0")), HasSubstr("no vertices before its faces"));
  EXPECT_THAT(failure(with("1 0 0", "1,5 0 0")),
              HasSubstr("a.ply:15: x must be a number such as 1234.5 or -1.2e-3, not '1,5'"));
}

TEST_F(PlyDamage, LongFilesAreWalkedToTheEnd) {
  // 50,000 faces of 3 to 6 corners reach over many blocks of the reader.
  std::string body(12, '\0');
  constexpr int kFaces = 50000;
  for (int i = 0; i < kFaces; ++i) {
    const int corners = 3 + i % 4;
    body += static_cast<char>(corners) + std::string(static_cast<std::size_t>(corners) * 4, '\0');
  }
  const std::string header =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "element face " +
      std::to_string(kFaces) + "\nproperty list uchar int vertex_indices\nend_header\n";
  EXPECT_EQ(readPlyMesh(folder_.write("a.ply", header + body), {}).parts.at(0).triangles.size(), 125000u);
  EXPECT_THAT(failure(header + body.substr(0, body.size() - 1)), HasSubstr("'face' 50000 of 50000"));
}

TEST_F(PlyDamage, SpellingsThatAreNoNumbersAreRefusedWithTheLine) {
  for (const std::string word : {"1,5", "1.0f", "1D3", "1'000", "0x1", "1.#QNAN"}) {
    const auto file =
        folder_.write("a.ply",
                      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                      "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 +0\n1 1 " +
                          word + "\n2 4 0\n3 0 1 2\n");
    EXPECT_THAT(messageOf([&] { readAsset(file, {}); }),
                HasSubstr("a.ply:11: z must be a number such as 1234.5 or -1.2e-3, not '" + word));
  }
}

}  // namespace
}  // namespace scanmill
