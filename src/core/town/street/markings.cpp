// Builds road markings, which are thermoplastic and 3 mm thick, so that they are never in the plane of the asphalt.

#include <algorithm>
#include <cmath>

#include "town/street/layout.h"

namespace scanmill::street {
namespace {

constexpr double kThickness = 3e-3;  // m, thickness of markings
constexpr double kLine = 0.12;       // m, width of a line

class Painter {
 public:
  Painter(SceneBuilder& builder, const Layout& layout)
      : l_(layout), shape_(builder, "road markings"), paint_(shape_.surface("road_marking", "road_paint")) {}

  Model paint() {
    mainRoad();
    parkingBays();
    if (l_.cross) crossing();
    return shape_.finish();
  }

 private:
  // Adds the top and the sides of a marking; `polygon` is counter-clockwise as seen from above.
  void patch(const std::vector<Point2>& polygon) {
    const std::size_t n = polygon.size();
    const auto low = [&](std::size_t i) { return Vec3d{polygon[i % n].x, polygon[i % n].y, 0}; };
    const auto high = [&](std::size_t i) { return Vec3d{polygon[i % n].x, polygon[i % n].y, kThickness}; };
    for (std::size_t i = 0; i < n; ++i) shape_.quad(paint_, low(i), low(i + 1), high(i + 1), high(i));
    for (std::size_t i = 1; i + 1 < n; ++i) shape_.triangle(paint_, high(0), high(i), high(i + 1));
  }

  // Adds a rectangle between x0 and x1 and between y0 and y1; the smaller or the larger value may come first.
  void bar(double x0, double x1, double y0, double y1) {
    const auto [left, right] = std::minmax(x0, x1);
    const auto [low, high] = std::minmax(y0, y1);
    patch({{left, low}, {right, low}, {right, high}, {left, high}});
  }

  // Returns the distance from the middle of the crossing (m) within which there are no lines along x.
  double crossingReach() const { return l_.cross ? l_.crossWalk + 1.7 : 0; }

  bool inCrossing(double x0, double x1) const {
    return l_.cross && x1 > l_.crossX - crossingReach() && x0 < l_.crossX + crossingReach();
  }

  void dashesAlongX(double from, double to, double y, double dash, double gap, double width) {
    for (double x = from; x + dash < to; x += dash + gap) {
      if (!inCrossing(x, x + dash)) bar(x, x + dash, y - width / 2, y + width / 2);
    }
  }

  void mainRoad() {
    dashesAlongX(-l_.halfX, l_.halfX, 0, 3, 6, kLine);
    // Outside of the built-up part the road has edge lines.
    for (const double side : {-1.0, 1.0}) {
      const double y = side * (l_.roadEdge - 0.25);
      dashesAlongX(-l_.halfX, -l_.halfLength - 2, y, 10, 0.02, kLine);
      dashesAlongX(l_.halfLength + 2, l_.halfX, y, 10, 0.02, kLine);
    }
  }

  void parkingBays() {
    constexpr double kBay = 6.0;  // m, length of a parking bay
    for (const Span& s : l_.parking) {
      for (const double side : {-1.0, 1.0}) {
        const double edge = side * (l_.roadEdge + 0.03);
        for (double x = s.low + 0.3; x + kBay < s.high; x += kBay) {
          const double far = side * (l_.parkingEdge - 0.25);
          if (!l_.onStrip(&Lot::driveway, x, int(side), 0.3)) {
            bar(x - 0.05, x + 0.05, edge + side * 0.06, far);
          }
          bar(x + 0.06, x + kBay - 0.06, edge - 0.05, edge + 0.05);
        }
      }
    }
  }

  void arrow(double tip, double y, double direction) {
    const double shaft = tip - direction * 1.2;
    const double tail = tip - direction * 4.0;
    bar(shaft, tail, y - 0.08, y + 0.08);
    const double base = shaft + direction * 0.01;
    patch({{base, y - direction * 0.35}, {tip, y}, {base, y + direction * 0.35}});
  }

  void crossing() {
    const double x = l_.crossX;
    // Inner edge of the pedestrian crossings, which continue the sidewalks.
    const double inner = l_.crossEdge + Layout::kCurb;
    const double stop = l_.crossWalk + 1.0;
    for (const double side : {-1.0, 1.0}) {
      for (double y = -l_.roadEdge + 0.35; y + 0.5 < l_.roadEdge; y += 1.0) {
        bar(x + side * inner, x + side * l_.crossWalk, y, y + 0.5);
      }
      // Right-hand traffic: vehicles that drive to +x stop on the -x side of the cross street, in the lane at y < 0.
      const double lane = side * l_.roadEdge / 2;
      bar(x + side * stop, x + side * (stop + 0.5), lane - l_.roadEdge / 2 + 0.2, lane + l_.roadEdge / 2 - 0.2);
      arrow(x + side * (stop + 6), lane, -side);

      for (double u = x - l_.crossEdge + 0.25; u + 0.5 < x + l_.crossEdge; u += 1.0) {
        bar(u, u + 0.5, side * l_.walkInner, side * l_.walkOuter);
      }
      const double stopY = side * (l_.walkOuter + 1.0);
      const double crossLane = -side * l_.crossEdge / 2;  // vehicles drive to +y at x > crossX
      bar(x + crossLane - l_.crossEdge / 2 + 0.2, x + crossLane + l_.crossEdge / 2 - 0.2, stopY, stopY + side * 0.5);
      for (double y = l_.walkOuter + 2.5; y + 3 < l_.halfY; y += 9) {
        bar(x - kLine / 2, x + kLine / 2, side * y, side * (y + 3));
      }
    }
  }

  const Layout& l_;
  Shape shape_;
  SurfaceIndex paint_;
};

}  // namespace

Model makeMarkings(SceneBuilder& builder, const Layout& layout) {
  return Painter(builder, layout).paint();
}

}  // namespace scanmill::street
