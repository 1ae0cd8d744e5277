#include "viewer/picture.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include "base/error.h"
#include "base/grouped.h"
#include "methods/method.h"
#include "viewer/color_map.h"
#include "viewer/panels/board.h"
#include "viewer/panels/parts.h"
#include "viewer/panels/rooms.h"
#include "viewer/scale_ticks.h"
#include "viewer/window/orbit_camera.h"

namespace scanmill {

namespace {

// Colours that are used after the colours of methods, from Okabe and Ito's palette ("Color universal design", 2008).
constexpr Rgb kMoreColors[] = {{0, 158, 115}, {204, 121, 167}, {240, 228, 66}};

// Returns the diameter (pixels) with which a point is drawn, so that it fills the gap to neighbouring beams, which
// grows with the range. `scale`: pixels per metre at the point. `unit`: 1/850 of the picture's height, at least 0.5.
double pointDiameter(double range, double scale, double factor, double unit) {
  constexpr double kWorldDiameter = 0.05;  // diameter of a point near the sensor (m)
  // Increase of the diameter per range (m/m); points of beams 0.2 degrees apart nearly touch.
  constexpr double kDiameterPerMetre = 0.003;
  constexpr double kLeast = 1.3;  // minimum diameter, in multiples of `unit`
  constexpr double kMost = 16;    // maximum diameter, in multiples of `unit`
  return factor * std::clamp((kWorldDiameter + kDiameterPerMetre * range) * scale, kLeast * unit, kMost * unit);
}

// Returns the camera of the view, or one that sees the points if this one does not.
ViewCamera cameraOf(const std::vector<Vec3f>& points, const PictureOptions& options, const PixelRect& body) {
  std::vector<Vec3d> finite;
  for (const Vec3f& point : points) {
    if (isFinite(point)) finite.emplace_back(point);
  }
  const OrbitCamera preset = presetCamera(options.view);
  ViewCamera camera = preset.seeing(finite, options.view, body.width, body.height).camera(body.width, body.height);
  camera.focal *= options.zoom;
  return camera;
}

// Draws the points. If several points of equal depth and diameter are in the same pixel, the one with the lowest index
// is visible.
void drawPoints(Canvas& canvas, const PixelRect& body, const std::vector<Vec3f>& points, const std::vector<Rgb>& colors,
                const PictureOptions& options) {
  constexpr double kMostDiameter = 200;  // maximum diameter of a point in pixels
  CanvasView view{.rect = body, .camera = cameraOf(points, options, body), .background = kBackground};
  view.depthEdges = options.depthEdges;
  view.farthest = 2 * view.camera.nearest;
  const double unit = std::max(body.height / 850.0, 0.5);
  struct Item {
    std::vector<Vec3f> points;
    std::vector<Rgb> colors;
  };
  std::map<int, Item> items;  // keys: diameters of points in pixels
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!isFinite(points[i])) continue;
    const Projected p = view.camera.project(Vec3d(points[i]));
    if (!(p.depth >= view.camera.nearest)) continue;
    view.farthest = std::max(view.farthest, p.depth * 1.01);
    const double size = pointDiameter(length(Vec3d(points[i])), p.scale, options.pointSize, unit);
    Item& item = items[static_cast<int>(std::lround(std::clamp(size, 1.0, kMostDiameter)))];
    item.points.push_back(points[i]);
    item.colors.push_back(colors[i]);
  }
  canvas.setViews({&view, 1});
  for (const auto& [size, item] : items) {
    canvas.setPoints(static_cast<ItemId>(size), item.points, item.colors);
    // Points of at most 3 pixels have too few pixels for a disc.
    canvas.setLook(static_cast<ItemId>(size), {.size = static_cast<double>(size), .round = size > 3});
  }
}

std::uint64_t finitePoints(const Scan& scan) {
  return static_cast<std::uint64_t>(std::ranges::count_if(scan.position, isFinite<float>));
}

}  // namespace

Rgb overlayColor(std::size_t scan) {
  const std::size_t place = scan % (methods().size() + std::size(kMoreColors));
  return place < methods().size() ? methods()[place].color : kMoreColors[place - methods().size()];
}

Image drawPicture(const Scan& scan, const Ontology* ontology, const PictureOptions& options, const std::string& title) {
  return drawColored(scan, colorScan(scan, options.colorBy, {ontology}), options, title);
}

Image drawColored(const Scan& scan, const Coloring& coloring, const PictureOptions& options, const std::string& title) {
  const std::uint64_t points = finitePoints(scan);
  const Legend legend = points == 0 ? Legend{} : coloring.legend;
  const PanelNeeds needs = needsOfPicture(options.width, options.height, legend.scale || !legend.entries.empty());
  const PanelRooms rooms = roomsOf(options.width, options.height, needs);
  PictureBoard board(options.width, options.height, needs.letter);
  drawPoints(board.canvas(), rooms.body, scan.position, coloring.colors, options);
  return board.draw([&] {
    titleRow(rooms.title, fmt::format("{}, {} point{}", title, grouped(points), points == 1 ? "" : "s"),
             fmt::format("{} view, {}", kViewNames[static_cast<std::size_t>(options.view)], coloring.legend.title));
    panelAt("##side", rooms.side, false, [&] { legendSection(legend, true); });
    drawMessage(rooms.body, points == 0 ? "no points" : "");
  });
}

Image drawRangeImage(const Scan& scan, const Ontology* ontology, const std::optional<ColorBy>& colorBy,
                     const std::string& title, const BeamTable* beams) {
  constexpr ImageId kStrip = 1;
  constexpr double kReadableWidth = 1600;
  constexpr double kReadableShare = 1.0 / 7;  // least height of the image divided by its width
  const Coloring coloring = colorScan(scan, colorBy, {ontology});
  const Legend& legend = coloring.legend;
  const RangeStrip strip = makeRangeStrip(scan, coloring.colors, {}, beams);
  const auto steps = [](double wanted, int size) {
    return std::clamp(static_cast<int>(std::ceil(wanted / size)), 1, std::max(kMostPictureSide / size, 1));
  };
  const int width = strip.image.width * steps(kReadableWidth, strip.image.width);
  const int height = strip.image.height * steps(width * kReadableShare, strip.image.height);
  const double letter = letterOfPicture(width, width);
  const PixelRect top{0, 0, width, static_cast<int>(std::lround(1.5 * letter))};
  const PixelRect body{0, top.height, width, height};
  const PixelRect below{0, top.height + height, width, legendTableHeight(legend, width, letter)};
  PictureBoard board(width, below.top + below.height, letter);
  board.setImage(kStrip, strip.image);
  return board.draw([&] {
    titleRow(top, fmt::format("{}, {}", title, describeStrip(strip)),
             fmt::format("ring 0 at the {}, {}", strip.ringsRise ? "bottom" : "top",
                         legend.scale ? scaleTitle(legend) : legend.title));
    panelAt("##strip", body, false, [&] { imageAt(kStrip, body); });
    panelAt("##legend", below, false, [&] { legendTable(legend); });
    if (finitePoints(scan) == 0) drawMessage(body, "no points");
  });
}

}  // namespace scanmill
