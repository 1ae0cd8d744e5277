#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "assets/asset_parts.h"
#include "assets/surveys/surveys.h"
#include "tests/core/assets/read_assets.h"
#include "tests/support/geo_tiff.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

double slope(double x, double y) {
  return 0.2 * (x - 500000) - 0.1 * (y - 5400000) + 300;
}

void expectOnSlope(const Asset& asset) {
  for (const Vec3f& p : asset.parts.at(0).positions) {
    const Vec3d at = asset.origin + Vec3d(p);
    EXPECT_NEAR(at.z, slope(at.x, at.y), 1e-3);
  }
}

// Heights of a plane in UTM coordinates: 30 x 20 samples of 5 m, the first of which is at [500002.5, 5400097.5].
GeoTiff tilted() {
  GeoTiff tiff{30, 20, {}, 500000, 5400100, 5};
  for (int row = 0; row < 20; ++row) {
    for (int column = 0; column < 30; ++column) {
      tiff.values.push_back(static_cast<float>(slope(500002.5 + 5 * column, 5400097.5 - 5 * row)));
    }
  }
  return tiff;
}

class Heights : public testing::Test {
 protected:
  Asset read(const GeoTiff& tiff, const AssetOptions& options = {}) const {
    return readAsset(folder_.write("dem.tif", tiff.bytes()), options);
  }
  std::string refused(const GeoTiff& tiff, const AssetOptions& options = {}) const {
    return messageOf([&] { read(tiff, options); });
  }
  TemporaryFolder folder_;
};

TEST_F(Heights, AreWhereTheRasterSaysToTheMillimetre) {
  const Asset asset = read(tilted());
  ASSERT_EQ(asset.parts.size(), 1u);
  EXPECT_EQ(asset.parts[0].positions.size(), 600u);
  EXPECT_EQ(trianglesOf(asset), 2u * 29 * 19);
  expectOnSlope(asset);
  const Box box = boundsOf(asset);
  EXPECT_NEAR(box.low.x, 500002.5, 1e-3);
  EXPECT_NEAR(box.high.y, 5400097.5, 1e-3);
  for (const Triangle& t : asset.parts[0].triangles) {
    const auto& p = asset.parts[0].positions;
    EXPECT_GT(cross(Vec3d(p[t[1]]) - Vec3d(p[t[0]]), Vec3d(p[t[2]]) - Vec3d(p[t[0]])).z, 0) << "facing up";
  }
}

// The mean of a plane's samples is the plane at their middle, so a coarser raster is the same surface.
TEST_F(Heights, MayBeTakenCoarserAndInPart) {
  AssetOptions options;
  options.heights.every = 4;
  const Asset coarse = read(tilted(), options);
  EXPECT_EQ(coarse.parts.at(0).positions.size(), 7u * 5);
  expectOnSlope(coarse);
  options.heights.every = 1;
  options.heights.within = {{500050, 5400000, 500100, 5400050}};
  const Asset part = read(tilted(), options);
  EXPECT_EQ(part.parts.at(0).positions.size(), 10u * 10);
  const Box box = boundsOf(part);
  EXPECT_NEAR(box.low.x, 500052.5, 1e-3);
  EXPECT_NEAR(box.high.y, 5400047.5, 1e-3);
  options.heights.within = {{0, 0, 10, 10}};
  EXPECT_THAT(refused(tilted(), options), AllOf(HasSubstr("no sample there"), HasSubstr("[500002.5, 5400002.5]")));
}

TEST_F(Heights, WithoutAValueAreHoles) {
  GeoTiff tiff = tilted();
  tiff.none = "-9999";
  tiff.values[5 * 30 + 7] = -9999;  // touches four cells
  tiff.values[0] = NAN;             // touches one
  EXPECT_EQ(trianglesOf(read(tiff)), 2u * (29 * 19 - 5));
}

// Edges of cliffs stay straight: the diagonal that is shorter is taken.
TEST_F(Heights, CellsAreCutAcrossTheShorterDiagonal) {
  const GeoTiff corner{2, 2, {0, 0, 0, 9}, 500000, 5400000, 1};
  const Asset asset = read(corner);
  const auto& p = asset.parts.at(0).positions;
  int flat = 0;
  for (const Triangle& t : asset.parts[0].triangles) {
    const auto high = std::count_if(t.begin(), t.end(), [&](std::uint32_t c) { return p[c].z > 4; });
    EXPECT_LE(high, 1);
    flat += p[t[0]].z == 0 && p[t[1]].z == 0 && p[t[2]].z == 0 ? 1 : 0;
  }
  EXPECT_EQ(flat, 1) << "one of the two lies level";
}

// Classes of another resolution, by where they lie; colours likewise.
TEST_F(Heights, HaveClassesAndColoursOfOtherRasters) {
  GeoTiff cover{3, 2, {10, 20, 30, 40, 50, 60}, 500000, 5400100, 50};
  GeoTiff photo{2, 1, {0, 255}, 500000, 5400100, 75};
  folder_.write("photo.tif", photo.bytes());
  AssetOptions options;
  options.heights.classes = folder_.write("cover.tif", cover.bytes());
  options.heights.image = folder_.path() / "photo.tif";
  const Asset asset = read(tilted(), options);
  ASSERT_EQ(asset.parts.size(), 6u);
  EXPECT_EQ(trianglesOf(asset), 2u * 29 * 19);
  for (const AssetPart& part : asset.parts) {
    const int number = std::stoi(part.material);
    ASSERT_TRUE(part.fileMaterial.texture);
    for (const Triangle& t : part.triangles) {
      Vec3d middle = asset.origin;
      Vec2f uv{0, 0};
      for (const std::uint32_t c : t) {
        middle = middle + Vec3d(part.positions[c]) * (1.0 / 3);
        uv = {uv.x + part.uvs[c].x / 3, uv.y + part.uvs[c].y / 3};
      }
      const int column = static_cast<int>((middle.x - 500000) / 50);
      const int row = static_cast<int>((5400100 - middle.y) / 50);
      const double offX = std::fabs(std::remainder(middle.x - 500000, 50));
      const double offY = std::fabs(std::remainder(5400100 - middle.y, 50));
      if (offX > 3 && offY > 3) {  // cells are taken at their middle
        EXPECT_EQ(number, 10 * (3 * row + column + 1));
      }
      if (std::fabs(middle.x - 500075) > 3) {
        EXPECT_EQ(part.fileMaterial.texture->texel(uv.x, uv.y)[0], middle.x > 500075 ? 255 : 0);
      }
    }
  }
  cover.epsg = 32632;
  options.heights.classes = folder_.write("other.tif", cover.bytes());
  EXPECT_THAT(refused(tilted(), options), AllOf(HasSubstr("other.tif"), HasSubstr("gdalwarp")));
}

// A degree of latitude is 111.2 km at 48 degrees, one of longitude 74.6 km; level ground bends away as the earth does.
TEST_F(Heights, OfLongitudeAndLatitudeLieAsOnTheEarth) {
  const GeoTiff flat{41, 41, std::vector<float>(41 * 41, 100.0f), 11, 48.5, 0.5 / 41, 4326};
  const Asset asset = read(flat);
  const Box box = boundsOf(asset);
  EXPECT_NEAR((box.high.y - box.low.y) / (0.5 * 40 / 41), 111200, 150);
  EXPECT_NEAR((box.high.x - box.low.x) / (0.5 * 40 / 41), 74400, 400);  // at the southern edge
  for (const Vec3f& p : asset.parts.at(0).positions) {
    const double d = std::hypot(p.x, p.y);
    EXPECT_NEAR(p.z, 100 - d * d / (2 * 6.378e6), 1) << d;
  }
}

TEST_F(Heights, AreObjectsOfAScene) {
  folder_.write("dem.tif", tilted().bytes());
  const Scene scene = sceneOf(
      folder_,
      "objects:\n  - {file: dem.tif, position: [-500000, -5400000, 0], heights: {every: 2}, rules: [{match: {box: "
      "[[500000, 5400000, 0], [500050, 5400100, 999]]}, class: road}, {match: {slope_deg: [10, 20]}, class: "
      "terrain}]}\n");
  ASSERT_EQ(scene.instances.size(), 1u);
  EXPECT_EQ(scene.instances[0].name, "dem");
  EXPECT_NEAR(scene.bounds().low.x, 5, 1e-3);
  std::map<std::uint16_t, int> count;
  const Mesh& mesh = scene.meshes[scene.instances[0].mesh];
  for (const std::uint16_t s : mesh.surfaceOf) ++count[mesh.surfaces[s].semantic];
  const std::uint16_t road = scene.ontology.require("road", {}).id;
  EXPECT_EQ(count.size(), 2u) << "road in the western third, terrain of 12.6 degrees elsewhere";
  EXPECT_NEAR(count[road], 2 * 9 * 4.5, 9);
}

TEST_F(Heights, MistakesAreNamed) {
  folder_.write("dem.tif", "no raster");
  EXPECT_THAT(messageOf([&] { readAsset(folder_.path() / "dem.tif", {}); }),
              AllOf(HasSubstr("dem.tif"), HasSubstr("no raster that can be read")));
  const std::string grid = "ncols 2\nnrows 2\nxllcorner 11\nyllcorner 48\ncellsize 0.1\nNODATA_value -9999\n";
  const auto asc = [&](const std::string& samples) {
    const auto file = folder_.write("g.asc", grid + samples);
    return messageOf([&] { readAsset(file, {}); });
  };
  EXPECT_EQ(asc("0.01 0.02\n0.03 1e-2\n"), "accepted");
  EXPECT_THAT(asc("0.01 0.02\n0.03 none\n"), AllOf(HasSubstr("g.asc:8"), HasSubstr("'none' is no number")));
  EXPECT_THAT(asc("1,5 2,5\n3 4\n"), AllOf(HasSubstr("g.asc:7"), HasSubstr("'1,5'")));
  EXPECT_THAT(asc("510 512\n530 521\n"), AllOf(HasSubstr("rises by 20 m within"), HasSubstr("EPSG:4326")));
  EXPECT_THAT(refused({1, 3, {1, 2, 3}, 0, 0, 1}), HasSubstr("at least two"));
  EXPECT_THAT(refused({2, 2, {NAN, 2, 3, 4}, 0, 0, 1}), HasSubstr("no cell whose four samples"));
  std::string unplaced = tilted().bytes();
  for (const std::uint16_t tag :
       {std::uint16_t{33550}, std::uint16_t{33922}}) {  // scale and tie point, under numbers that nobody knows
    const std::string bytes(reinterpret_cast<const char*>(&tag), 2);
    const std::size_t at = unplaced.rfind(bytes + std::string("\x0C\0", 2));
    ASSERT_NE(at, std::string::npos);
    const auto other = static_cast<std::uint16_t>(tag + 1);
    unplaced.replace(at, 2, reinterpret_cast<const char*>(&other), 2);
  }
  folder_.write("u.tif", unplaced);
  EXPECT_THAT(messageOf([&] { readAsset(folder_.path() / "u.tif", {}); }), HasSubstr("gdal_edit.py"));
  std::string cut = tilted().bytes();
  EXPECT_THAT(refused(tilted(), {.up = 'y'}), HasSubstr("leave out `up`"));
  // Whatever is damaged, it is read or refused.
  for (std::size_t i = 0; i < cut.size(); i += 7) {
    std::string damaged = cut;
    damaged[i] = static_cast<char>(~damaged[i]);
    folder_.write("d.tif", damaged);
    const std::string message = messageOf([&] { readAsset(folder_.path() / "d.tif", {}); });
    EXPECT_TRUE(message == "accepted" || message.find("d.tif") != std::string::npos) << i << ": " << message;
  }
}

}  // namespace
}  // namespace scanmill
