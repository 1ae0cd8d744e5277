#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "assets/asset.h"
#include "assets/meshes/imported_file.h"
#include "base/error.h"
#include "tests/core/assets/read_assets.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// A tetrahedron, with a quality after each list and an element after the faces.
struct Ply {
  std::string format = "binary_little_endian";
  std::string newline = "\n";
  std::string countType = "uchar";
  std::vector<int> lengths{3, 3, 3, 3};  // as written; each list has three indices all the same
  std::string numbers = "float";         // type of the coordinates
  double east = 0;                       // m, added to x
  double stray = 0;                      // m, added to all coordinates of the first vertex

  std::string header() const {
    std::string text;
    for (const std::string& line :
         {std::string("ply"), "format " + format + " 1.0", std::string("comment of no use"),
          std::string("element vertex 4"), "property " + numbers + " x", "property " + numbers + " y",
          "property " + numbers + " z", std::string("element face 4"),
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

  std::string number(const std::string& type, double value) const {
    if (type == "float") return bytes(static_cast<float>(value));
    if (type == "double") return bytes(value);
    if (type == "char" || type == "uchar") return bytes(static_cast<std::int8_t>(value));
    if (type == "short" || type == "ushort") return bytes(static_cast<std::int16_t>(value));
    return bytes(static_cast<int>(value));
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
    for (int i = 0; i < 4; ++i) {
      const double off = i == 0 ? stray : 0;
      for (const double p : {east + off + (i == 1), off + (i == 2), off + (i == 3)}) out += number(numbers, p);
    }
    for (std::size_t i = 0; i < 4; ++i) {
      out += number(countType, lengths[i]);
      for (const int index : kFaces[i]) out += bytes(index);
      out += bytes(0.25);
    }
    return out + bytes(std::int16_t{-7});
  }

  std::string text() const { return header() + body(); }
};

class PlyMesh : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& text) const { return folder_.write("a.ply", text); }
  std::string failure(const std::string& text) const {
    return messageOf([&] { readPlyMesh(write(text), {}); });
  }

  TemporaryFolder folder_;
};

TEST_F(PlyMesh, LargeCoordinatesInDoubleLoseNothing) {
  for (const double stray : {0.0, -1e300, std::numeric_limits<double>::infinity()}) {
    const auto file = write(Ply{.numbers = "double", .east = 4'500'000.125, .stray = stray}.text());
    const ImportedFile read = readPlyMesh(file, {});
    EXPECT_NEAR(read.origin.x, 4'500'000, 2) << "whatever one vertex says";
    EXPECT_EQ(readAsset(file, {}).origin, read.origin);
    EXPECT_EQ(Vec3d(read.parts.at(0).positions.at(1)) + read.origin, (Vec3d{4'500'001.125, 0, 0}));
    EXPECT_EQ(isFinite(read.parts[0].positions[0]), stray == 0) << "vertices without a place are kept";
  }
}

TEST_F(PlyMesh, CoarseCoordinatesAreWarnedOf) {
  const auto told = [&](double east) { return printedBy([&] { readAsset(write(Ply{.east = east}.text()), {}); }); };
  EXPECT_EQ(told(0), "");
  EXPECT_THAT(told(4'500'000), HasSubstr("its coordinates reach 4500001 m, where single precision, in which this kind "
                                         "of file is read, has steps of 0.5 m"));
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

TEST_F(PlyMesh, WhatNoSurfaceIsMadeFromIsTold) {
  const std::string text = squareHead("", "property uchar red\nproperty uchar green\nproperty int label\n",
                                      "property uchar red\nproperty int object_id\nproperty int material_index\n") +
                           "element edge 1\nproperty int vertex1\nend_header\n0 0 0 1 1 1\n1 0 0 1 1 1\n1 1 0 1 1 1\n"
                           "0 1 0 1 1 1\n3 0 1 2 1 1 1\n2 0 1 1 1 1\n5\n";
  EXPECT_THAT(
      printedBy([&] { readAsset(write(text), {}); }),
      HasSubstr("left out: 2 colours of faces, 4 colours of vertices, 2 columns of labels or instances (without "
                "its faces, as a cloud, the file keeps them), 1 elements 'edge', 1 faces of fewer than three "
                "corners, 1 materials of faces (material_index)\n"));
}

TEST_F(PlyMesh, WholeFilesAreRead) {
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    for (const char* newline : {"\n", "\r\n"}) {
      for (const char* type : {"char", "uchar", "short", "ushort", "int", "uint", "float", "double"}) {
        const std::string text = Ply{.format = format, .newline = newline, .countType = type}.text();
        EXPECT_EQ(trianglesOf(readAsset(write(text), {})), 4u) << text;
      }
    }
  }
}

TEST_F(PlyMesh, WhatNoFaceUsesIsCounted) {
  for (const char* format : {"ascii", "binary_little_endian"}) {
    const Ply ply{.format = format};
    const auto told = [&](const std::string& bytes) { return readPlyMesh(write(bytes), {}).leftOut.text(); };
    const std::string whole = ply.text();
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

TEST_F(PlyMesh, EveryCutIsRefused) {
  for (const Ply& ply : {Ply{}, Ply{.format = "binary_big_endian", .countType = "int"}}) {
    const std::string whole = ply.text();
    for (std::size_t size = 0; size < whole.size(); size += size < ply.header().size() - 10 ? 10 : 1) {
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

TEST_F(PlyMesh, EveryMissingWordIsRefused) {
  for (const char* newline : {"\n", "\r\n"}) {
    const Ply ply{.format = "ascii", .newline = newline};
    const std::string body = ply.body();
    EXPECT_EQ(failure(ply.header() + body.substr(0, body.size() - ply.newline.size())), "accepted");
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

TEST_F(PlyMesh, ListsThatAreTooLongAreRefused) {
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    Ply ply{.format = format, .countType = "int"};
    for (const int length : {1 << 30, 2000, -3}) {
      ply.lengths[1] = length;
      EXPECT_THAT(failure(ply.header() + ply.body()), HasSubstr("'face' 2 of 4")) << format << " " << length;
    }
  }
}

TEST_F(PlyMesh, WhatSurfacesNeedIsRequired) {
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = Ply{.format = "ascii"}.text();
    return text.replace(text.find(from), from.size(), to);
  };
  std::vector<std::pair<std::string, std::string>> table{
      {with("float z", "float height"), "its vertices have no property z"},
      {with("element face 4", "element tristrips 4"), "export it with faces"},
      {with("element end 1", "element vertex 1\nproperty int x\nproperty int y\nproperty int z"),
       "has two elements 'vertex'"},
      {with("vertex_indices", "corners"), "its faces have no list vertex_indices"},
      {with("element vertex 4", "element vertex 0"), "no vertices before its faces"}};
  for (const std::string word : {"1,5", "1.0f", "1D3", "1'000", "0x1", "1.#QNAN"}) {
    table.emplace_back(with("1 0 0", word + " 0 0"),
                       "a.ply:15: x must be a number such as 1234.5 or -1.2e-3, not '" + word);
  }
  expectRefusals([&](const std::string& text) { return failure(text); }, table);
}

}  // namespace
}  // namespace scanmill
