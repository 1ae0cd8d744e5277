#include "viewer/picture.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/error.h"
#include "base/short_text.h"
#include "methods/method.h"
#include "viewer/color_map.h"
#include "viewer/panels/parts.h"
#include "viewer/panels/rooms.h"
#include "viewer/window/orbit_camera.h"

namespace scanmill {

namespace {

// Colours that are used after the colours of methods, from Okabe and Ito's palette ("Color universal design", 2008).
constexpr Rgb kMoreColors[] = {{0, 158, 115}, {204, 121, 167}, {240, 228, 66}};

// Draws the points with a camera that sees them from behind and above the sensor.
void drawPoints(Canvas& canvas, const PixelRect& body, const Scan& scan, const std::vector<Rgb>& colors,
                bool depthEdges) {
  constexpr ItemId kPoints = 1;
  std::vector<Vec3d> finite;
  for (const Vec3f& point : scan.position) {
    if (isFinite(point)) finite.emplace_back(point);
  }
  const OrbitCamera camera = presetCamera(View::Chase).seeing(finite, View::Chase, body.width, body.height);
  CanvasView view{.rect = body, .camera = camera.camera(body.width, body.height), .background = kBackground};
  view.depthEdges = depthEdges;
  view.farthest = 2 * view.camera.nearest;
  for (const Vec3d& point : finite) view.farthest = std::max(view.farthest, view.camera.project(point).depth * 1.01);
  canvas.setViews({&view, 1});
  canvas.setPoints(kPoints, scan.position, colors);
  canvas.setLook(kPoints, {.size = std::max(2.0, std::round(body.height / 240.0))});
}

std::uint64_t finitePoints(const Scan& scan) {
  return static_cast<std::uint64_t>(std::ranges::count_if(scan.position, isFinite<float>));
}

}  // namespace

Rgb overlayColor(std::size_t scan) {
  const std::size_t place = scan % (methods().size() + std::size(kMoreColors));
  return place < methods().size() ? methods()[place].color : kMoreColors[place - methods().size()];
}

Image drawScan(const Scan& scan, const Coloring& coloring, int width, int height, const std::string& title,
               bool depthEdges) {
  const std::uint64_t points = finitePoints(scan);
  const Legend legend = points == 0 ? Legend{} : coloring.legend;
  const double letter = letterOfPicture(width, height);
  const PanelNeeds needs{
      .letter = letter, .row = std::round(1.5 * letter), .side = legend.scale || !legend.entries.empty(), .bar = false};
  const PanelRooms rooms = roomsOf(width, height, needs);
  PictureBoard board(width, height, letter);
  drawPoints(board.canvas(), rooms.body, scan, coloring.colors, depthEdges);
  return board.draw([&] {
    titleRow(rooms.title, fmt::format("{}, {} point{}", title, grouped(points), points == 1 ? "" : "s"),
             coloring.legend.title);
    legendPanel(legend, rooms.side);
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
  const int side = legend.scale || !legend.entries.empty() ? sideWidth(letter) : 0;
  const PixelRect top{0, 0, width + side, static_cast<int>(std::lround(1.5 * letter))};
  const PixelRect body{0, top.height, width, height};
  PictureBoard board(width + side, top.height + height, letter);
  board.setImage(kStrip, strip.image);
  return board.draw([&] {
    titleRow(top, fmt::format("{}, {}", title, describeStrip(strip)),
             fmt::format("ring 0 at the {}, {}", strip.ringsRise ? "bottom" : "top",
                         legend.scale ? scaleTitle(legend) : legend.title));
    panelAt("##strip", body, false, [&] { imageAt(kStrip, body); });
    legendPanel(legend, {width, top.height, side, height});
    if (finitePoints(scan) == 0) drawMessage(body, "no points");
  });
}

}  // namespace scanmill
