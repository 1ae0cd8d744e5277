#include "viewer/pass_picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "passes/exr/hits_exr.h"
#include "passes/exr/pass_exr.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"
#include "viewer/color_map.h"

namespace scanmill {
namespace {

// The left half sees a wall of class 7 and instance 3, ten metres away; the right half sees nothing.
PassImage halfAWall() {
  PassImage image;
  image.camera = squareCamera(40, 20, radians(90));
  image.camera.name = "front";
  image.camera.worldFromCamera.rotation = vehicleFromOptical();  // it looks along x
  image.planes.reset(image.camera.pixels(), {Channels::all(), true});
  for (std::size_t i = 0; i < image.planes.size(); ++i) {
    const bool seen = i % 40 < 20;
    image.planes.depth[i] = seen ? 10.0f : kNoDepth;
    image.planes.normal[i] = seen ? Vec3f{-1, 0, 0} : Vec3f{};
    image.planes.instance[i] = seen ? 3 : 0;
    image.planes.semantic[i] = seen ? 7 : 0;
    image.planes.material[i] = 0;
    image.planes.primitive[i] = 0;
    image.planes.reflectance[i] = seen ? 1 : 0;
    image.planes.roughness[i] = image.planes.metallic[i] = image.planes.retroreflectance[i] = 0;
  }
  return image;
}

Ontology walls() {
  Ontology ontology;
  ontology.classes = {{0, "unlabeled", {0, 0, 0}, false, {}}, {7, "wall", {200, 30, 40}, false, {}}};
  return ontology;
}

std::size_t countOf(const Image& picture, const Rgb& color) {
  return static_cast<std::size_t>(std::count(picture.pixels.begin(), picture.pixels.end(), color));
}

TEST(PassPicture, EveryPlaneIsThereAndHalfOfItIsEmpty) {
  const Ontology ontology = walls();
  const Image picture = drawPasses(halfAWall(), &ontology, 600, "front");
  EXPECT_EQ(picture.width, 600);
  // Five planes side by side: (600 - 6 * 8) / 5 = 110 columns and half as many rows each, of which 20 / 40 are seen.
  const std::size_t half = 55 * 55;
  EXPECT_NEAR(static_cast<double>(countOf(picture, {200, 30, 40})), half, 200);     // semantic
  EXPECT_NEAR(static_cast<double>(countOf(picture, instanceColor(3))), half, 200);  // instance
  EXPECT_NEAR(static_cast<double>(countOf(picture, Rgb{0, 128, 128})), half, 200);  // normal -x
  EXPECT_GT(countOf(picture, viridis(1)), half - 200);                              // reflectance
  EXPECT_GT(countOf(picture, kBackground), 10 * half);                              // nothing seen, ten times
}

TEST(PassPicture, ReadsWhateverAnExrHolds) {
  const TemporaryFolder folder;
  const PassImage image = halfAWall();
  writePasses(folder.path() / "front.exr", image);
  const Ontology ontology = walls();
  EXPECT_EQ(drawExr(folder.path() / "front.exr", &ontology, 600).pixels,
            drawPasses(image, &ontology, 600, "front.exr").pixels);
  Hits hits;
  hits.reset(4, 64, Channel::Semantic | Channel::Incidence);
  std::fill(hits.range.begin(), hits.range.end(), 5.0f);
  std::fill(hits.semantic.begin(), hits.semantic.end(), std::uint16_t{7});
  std::fill(hits.incidence.begin(), hits.incidence.end(), 0.5f);
  writeHits(folder.path() / "hits.exr", hits);
  const Image picture = drawExr(folder.path() / "hits.exr", &ontology, 600);
  EXPECT_EQ(picture.pixels, drawHits(hits, &ontology, 600, "hits.exr").pixels);
  EXPECT_GT(countOf(picture, {200, 30, 40}), 584u * 70);
  folder.write("no.exr", "not an image");
  expectInputError([&] { drawExr(folder.path() / "no.exr", nullptr, 600); }, {"no.exr"});
}

}  // namespace
}  // namespace scanmill
