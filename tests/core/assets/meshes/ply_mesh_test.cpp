#include "assets/meshes/ply_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "assets/asset.h"
#include "base/error.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

template <class T>
std::string bytesOfValue(T value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

// A fan of triangles around the z axis, little-endian, of which each test changes what it is about.
struct Fan {
  std::string comment = "none";
  std::string vertexProperties = "property float x\nproperty float y\nproperty float z\nproperty uchar red\n";
  std::string faceProperties = "property list uchar int vertex_indices\nproperty short mark\n";
  bool exact = false;  // x, y and z in double
  double east = 0;     // m, added to x
  int lastCorner = 2;  // of the last triangle
  unsigned char corners = 3;
  std::string between = {};  // an element between vertices and faces

  static constexpr int kTriangles = 40;

  std::string header() const {
    return "ply\nformat binary_little_endian 1.0\ncomment " + comment + "\nelement vertex " +
           std::to_string(kTriangles + 1) + "\n" + vertexProperties + between + "element face " +
           std::to_string(kTriangles) + "\n" + faceProperties + "end_header\n";
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
      out += static_cast<char>(corners);
      for (const int corner : {0, 1 + i, i + 1 < kTriangles ? 2 + i : lastCorner}) out += bytesOfValue(corner);
      out += bytesOfValue(std::int16_t{7});
    }
    return out;
  }

  std::string text() const { return header() + body(); }
};

class PlyMesh : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& text) const { return folder_.write("a.ply", text); }
  bool isRead(const std::string& text) const { return readPlyMesh(write(text), {}).has_value(); }

  TemporaryFolder folder_;
};

const std::string kDoubles = "property double x\nproperty double y\nproperty double z\nproperty uchar red\n";

// Another element is enough for the file to be the importer's.
const std::string kOther = "element empty 0\nproperty uchar nothing\n";

TEST_F(PlyMesh, GivesWhatTheImporterGives) {
  for (const bool outOfRange : {false, true}) {
    for (const char up : {'x', 'y', 'z'}) {
      Fan fan;
      fan.lastCorner = outOfRange ? 41 : 2;
      const AssetOptions options{.metresPerUnit = 0.37, .up = up};
      ASSERT_TRUE(readPlyMesh(write(fan.text()), options).has_value());
      const Asset own = readAsset(write(fan.text()), options);
      fan.between = kOther;
      ASSERT_FALSE(readPlyMesh(write(fan.text()), options).has_value());
      const Asset other = readAsset(write(fan.text()), options);
      ASSERT_EQ(own.parts.size(), 1u);
      ASSERT_EQ(other.parts.size(), 1u);
      const AssetPart& a = own.parts.front();
      const AssetPart& b = other.parts.front();
      EXPECT_EQ(a.positions, b.positions);
      EXPECT_EQ(a.triangles, b.triangles);
      EXPECT_EQ(a.uvs, b.uvs);
      EXPECT_EQ(a.node, b.node);
      EXPECT_EQ(a.material, b.material);
      EXPECT_EQ(a.texture, b.texture);
      EXPECT_EQ(a.color, b.color);
      EXPECT_EQ(a.fileMaterial.name, b.fileMaterial.name);
      EXPECT_EQ(a.fileMaterial.reflectance, b.fileMaterial.reflectance);
      EXPECT_EQ(a.fileMaterial.roughness, b.fileMaterial.roughness);
      EXPECT_EQ(own.up, other.up);
      EXPECT_EQ(own.upDeclared, other.upDeclared);
      EXPECT_EQ(own.dropped.outOfRange, other.dropped.outOfRange);
      EXPECT_EQ(own.dropped.outOfRange, outOfRange ? 1u : 0u);
    }
  }
}

TEST_F(PlyMesh, LargeCoordinatesInDoubleLoseNothing) {
  Fan near;
  near.exact = true;
  near.vertexProperties = kDoubles;
  Fan far = near;
  far.east = 4'500'000;
  const auto here = readPlyMesh(write(near.text()), {});
  const auto there = readPlyMesh(write(far.text()), {});
  ASSERT_TRUE(here && there);
  EXPECT_EQ(here->origin, Vec3d());
  EXPECT_NEAR(there->origin.x, 4'500'000, 10);
  EXPECT_EQ(there->origin.y, 0);
  for (std::size_t i = 0; i < here->parts[0].positions.size(); ++i) {
    const Vec3d moved = Vec3d(there->parts[0].positions[i]) + there->origin - Vec3d{far.east, 0, 0};
    EXPECT_LT(length(Vec3d(here->parts[0].positions[i]) - moved), 1e-6) << i;
  }
  EXPECT_EQ(readAsset(write(far.text()), {}).origin, there->origin);
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
    ASSERT_TRUE(read);
    const Vec3d second = Vec3d(read->parts[0].positions[1]) + read->origin - Vec3d{fan.east, 0, 0};
    EXPECT_LT(length(second - Vec3d{3 * std::cos(0.1), 3 * std::sin(0.1), 0.01}), 1e-6) << stray;
  }
}

TEST_F(PlyMesh, CoarseCoordinatesAreWarnedOf) {
  Fan fan;
  fan.between = kOther;
  readAsset(write(fan.text()), {});
  testing::internal::CaptureStderr();
  readAsset(write(fan.text()), {});
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  fan.east = 4'500'000;
  testing::internal::CaptureStderr();
  readAsset(write(fan.text()), {});
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              testing::HasSubstr("its coordinates reach 4500003 m, where single precision, in which this kind of file "
                                 "is read, has steps of 0.5 m"));
}

TEST_F(PlyMesh, WhatHasNoPlaceIsKept) {
  Fan fan;
  std::string body = fan.body();
  const float nowhere = std::numeric_limits<float>::quiet_NaN();
  body.replace(0, 4, bytesOfValue(nowhere));
  const auto read = readPlyMesh(write(fan.header() + body), {});
  ASSERT_TRUE(read);
  EXPECT_TRUE(std::isnan(read->parts[0].positions[0].x));
  EXPECT_EQ(read->parts[0].triangles.size(), std::size_t{Fan::kTriangles});
}

TEST_F(PlyMesh, OtherFilesAreLeftToTheImporter) {
  const std::string plain = Fan().text();
  ASSERT_TRUE(isRead(plain));
  for (std::size_t size = Fan().header().size(); size < plain.size(); size += 7) {
    EXPECT_FALSE(isRead(plain.substr(0, size))) << size;
  }
  EXPECT_FALSE(isRead(Fan{.comment = "TextureFile wall.png"}.text()));
  EXPECT_FALSE(isRead(Fan{.corners = 4}.text()));
  EXPECT_FALSE(isRead(Fan{.between = kOther}.text()));
  EXPECT_FALSE(isRead(
      Fan{.faceProperties = "property list uchar int vertex_indices\nproperty list uchar float texcoord\n"}.text()));
  for (const char* properties :
       {"property float x\nproperty float y\nproperty float z\nproperty uchar s\n",
        "property float x\nproperty float y\nproperty float height\nproperty uchar red\n",
        "property int x\nproperty float y\nproperty float z\nproperty uchar red\n",
        "property float x\nproperty float y\nproperty float z\nproperty list uchar uchar red\n"}) {
    EXPECT_FALSE(isRead(Fan{.vertexProperties = properties}.text())) << properties;
  }
  EXPECT_THROW(readPlyMesh(write("ply\nelement"), {}), InputError);
}

}  // namespace
}  // namespace scanmill
