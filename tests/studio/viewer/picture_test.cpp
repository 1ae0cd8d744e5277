#include "viewer/picture.h"

#include "dataset/scan_store.h"
#include "methods/method.h"
#include "passes/exr/hits_exr.h"
#include "passes/exr/pass_exr.h"
#include "tests/support/message_of.h"
#include "tests/support/shared_data.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scene.h"
#include "viewer/color_map.h"
#include "viewer/panels/panel_rects.h"
#include "viewer/panels/widgets.h"

namespace scanmill {
namespace {

// A ring of ground and a wall ahead.
Scan smallScan() {
  Scan scan;
  scan.rings = 8;
  scan.columns = 90;
  for (std::uint16_t ring = 0; ring < 8; ++ring) {
    for (std::uint16_t column = 0; column < 90; ++column) {
      const double azimuth = 2 * kPi * column / 90;
      const double range = 14 - ring;
      scan.position.push_back(static_cast<Vec3f>(
          Vec3d{range * std::cos(azimuth), range * std::sin(azimuth), column < 10 ? 3 - 0.5 * ring : -1.8}));
      scan[kLabel].push_back(column < 10 ? 2 : 1);
      scan[kIntensity].push_back(static_cast<float>(ring * 10));
      scan[kRing].push_back(ring);
      scan[kColumn].push_back(column);
    }
  }
  return scan;
}

Ontology colorful() {
  Ontology ontology = testOntology();
  ontology.classes[1].color = {255, 0, 0};
  ontology.classes[2].color = {0, 255, 0};
  ontology.classes[3].color = {255, 255, 0};
  return ontology;
}

Image drawn(const Scan& scan, const std::optional<ColorBy>& by = {}, const Ontology* ontology = nullptr,
            int width = 480, int height = 270) {
  return drawScan(scan, colorScan(scan, by, {ontology}), width, height, "a scan");
}

std::ptrdiff_t count(const Image& image, const Rgb& color) {
  return std::ranges::count(image.pixels, color);
}

std::ptrdiff_t bright(const Image& image, int top, int bottom) {
  return std::count_if(image.pixels.begin() + std::ptrdiff_t{top} * image.width,
                       image.pixels.begin() + std::ptrdiff_t{bottom} * image.width,
                       [](const Rgb& p) { return p[0] > 150 && p[1] > 150 && p[2] > 150; });
}

TEST(Picture, ShowsTheClassesThatAreThere) {
  const Ontology ontology = colorful();
  for (const auto& [width, height] : {std::pair{64, 64}, std::pair{480, 270}, std::pair{300, 700}}) {
    const Image image = drawn(smallScan(), {}, &ontology, width, height);
    EXPECT_EQ(image.width, width);
    EXPECT_EQ(image.height, height);
    EXPECT_GT(count(image, {255, 0, 0}), 20);
    EXPECT_GT(count(image, {0, 255, 0}), 10);
    EXPECT_EQ(count(image, {255, 255, 0}), 0) << "no point has this class";
    EXPECT_EQ(image.pixels, drawn(smallScan(), {}, &ontology, width, height).pixels);
  }
  EXPECT_EQ(count(drawn(smallScan(), kByIntensity, &ontology), {255, 0, 0}), 0);
}

TEST(Picture, EmptyScanSaysSo) {
  Scan misses;
  misses.organised = true;
  misses.rings = 2;
  misses.columns = 3;
  misses.position.assign(6, {NAN, NAN, NAN});
  EXPECT_GT(bright(drawn({}, kByClass), 100, 180), 50) << "words in the middle";
  EXPECT_GT(bright(drawn(misses), 100, 180), 50);
  EXPECT_NO_THROW(drawRangeImage({}, nullptr, {}, "nothing"));
}

// The range image is its strip (range_strip_test.cpp), enlarged.
TEST(RangeImage, HasAPixelPerBeam) {
  const Ontology ontology = colorful();
  const Scan scan = smallScan();
  const Image image = drawRangeImage(scan, &ontology, ColorBy("class"), "a scan");
  const int stepX = 18;  // the least that gives 1600 pixels
  const double lineHeight = pictureLineHeight(stepX * 90, stepX * 90);
  ASSERT_EQ(image.width, stepX * 90 + sideWidth(lineHeight));
  const int top = static_cast<int>(std::lround(1.5 * lineHeight));  // below the title
  int bodyHeight = 0;
  while (top + bodyHeight < image.height && image.at(stepX * 70, top + bodyHeight) == Rgb{255, 0, 0}) ++bodyHeight;
  const int stepY = bodyHeight / 8;
  ASSERT_EQ(bodyHeight, stepY * 8);
  const RangeStrip strip = makeRangeStrip(scan, std::vector<Rgb>(scan.size()), {});
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const Rgb expected = scan[kColumn][i] < 10 ? Rgb{0, 255, 0} : Rgb{255, 0, 0};
    const auto [column, row] = strip.pixelPosition(i);
    EXPECT_EQ(image.at(column * stepX, top + row * stepY), expected);
    EXPECT_EQ(image.at(column * stepX + stepX - 1, top + row * stepY + stepY - 1), expected);
  }
}

TEST(RangeImage, HasTheWholeLegend) {
  Ontology ontology = testOntology();
  ontology.classes.clear();
  Scan scan;
  for (std::uint16_t id = 0; id < 29; ++id) {
    ontology.classes.push_back({id, "class_" + std::to_string(id), instanceColor(id + 1u), false, {}});
    scan.position.push_back({5, 1, 0});  // all in one pixel
    scan[kLabel].push_back(id);
    scan[kRing].push_back(0);
    scan[kColumn].push_back(0);
  }
  scan[kColumn].back() = 1599;
  const Image image = drawRangeImage(scan, &ontology, kByClass, "a scan");
  for (const SemanticClass& c : ontology.classes) EXPECT_GT(count(image, c.color), 50) << c.name;
  const PixelRect widest =
      legendRect(colorScan(scan, kByClass, {&ontology}).legend, {0, 9, kMostPictureSide, 90}, 20, kMostPictureSide);
  EXPECT_EQ(widest.left, 0) << "there is no room beside it";
  EXPECT_EQ(widest.top, 99);
}

// sRGB (IEC 61966-2-1) as linear light.
std::array<double, 3> linear(const Rgb& color) {
  std::array<double, 3> light{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double v = color[c] / 255.0;
    light[c] = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  }
  return light;
}

// Light without hue, from 0 to 1.
double luminance(const std::array<double, 3>& light) {
  return 0.2126 * light[0] + 0.7152 * light[1] + 0.0722 * light[2];
}

// L* of CIE 1976, 0 to 100; right above a luminance of 0.9 %.
double lightness(const std::array<double, 3>& light) {
  return 116 * std::cbrt(luminance(light)) - 16;
}

// Full protanopia and deuteranopia, by Machado, Oliveira and Fernandes, "A physiologically-based model for simulation
// of color vision deficiency", IEEE TVCG 15(6), 2009.
constexpr std::array<std::array<std::array<double, 3>, 3>, 2> kColorBlind{
    {{{{0.152286, 1.052583, -0.204868}, {0.114503, 0.786281, 0.099216}, {-0.003882, -0.048116, 1.051998}}},
     {{{0.367322, 0.860646, -0.227968}, {0.280085, 0.672501, 0.047413}, {-0.011820, 0.042940, 0.968881}}}}};

std::array<double, 3> seenBy(const std::array<std::array<double, 3>, 3>& eye, const std::array<double, 3>& light) {
  std::array<double, 3> seen{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t c = 0; c < 3; ++c) seen[row] += eye[row][c] * light[c];
    seen[row] = std::clamp(seen[row], 0.0, 1.0);
  }
  return seen;
}

// Each of the first three is a step lighter than the one before to any eye, and stands out from the background (WCAG
// 2.1, 1.4.11: graphics by a ratio of 3).
TEST(Picture, FirstOverlayColoursDifferInLightness) {
  const auto background = luminance(linear(kBackground));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_GE((luminance(linear(overlayColor(i))) + 0.05) / (background + 0.05), 3) << i;
    if (i == 0) continue;
    EXPECT_GE(lightness(linear(overlayColor(i))) - lightness(linear(overlayColor(i - 1))), 10) << i;
    for (const auto& eye : kColorBlind) {
      EXPECT_GE(lightness(seenBy(eye, linear(overlayColor(i)))) - lightness(seenBy(eye, linear(overlayColor(i - 1)))),
                7)
          << i;
    }
  }
  EXPECT_EQ(overlayColor(methods().size() + 7), overlayColor(0)) << "after the last comes the first";
}

// A frame of a real OS-1-128: organised, intensity but no classes.
TEST(RealScan, IsDrawn) {
  SKIP_WITHOUT_SHARED_DATA("lidar/ouster_os1_128/frame_1795.pcd");
  const ScanSource source = findScan(sharedData() / "lidar/ouster_os1_128/frame_1795.pcd", "", "");
  EXPECT_FALSE(source.ontology);
  const Image image = drawn(source.scan);
  EXPECT_LT(count(image, image.at(240, 30)), 480 * 270 * 9 / 10);
  EXPECT_GE(drawRangeImage(source.scan, nullptr, {}, source.title).width, 2048);
}

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
  const std::size_t half = 142 * 142;  // (600 - 300 - 2 * 8) / 2 columns and as many rows
  EXPECT_GT(pixelsOf(picture, {200, 30, 40}), half + 100) << "a sample of the colour is in the legend";
  EXPECT_EQ(pixelsOf(picture, instanceColor(3)), 0u);
  const Image small = drawExr(source, "semantic", 200);
  EXPECT_EQ(small.width, 200);
  EXPECT_GT(small.height, 200) << "the legend is below the plane";
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
  EXPECT_EQ(found(""), "top.9.exr") << "the middle one, in the order side, top.1, top.9, top.10";
  EXPECT_EQ(found("top.1"), "top.1.exr");
  EXPECT_EQ(found("10"), "top.10.exr");
  EXPECT_EQ(found("2"), "top.9.exr") << "after top.1";
  expectInputError([&] { found("nowhere"); }, {"nowhere", "side", "top.10"});
}

}  // namespace
}  // namespace scanmill
