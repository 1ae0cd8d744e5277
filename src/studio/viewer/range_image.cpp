#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "viewer/color_map.h"
#include "viewer/legend.h"
#include "viewer/picture.h"
#include "viewer/window/range_strip.h"

namespace scanmill {

namespace {

Image enlarged(const Image& image, int stepX, int stepY) {
  Image out(image.width * stepX, image.height * stepY, kBackground);
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) out.at(x, y) = image.at(x / stepX, y / stepY);
  }
  return out;
}

int wholeSteps(double wanted, int size) {
  return std::clamp(static_cast<int>(std::ceil(wanted / size)), 1, std::max(kMostPictureSide / size, 1));
}

}  // namespace

Image drawRangeImage(const Scan& scan, const Ontology* ontology, std::optional<ColorBy> colorBy,
                     const std::string& title, StripOrder order) {
  constexpr double kReadableWidth = 1600;
  constexpr double kReadableShare = 1.0 / 7;  // height over width
  const Coloring coloring = colorScan(scan, colorBy, ontology);
  const RangeStrip strip = makeRangeStrip(scan, coloring.colors, {}, order);
  const int rings = strip.image.height;
  const int columns = strip.image.width;
  const int stepX = wholeSteps(kReadableWidth, columns);
  const int stepY = wholeSteps(columns * stepX * kReadableShare, rings);
  const Image body = enlarged(strip.image, stepX, stepY);
  const PictureLayout layout = layoutAround(body.width, body.height, coloring.legend);
  Image image(layout.width, layout.height, kBackground);
  paste(image, body, 0, layout.top);
  drawTitle(image, layout, fmt::format("{}, {}", title, describeStrip(strip, order)),
            fmt::format("ring 0 at the {}, {}", strip.ringsRise ? "bottom" : "top", coloring.legend.title));
  drawLegend(image, layout, coloring.legend);
  const bool empty =
      std::none_of(scan.position.begin(), scan.position.end(), [](const Vec3f& p) { return isFinite(p); });
  if (empty) drawNotice(image, layout, "no points");
  return image;
}

}  // namespace scanmill
