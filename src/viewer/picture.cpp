#include "viewer/picture.h"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>

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

// Okabe and Ito's palette for the colour-blind ("Color universal design", 2008), lightest first.
constexpr Rgb kOverlay[] = {{240, 228, 66}, {86, 180, 233},  {213, 94, 0},
                            {0, 158, 115},  {204, 121, 167}, {230, 159, 0}};

}  // namespace

Image drawOverlay(const std::vector<NamedScan>& scans, const PictureOptions& options, const std::string& title) {
  std::vector<Vec3f> points;
  std::vector<Rgb> colors;
  Legend legend;
  legend.title = "scan";
  std::size_t next = 0;
  for (const NamedScan& named : scans) {
    const Rgb color = kOverlay[next++ % std::size(kOverlay)];
    legend.entries.push_back({fmt::format("{}, {} points", named.name, finitePoints(named.scan)), color});
    points.insert(points.end(), named.scan.position.begin(), named.scan.position.end());
    colors.resize(points.size(), color);
  }
  const PictureLayout layout = layoutPicture(options.width, options.height, legend);
  const int bodyHeight = layout.bottom - layout.top;
  Image image(options.width, options.height, kBackground);
  const ViewCamera camera = makeCamera(options.view, options.width, bodyHeight, options.zoom);
  paste(image, drawSplats(points, colors, camera, options.width, bodyHeight, options.splats), 0, layout.top);
  drawTitle(image, layout, title, fmt::format("{} view", kViewNames[static_cast<std::size_t>(options.view)]));
  drawLegend(image, layout, legend);
  return image;
}

Image drawPicture(const Scan& scan, const Ontology* ontology, const PictureOptions& options, const std::string& title) {
  const Coloring coloring = colorScan(scan, options.colorBy, ontology);
  const std::ptrdiff_t points = finitePoints(scan);
  const Legend legend = points == 0 ? Legend{} : coloring.legend;
  const PictureLayout layout = layoutPicture(options.width, options.height, legend);
  const int bodyHeight = layout.bottom - layout.top;
  Image image(options.width, options.height, kBackground);
  const ViewCamera camera = makeCamera(options.view, options.width, bodyHeight, options.zoom);
  paste(image, drawSplats(scan.position, coloring.colors, camera, options.width, bodyHeight, options.splats), 0,
        layout.top);
  drawTitle(image, layout, titleWithPoints(title, points),
            fmt::format("{} view, {}", kViewNames[static_cast<std::size_t>(options.view)], coloring.legend.title));
  drawLegend(image, layout, legend);
  if (points == 0) drawNotice(image, layout, "no points");
  return image;
}

}  // namespace scanmill
