#include "assets/worlds/solids.h"
#include "tests/support/geo_tiff.h"
#include "world_files.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

class Heightmaps : public WorldFiles {
 protected:
  // Writes a grey image of 16 bits (portable graymap), row by row from the top.
  void image(const std::string& name, int width, const std::vector<int>& values) const {
    std::string bytes =
        "P5\n" + std::to_string(width) + " " + std::to_string(static_cast<int>(values.size()) / width) + "\n65535\n";
    for (const int v : values) bytes += {static_cast<char>(v >> 8), static_cast<char>(v & 255)};
    folder_.write(name, bytes);
  }
  static std::string map(const std::string& file, const std::string& more) {
    return model("<heightmap><uri>" + file + "</uri>" + more + "</heightmap>");
  }
  // Returns the height of a vertex near x, y.
  static double heightAt(const Asset& asset, double x, double y) {
    for (const Vec3f& p : asset.parts.at(0).positions) {
      if (std::hypot(double{p.x} - x, double{p.y} - y) < 1e-4) return double{p.z};
    }
    ADD_FAILURE() << "no vertex at " << x << ", " << y;
    return 0;
  }
};

// The first row of the image is at the greatest y, and its greatest value has the full height.
TEST_F(Heightmaps, AreCentredAndRiseToTheirSize) {
  image("t.pgm", 3, {0, 0, 40000, 0, 0, 0, 10000, 0, 0});
  const Asset asset = sdf(map("t.pgm", "<size>20 10 8</size><pos>100 0 5</pos>"));
  EXPECT_EQ(boundsOf(asset).low, (Vec3d{90, -5, 5}));
  EXPECT_EQ(boundsOf(asset).high, (Vec3d{110, 5, 13}));
  EXPECT_NEAR(heightAt(asset, 110, 5), 13, 1e-5);
  EXPECT_NEAR(heightAt(asset, 90, -5), 7, 1e-5);
  EXPECT_EQ(asset.parts[0].triangles.size(), 8u);
  for (const Triangle& t : asset.parts[0].triangles) {
    const auto corner = [&](int i) { return Vec3d(asset.parts[0].positions[t[i]]); };
    EXPECT_GT(cross(corner(1) - corner(0), corner(2) - corner(0)).z, 0) << "faces up";
  }
  // Without a size it is a metre long and high.
  EXPECT_EQ(boundsOf(sdf(map("t.pgm", ""))).high, (Vec3d{0.5, 0.5, 1}));
}

TEST_F(Heightmaps, OfElevationModelsHaveTheSizeOfTheModel) {
  GeoTiff tiff{4, 3, {}, 500000, 5400100, 5};
  for (int i = 0; i < 12; ++i) tiff.values.push_back(static_cast<float>(300 + i));
  folder_.write("dem.tif", tiff.bytes());
  const Asset own = sdf(map("dem.tif", ""));
  EXPECT_EQ(boundsOf(own).low, (Vec3d{-10, -7.5, 0}));
  EXPECT_EQ(boundsOf(own).high, (Vec3d{10, 7.5, 11}));
  EXPECT_EQ(boundsOf(sdf(map("dem.tif", "<size>2 2 1</size>"))).high, (Vec3d{1, 1, 1}));
}

TEST_F(Heightmaps, MistakesAreNamed) {
  image("t.pgm", 2, {0, 1, 2, 3});
  image("row.pgm", 3, {0, 1, 2});
  folder_.write("text.png", "no image");
  expectRefusals([&](const std::string& inside) { return refusal(inside); },
                 {{map("gone.png", ""), "a.sdf:3 | gone.png"},
                  {map("row.pgm", ""), "a.sdf:3 | two rows"},
                  {map("t.pgm", "<size>1 1 -1</size>"), "above 0"},
                  {map("text.png", ""), "text.png"},
                  {model("<heightmap/>"), "has no <uri>"}});
  // Gazebo's own images are told, and the rest of the world is read.
  const std::string terrain = world(map("file://media/materials/textures/terrain.png", "") + wing("n"));
  EXPECT_THAT(printedBy([&] { EXPECT_EQ(sdf(terrain).parts.size(), 1u); }), HasSubstr("1 heightmaps of Gazebo's own"));
}

}  // namespace
}  // namespace scanmill
