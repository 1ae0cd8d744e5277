#include "viewer/picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "scene/assets/texture.h"
#include "tests/support/message_of.h"
#include "tests/support/test_scene.h"
#include "viewer/color_map.h"
#include "viewer/legend.h"

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
      scan.label.push_back(column < 10 ? 2 : 1);
      scan.intensity.push_back(static_cast<float>(ring * 10));
      scan.ring.push_back(ring);
      scan.column.push_back(column);
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

PictureOptions small() {
  PictureOptions options;
  options.width = 480;
  options.height = 270;
  return options;
}

std::ptrdiff_t count(const Image& image, const Rgb& color) {
  return std::count(image.pixels.begin(), image.pixels.end(), color);
}

std::ptrdiff_t bright(const Image& image, int top, int bottom) {
  return std::count_if(image.pixels.begin() + std::ptrdiff_t{top} * image.width,
                       image.pixels.begin() + std::ptrdiff_t{bottom} * image.width,
                       [](const Rgb& p) { return p[0] > 150 && p[1] > 150 && p[2] > 150; });
}

TEST(Picture, HasTheSizeAskedFor) {
  const Ontology ontology = colorful();
  for (const auto& [width, height] : {std::pair{64, 64}, std::pair{480, 270}, std::pair{300, 700}}) {
    PictureOptions options;
    options.width = width;
    options.height = height;
    for (const ColorBy by : {ColorBy::Class, ColorBy::Intensity}) {
      options.colorBy = by;
      const Image image = drawPicture(smallScan(), &ontology, options, "a scan");
      EXPECT_EQ(image.width, width);
      EXPECT_EQ(image.height, height);
    }
  }
}

TEST(Picture, ShowsTheClassesThatAreThere) {
  const Ontology ontology = colorful();
  const Image image = drawPicture(smallScan(), &ontology, small(), "a scan");
  EXPECT_GT(count(image, {255, 0, 0}), 100);
  EXPECT_GT(count(image, {0, 255, 0}), 50);
  EXPECT_EQ(count(image, {255, 255, 0}), 0) << "no point has this class";
  PictureOptions intensity = small();
  intensity.colorBy = ColorBy::Intensity;
  EXPECT_EQ(count(drawPicture(smallScan(), &ontology, intensity, "a scan"), {255, 0, 0}), 0);
}

// Title and legend keep out of the scan's part, which is exactly what drawSplats() gives.
TEST(Picture, LegendAndTitleStayBesideTheScan) {
  const Ontology ontology = colorful();
  const Scan scan = smallScan();
  for (const View view : {View::Driver, View::Above, View::Chase}) {
    PictureOptions options = small();
    options.view = view;
    const Image image = drawPicture(scan, &ontology, options, "a scan with a long title");
    const Coloring coloring = colorScan(scan, {}, &ontology);
    const PictureLayout layout = layoutPicture(options.width, options.height, coloring.legend);
    const int height = layout.bottom - layout.top;
    const Image alone = drawSplats(scan.position, coloring.colors, makeCamera(view, options.width, height, 1),
                                   options.width, height, options.splats);
    ASSERT_LT(layout.top, options.height / 4);
    ASSERT_GT(layout.bottom, options.height * 3 / 5 - 1);
    EXPECT_TRUE(std::equal(alone.pixels.begin(), alone.pixels.end(),
                           image.pixels.begin() + std::ptrdiff_t{layout.top} * image.width));
  }
}

TEST(Picture, LegendOfManyClassesIsCut) {
  Legend legend;
  for (int i = 0; i < 500; ++i) legend.entries.push_back({"class_" + std::to_string(i), {255, 0, 0}});
  for (const auto& [width, height] : {std::pair{64, 64}, std::pair{640, 360}, std::pair{200, 900}}) {
    const PictureLayout layout = layoutPicture(width, height, legend);
    EXPECT_GE(layout.bottom, height * 3 / 5);
    EXPECT_GT(layout.bottom, layout.top);
    Image image(width, height, kBackground);
    drawLegend(image, layout, legend);
    EXPECT_EQ(
        std::count(image.pixels.begin(), image.pixels.begin() + std::ptrdiff_t{layout.bottom} * width, kBackground),
        std::ptrdiff_t{layout.bottom} * width);
  }
}

TEST(Picture, EmptyScanSaysSo) {
  const Image empty = drawPicture({}, nullptr, small(), "nothing");
  EXPECT_EQ(empty.width, 480);
  EXPECT_GT(bright(empty, 100, 180), 50) << "words in the middle";
  PictureOptions wanted = small();
  wanted.colorBy = ColorBy::Class;
  EXPECT_NO_THROW(drawPicture({}, nullptr, wanted, "nothing"));
  Scan misses;
  misses.organised = true;
  misses.rings = 2;
  misses.columns = 3;
  misses.position.assign(6, {NAN, NAN, NAN});
  EXPECT_GT(bright(drawPicture(misses, nullptr, small(), "misses"), 100, 180), 50);
  const Ontology ontology = colorful();
  PictureOptions above = small();
  above.view = View::Above;
  above.zoom = 0.01;
  EXPECT_EQ(bright(drawPicture(smallScan(), &ontology, above, "full"), 100, 180), 0);
  EXPECT_NO_THROW(drawRangeImage({}, nullptr, {}, "nothing"));
}

TEST(Picture, TheSameBytesEveryTime) {
  const Ontology ontology = colorful();
  const auto bytes = [&] { return encodePng(drawPicture(smallScan(), &ontology, small(), "a scan")); };
  EXPECT_EQ(bytes(), bytes());
}

TEST(Png, ReadsBackAsWritten) {
  const Ontology ontology = colorful();
  const Image image = drawPicture(smallScan(), &ontology, small(), "a scan");
  const auto read = decodeTexture(encodePng(image), "picture.png");
  ASSERT_EQ(read->width, 480u);
  ASSERT_EQ(read->height, 270u);
  std::ptrdiff_t wrong = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      // A texture's first row is the lowest.
      const std::size_t texel = (std::size_t(image.height - 1 - y) * read->width + std::size_t(x)) * 4;
      for (std::size_t c = 0; c < 3; ++c) wrong += read->rgba[texel + c] != image.at(x, y)[c];
    }
  }
  EXPECT_EQ(wrong, 0);
}

TEST(RangeImage, HasAPixelPerBeam) {
  const Ontology ontology = colorful();
  const Scan scan = smallScan();
  const Image image = drawRangeImage(scan, &ontology, ColorBy::Class, "a scan");
  const int stepX = image.width / 90;
  ASSERT_EQ(image.width, stepX * 90);
  ASSERT_GE(image.width, 1600);
  const PictureLayout layout = layoutAround(image.width, 8, colorScan(scan, ColorBy::Class, &ontology).legend);
  int bodyHeight = 0;
  while (image.at(stepX * 50, layout.top + bodyHeight) == Rgb{255, 0, 0}) ++bodyHeight;
  const int stepY = bodyHeight / 8;
  ASSERT_EQ(bodyHeight, stepY * 8);
  for (int ring = 0; ring < 8; ++ring) {
    for (int column = 0; column < 90; ++column) {
      const Rgb expected = column < 10 ? Rgb{0, 255, 0} : Rgb{255, 0, 0};
      EXPECT_EQ(image.at(column * stepX, layout.top + ring * stepY), expected);
      EXPECT_EQ(image.at(column * stepX + stepX - 1, layout.top + ring * stepY + stepY - 1), expected);
    }
  }
}

// Whichever way a sensor counts its rings, the highest beam is on top.
TEST(RangeImage, HighBeamsAreOnTop) {
  Scan scan;
  for (std::uint16_t ring = 0; ring < 4; ++ring) {
    scan.position.push_back({10, 0, static_cast<float>(ring)});
    scan.ring.push_back(ring);
    scan.column.push_back(0);
    scan.label.push_back(ring == 3 ? 2 : 1);
  }
  const Ontology ontology = colorful();
  const Image up = drawRangeImage(scan, &ontology, ColorBy::Class, "up");
  for (Vec3f& p : scan.position) p.z = -p.z;
  const Image down = drawRangeImage(scan, &ontology, ColorBy::Class, "down");
  const int top = layoutAround(up.width, 1, colorScan(scan, ColorBy::Class, &ontology).legend).top;
  EXPECT_EQ(up.at(5, top), (Rgb{0, 255, 0}));
  EXPECT_EQ(down.at(5, top), (Rgb{255, 0, 0}));
}

TEST(RangeImage, OrganisedScanNeedsNoColumns) {
  Scan scan;
  scan.organised = true;
  scan.rings = 2;
  scan.columns = 3;
  scan.position = {{5, 0, 1}, {NAN, NAN, NAN}, {5, 1, 1}, {5, 0, -1}, {5, 0, -1}, {5, 1, -1}};
  const Image image = drawRangeImage(scan, nullptr, ColorBy::Range, "organised");
  const int top = layoutAround(image.width, 1, colorScan(scan, ColorBy::Range, nullptr).legend).top;
  const int step = image.width / 3;
  EXPECT_NE(image.at(0, top), kBackground);
  EXPECT_EQ(image.at(step, top), kBackground) << "a miss";
  EXPECT_NE(image.at(2 * step, top), kBackground);
}

TEST(RangeImage, NearerWins) {
  Scan scan;
  scan.position = {{9, 0, 0}, {3, 0, 0}, {6, 0, 0}};
  scan.ring = scan.column = {0, 0, 0};
  scan.label = {1, 2, 3};
  const Ontology ontology = colorful();
  const Image image = drawRangeImage(scan, &ontology, ColorBy::Class, "a pixel");
  EXPECT_EQ(image.at(image.width / 2, 60), (Rgb{0, 255, 0}));
}

TEST(RangeImage, SaysWhatIsMissing) {
  Scan scan = smallScan();
  scan.column.clear();
  expectInputError([&] { drawRangeImage(scan, nullptr, ColorBy::Range, "no column"); }, {"'column'"});
  scan = smallScan();
  scan.column[3] = 65535;
  EXPECT_THROW(drawRangeImage(scan, nullptr, ColorBy::Range, "too wide"), InputError);
}

TEST(Picture, OverlaidScansHaveColoursOfTheirOwn) {
  NamedScan near{"near", {}};
  NamedScan far{"far", {}};
  for (int i = -20; i <= 20; ++i) {
    near.scan.position.push_back({5, 0.1f * static_cast<float>(i), 0});
    far.scan.position.push_back({10, 0.1f * static_cast<float>(i), 0});
  }
  PictureOptions options = small();
  options.view = View::Above;
  options.zoom = 4;
  options.splats.size = 4;
  options.splats.depthEdges = false;
  const Rgb first{240, 228, 66};
  const Rgb second{86, 180, 233};
  const Image alone = drawOverlay({near}, options, "one");
  const Image both = drawOverlay({near, far}, options, "two");
  const Image same = drawOverlay({near, near}, options, "the same twice");
  EXPECT_GT(count(alone, first), 200);
  EXPECT_EQ(count(alone, second), 0);
  EXPECT_GT(count(both, second), 200);
  EXPECT_GT(count(same, first), count(same, second));  // where they meet, the first is seen
}

}  // namespace

}  // namespace scanmill
