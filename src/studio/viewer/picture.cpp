#include "viewer/picture.h"

#include <fmt/core.h>

#include "methods/method.h"
#include "viewer/window/session.h"

namespace scanmill {

namespace {

// Colours that are used after the colours of methods: three of Okabe and Ito's palette ("Color universal design",
// 2008), then white, cyan, brown and violet.
constexpr Rgb kMoreColors[] = {{0, 158, 115}, {204, 121, 167}, {240, 228, 66}, {240, 242, 246},
                               {0, 220, 230}, {166, 118, 60},  {150, 100, 255}};

}  // namespace

Rgb overlayColor(std::size_t scan) {
  const std::size_t color = scan % (methods().size() + std::size(kMoreColors));
  return color < methods().size() ? methods()[color].color : kMoreColors[color - methods().size()];
}

Image drawScan(const Scan& scan, const Coloring& coloring, int width, int height, const std::string& title,
               bool depthEdges) {
  const std::unique_ptr<Canvas> canvas = openOffscreen(width, height);
  ViewFrame frame{.key = title, .scans = std::vector<ViewScan>(1), .problems = {}};
  frame.scans.front().scan = scan;
  frame.scans.front().coloring = coloring;
  ViewSession session(
      std::make_shared<OneFrame>(std::move(frame)), *canvas,
      {.pointSize = std::max(2.0, std::round(height / 240.0)), .depthEdges = depthEdges, .axes = false, .still = true});
  session.drawWhenLoaded();
  return session.picture();
}

Image drawRangeImage(const Scan& scan, const Ontology* ontology, const std::optional<ColorBy>& colorBy,
                     const std::string& title, const BeamTable* beams) {
  constexpr double kReadableWidth = 1600;     // least width (pixels)
  constexpr double kReadableShare = 1.0 / 7;  // least height of the image divided by its width
  const Coloring coloring = colorScan(scan, colorBy, {ontology});
  const Legend& legend = coloring.legend;
  const RangeStrip strip = makeRangeStrip(scan, coloring.colors, {}, beams);
  // Returns the least integer factor that enlarges a side of `size` pixels to at least `leastSize` pixels, but at most
  // the largest factor with which the side stays within kMostPictureSide.
  const auto enlargement = [](double leastSize, int size) {
    return std::clamp(static_cast<int>(std::ceil(leastSize / size)), 1, std::max(kMostPictureSide / size, 1));
  };
  const int width = strip.image.width * enlargement(kReadableWidth, strip.image.width);
  const int height = strip.image.height * enlargement(width * kReadableShare, strip.image.height);
  const double lineHeight = pictureLineHeight(width, width);
  const LegendPicture picture{.title = fmt::format("{}, {}", title, describeStrip(strip)),
                              .details = fmt::format("ring 0 at the {}, {}", strip.ringsRise ? "bottom" : "top",
                                                     legend.scale ? scaleTitle(legend) : legend.title),
                              .body = {0, static_cast<int>(std::lround(1.5 * lineHeight)), width, height},
                              .lineHeight = lineHeight,
                              .maxWidth = kMostPictureSide,
                              .images = {&strip.image}};
  return drawWithLegend(picture, legend, [&] {
    imageAt(ImageId{0}, picture.body);
    if (std::ranges::none_of(scan.position, isFinite<float>)) drawMessage(picture.body, "no points");
  });
}

}  // namespace scanmill
