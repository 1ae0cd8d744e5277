#include "viewer/pass_picture.h"

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

std::size_t pixelsOf(const Image& picture, const Rgb& color) {
  return static_cast<std::size_t>(std::ranges::count(picture.pixels, color));
}

TEST(PassPicture, EveryPlaneIsThereAndHalfOfItIsEmpty) {
  const TemporaryFolder folder;
  writePasses(folder.path() / "front.exr", halfAWall());
  const Image picture = drawExr({folder.path() / "front.exr", walls()}, "", 600);
  EXPECT_EQ(picture.width, 600);
  // Five planes side by side: (600 - 6 * 8) / 5 = 110 columns and half as many rows each, of which 20 / 40 are seen.
  const std::size_t half = 55 * 55;
  EXPECT_NEAR(static_cast<double>(pixelsOf(picture, {200, 30, 40})), half, 200);     // semantic
  EXPECT_NEAR(static_cast<double>(pixelsOf(picture, instanceColor(3))), half, 200);  // instance
  EXPECT_NEAR(static_cast<double>(pixelsOf(picture, Rgb{0, 128, 128})), half, 200);  // normal -x
  EXPECT_GT(pixelsOf(picture, viridis(1)), half - 200);                              // reflectance
  EXPECT_EQ(pixelsOf(picture, kBackground), 10 * half);                              // nothing seen, ten times
}

TEST(PassPicture, OnePlaneHasItsLegend) {
  const TemporaryFolder folder;
  writePasses(folder.path() / "front.exr", halfAWall());
  const ExrSource source{folder.path() / "front.exr", walls()};
  const Image picture = drawExr(source, "semantic", 600);
  const std::size_t half = 292 * 292;  // (600 - 2 * 8) / 2 columns and as many rows
  EXPECT_GT(pixelsOf(picture, {200, 30, 40}), half + 100) << "a sample of the colour is in the legend";
  EXPECT_EQ(pixelsOf(picture, instanceColor(3)), 0u);
  expectInputError([&] { drawExr(source, "colour", 600); }, {"front.exr", "colour", "depth, normal, semantic"});
}

TEST(PassPicture, ReadsHitsToo) {
  const TemporaryFolder folder;
  Hits hits;
  hits.reset(4, 64, Channel::Semantic | Channel::Incidence);
  std::ranges::fill(hits.range, 5.0f);
  std::ranges::fill(hits.semantic, std::uint16_t{7});
  std::ranges::fill(hits.incidence, 0.5f);
  writeHits(folder.path() / "hits.exr", hits);
  const Image picture = drawExr({folder.path() / "hits.exr", walls()}, "", 600);
  EXPECT_EQ(picture.width, 600);
  EXPECT_GT(pixelsOf(picture, {200, 30, 40}), 584u * 70);
  folder.write("no.exr", "not an image");
  expectInputError([&] { drawExr({folder.path() / "no.exr"}, "", 600); }, {"no.exr"});
}

TEST(PassPicture, ImagesOfARecordingAreFoundByNameOrNumber) {
  const TemporaryFolder folder;
  for (const char* name : {"top.9.exr", "top.10.exr", "top.1.exr", "side.exr"}) folder.write(name, "");
  const auto found = [&](const std::string& wanted) { return findExr(folder.path(), wanted).file.filename(); };
  EXPECT_EQ(found(""), "side.exr");
  EXPECT_EQ(found("top.1"), "top.1.exr");
  EXPECT_EQ(found("10"), "top.10.exr");
  EXPECT_EQ(found("2"), "top.9.exr") << "after top.1";
  expectInputError([&] { found("nowhere"); }, {"4 images", "nowhere", "side", "top.10"});
}

}  // namespace
}  // namespace scanmill
