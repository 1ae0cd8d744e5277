#include "viewer/pass_picture.h"

#include <gtest/gtest.h>

#include <algorithm>

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
  return static_cast<std::size_t>(std::ranges::count(picture.pixels, color));
}

TEST(PassPicture, EveryPlaneIsThereAndHalfOfItIsEmpty) {
  const TemporaryFolder folder;
  writePasses(folder.path() / "front.exr", halfAWall());
  const Ontology ontology = walls();
  const Image picture = drawExr(folder.path() / "front.exr", &ontology, 600);
  EXPECT_EQ(picture.width, 600);
  // Five planes side by side: (600 - 6 * 8) / 5 = 110 columns and half as many rows each, of which 20 / 40 are seen.
  const std::size_t half = 55 * 55;
  EXPECT_NEAR(static_cast<double>(countOf(picture, {200, 30, 40})), half, 200);     // semantic
  EXPECT_NEAR(static_cast<double>(countOf(picture, instanceColor(3))), half, 200);  // instance
  EXPECT_NEAR(static_cast<double>(countOf(picture, Rgb{0, 128, 128})), half, 200);  // normal -x
  EXPECT_GT(countOf(picture, viridis(1)), half - 200);                              // reflectance
  EXPECT_EQ(countOf(picture, kBackground), 10 * half);                              // nothing seen, ten times
}

TEST(PassPicture, ReadsWhateverAnExrHolds) {
  const TemporaryFolder folder;
  const Ontology ontology = walls();
  Hits hits;
  hits.reset(4, 64, Channel::Semantic | Channel::Incidence);
  std::ranges::fill(hits.range, 5.0f);
  std::ranges::fill(hits.semantic, std::uint16_t{7});
  std::ranges::fill(hits.incidence, 0.5f);
  writeHits(folder.path() / "hits.exr", hits);
  const Image picture = drawExr(folder.path() / "hits.exr", &ontology, 600);
  EXPECT_EQ(picture.width, 600);
  EXPECT_GT(countOf(picture, {200, 30, 40}), 584u * 70);
  folder.write("no.exr", "not an image");
  expectInputError([&] { drawExr(folder.path() / "no.exr", nullptr, 600); }, {"no.exr"});
}

const PassPlane& planeOf(const std::vector<PassPlane>& planes, const std::string& name) {
  const auto found = std::ranges::find_if(planes, [&](const PassPlane& p) { return p.name == name; });
  if (found == planes.end()) throw Error("no plane " + name);
  return *found;
}

TEST(PassPicture, PlanesOfAnImageHaveColoursAndValues) {
  const TemporaryFolder folder;
  writePasses(folder.path() / "front.exr", halfAWall());
  std::vector<PassPlane> planes;
  {
    const Ontology ontology = walls();
    planes = readExrPlanes(folder.path() / "front.exr", &ontology);
  }
  std::filesystem::remove(folder.path() / "front.exr");  // values outlive the file and the ontology
  const std::pair<const char*, const char*> expected[] = {{"depth", "10.00 m"},     {"normal", "-1.000, 0.000, 0.000"},
                                                          {"semantic", "wall (7)"}, {"instance", "3"},
                                                          {"material", "0"},        {"primitive", "0"},
                                                          {"reflectance", "1"}};
  for (const auto& [name, value] : expected) {
    const PassPlane& plane = planeOf(planes, name);
    EXPECT_EQ(plane.image.width, 40);
    EXPECT_EQ(plane.image.height, 20);
    EXPECT_EQ(plane.value(19, 19), value);
    EXPECT_EQ(plane.value(20, 0), "nothing");
    EXPECT_EQ(plane.value(40, 0), "");
    EXPECT_EQ(plane.value(0, -1), "");
    EXPECT_EQ(plane.image.at(30, 10), kBackground);
  }
  EXPECT_EQ(planeOf(planes, "semantic").image.at(5, 5), (Rgb{200, 30, 40}));
  EXPECT_EQ(planeOf(planes, "instance").image.at(5, 5), instanceColor(3));
}

TEST(PassPicture, PlanesOfHitsHaveRingsAndColumns) {
  const TemporaryFolder folder;
  Hits hits;
  hits.reset(4, 64, Channel::Semantic | Channel::Instance | Channel::Incidence);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    hits.range[i] = 1.0f + static_cast<float>(i);
    hits.semantic[i] = static_cast<std::uint16_t>(i % 64);
    hits.instance[i] = 0;
    hits.incidence[i] = 0.5f;
  }
  hits.range[70] = hits.range[71] = kMiss;
  hits.unresolved = {71};
  writeHits(folder.path() / "hits.exr", hits);
  const std::vector<PassPlane> planes = readExrPlanes(folder.path() / "hits.exr", nullptr);
  const PassPlane& range = planeOf(planes, "range");
  EXPECT_EQ(range.image.width, 64);
  EXPECT_EQ(range.image.height, 4);
  EXPECT_EQ(range.value(5, 2), "134.00 m");
  EXPECT_EQ(range.value(6, 1), "nothing");
  EXPECT_EQ(range.value(7, 1), "unresolved");
  EXPECT_EQ(planeOf(planes, "semantic").value(9, 3), "class 9");
  EXPECT_EQ(planeOf(planes, "instance").value(9, 3), "none");
  EXPECT_EQ(planeOf(planes, "cosine of the incidence").value(9, 3), "0.5");
}

}  // namespace
}  // namespace scanmill
