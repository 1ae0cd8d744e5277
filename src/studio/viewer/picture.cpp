#include "viewer/picture.h"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>
#include <limits>

#include "base/error.h"
#include "base/grouped.h"
#include "methods/method.h"
#include "viewer/color_map.h"
#include "viewer/legend.h"

namespace scanmill {

namespace {

bool isShown(const Vec3f& point, const std::optional<CloseUp>& closeUp) {
  return closeUp ? closeUp->holds(Vec3d(point)) : isFinite(point);
}

std::ptrdiff_t countShown(const std::vector<Vec3f>& points, const std::optional<CloseUp>& closeUp) {
  return std::count_if(points.begin(), points.end(), [&](const Vec3f& p) { return isShown(p, closeUp); });
}

std::string text(const Vec3d& place) {
  return fmt::format("{:.4g},{:.4g},{:.4g}", place.x, place.y, place.z);
}

// The points that a close-up leaves out lose their place, as an organised scan's misses have none.
void keepShown(std::vector<Vec3f>& points, const std::optional<CloseUp>& closeUp) {
  if (!closeUp) return;
  constexpr double kNone = std::numeric_limits<double>::infinity();
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  double distance = kNone;
  Vec3d nearest;
  for (Vec3f& p : points) {
    const double d = length(Vec3d(p) - closeUp->at);
    if (d < distance) {
      distance = d;
      nearest = Vec3d(p);
    }
    if (!isShown(p, closeUp)) p = {kNaN, kNaN, kNaN};
  }
  if (distance <= closeUp->within) return;
  throw InputError(fmt::format(
      "no point is within {:.4g} m of {}: {}", closeUp->within, text(closeUp->at),
      distance == kNone ? std::string("there is none at all")
                        : fmt::format("the nearest is {:.4g} m from there, at {}; take another --at or a larger "
                                      "--within",
                                      distance, text(nearest))));
}

std::string viewOf(const PictureOptions& options) {
  const std::string_view view = kViewNames[static_cast<std::size_t>(options.view)];
  if (!options.closeUp) return fmt::format("{} view", view);
  return fmt::format("{} view, {:.4g} m about {}", view, options.closeUp->within, text(options.closeUp->at));
}

std::string titleWithPoints(const std::string& title, std::ptrdiff_t points) {
  return fmt::format("{}, {} point{}", title, grouped(static_cast<std::uint64_t>(points)), points == 1 ? "" : "s");
}

// After the colours of the methods; from Okabe and Ito's palette ("Color universal design", 2008).
constexpr Rgb kMoreColors[] = {{0, 158, 115}, {204, 121, 167}, {240, 228, 66}};

}  // namespace

Rgb overlayColor(std::size_t scan) {
  const std::size_t place = scan % (methods().size() + std::size(kMoreColors));
  return place < methods().size() ? methods()[place].color : kMoreColors[place - methods().size()];
}

Image drawOverlay(const std::vector<NamedScan>& scans, const PictureOptions& options, const std::string& title) {
  std::vector<Vec3f> points;
  std::vector<Rgb> colors;
  Legend legend;
  legend.title = "scan";
  for (const NamedScan& named : scans) {
    const Rgb color = overlayColor(legend.entries.size());
    const auto shown = countShown(named.scan.position, options.closeUp);
    legend.entries.push_back({fmt::format("{}, {} points", named.name, shown), color});
    points.insert(points.end(), named.scan.position.begin(), named.scan.position.end());
    colors.resize(points.size(), color);
  }
  keepShown(points, options.closeUp);
  const PictureLayout layout = layoutPicture(options.width, options.height, legend);
  const int bodyHeight = layout.bottom - layout.top;
  Image image(options.width, options.height, kBackground);
  const ViewCamera camera = makeCamera(options.view, options.width, bodyHeight, options.zoom, options.closeUp);
  paste(image, drawSplats(points, colors, camera, options.width, bodyHeight, options.splats), 0, layout.top);
  drawTitle(image, layout, title, viewOf(options));
  drawLegend(image, layout, legend);
  return image;
}

Image drawPicture(Scan scan, const Ontology* ontology, const PictureOptions& options, const std::string& title) {
  keepShown(scan.position, options.closeUp);
  const Coloring coloring = colorScan(scan, options.colorBy, ontology);
  return drawColored(std::move(scan), coloring, options, title);
}

Image drawColored(Scan scan, const Coloring& coloring, const PictureOptions& options, const std::string& title) {
  keepShown(scan.position, options.closeUp);
  const std::ptrdiff_t points = countShown(scan.position, {});
  const Legend legend = points == 0 ? Legend{} : coloring.legend;
  const PictureLayout layout = layoutPicture(options.width, options.height, legend);
  const int bodyHeight = layout.bottom - layout.top;
  Image image(options.width, options.height, kBackground);
  const ViewCamera camera = makeCamera(options.view, options.width, bodyHeight, options.zoom, options.closeUp);
  paste(image, drawSplats(scan.position, coloring.colors, camera, options.width, bodyHeight, options.splats), 0,
        layout.top);
  drawTitle(image, layout, titleWithPoints(title, points),
            fmt::format("{}, {}", viewOf(options), coloring.legend.title));
  drawLegend(image, layout, legend);
  if (points == 0) drawNotice(image, layout, "no points");
  return image;
}

}  // namespace scanmill
