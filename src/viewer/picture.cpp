#include "viewer/picture.h"

#include <fmt/core.h>

#include <algorithm>

#include "viewer/color_map.h"
#include "viewer/legend.h"

namespace scanmill {

namespace {

std::ptrdiff_t finitePoints(const Scan& scan) {
  return std::count_if(scan.position.begin(), scan.position.end(), [](const Vec3f& p) { return isFinite(p); });
}

std::string titleWithPoints(const std::string& title, std::ptrdiff_t points) {
  std::string digits = std::to_string(points);
  for (std::size_t i = digits.size(); i > 3; i -= 3) digits.insert(i - 3, ",");
  return fmt::format("{}, {} point{}", title, digits, points == 1 ? "" : "s");
}

}  // namespace

Image drawPicture(const Scan& scan, const Ontology* ontology, const PictureOptions& options, const std::string& title) {
  const Coloring coloring = colorScan(scan, options.colorBy, ontology);
  const std::ptrdiff_t points = finitePoints(scan);
  const Legend legend = points == 0 ? Legend{} : coloring.legend;
  const Layout layout = layoutPicture(options.width, options.height, legend);
  const int bodyHeight = layout.bottom - layout.top;
  Image image(options.width, options.height, kBackground);
  const Camera camera = makeCamera(options.view, options.width, bodyHeight, options.zoom);
  paste(image, drawSplats(scan.position, coloring.colors, camera, options.width, bodyHeight, options.splats), 0,
        layout.top);
  drawTitle(image, layout, titleWithPoints(title, points),
            fmt::format("{} view, {}", kViewNames[static_cast<std::size_t>(options.view)], coloring.legend.title));
  drawLegend(image, layout, legend);
  if (points == 0) drawNotice(image, layout, "no points");
  return image;
}

}  // namespace scanmill
