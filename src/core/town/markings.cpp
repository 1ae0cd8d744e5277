// Places road markings, manhole covers and repairs.

#include <cmath>

#include "town/lanes.h"
#include "town/placer.h"

namespace scanmill::town {
namespace {

using models::Kind;
using models::Shape;
using models::TrafficSign;

constexpr double kMarkingHeight = 0.004;  // m, height of markings and manhole covers above the road
constexpr double kEndOfRoad = 4;          // m, length without dashes, covers and repairs at each end of a road
constexpr double kHalfLine = 0.06;        // m, half of the width of a dashed line

// Paints a stop line (solid) or give-way line (dashed) for vehicles that drive against the direction of the road's
// centre line and stop at `along` (m along the centre line), 0.1 m before the paint. Returns the number of pieces.
std::uint32_t paintStopLine(const Layout& l, Shape& s, models::SurfaceIndex paint, const Road& road, double along,
                            TrafficSign sign) {
  const bool solid = sign == TrafficSign::Stop;
  constexpr double kGap = 0.15;  // m between the line and the lane's edges
  const double left = road.section.half - road.section.parking - kGap;
  const double right = road.oneWay() ? -left : kGap;
  const models::Span thickness{along - (solid ? 0.6 : 0.4), along - 0.1};
  const double piece = solid ? 0.7 : 0.5;  // m, length of a piece; short pieces follow the road's camber
  const std::vector<double> starts = models::steps(right, left, solid ? piece : 2 * piece);
  for (const double start : starts) paintBar(s, paint, l, road, thickness, {start, std::min(start + piece, left)});
  return static_cast<std::uint32_t>(starts.size());
}

// Paints the stop lines at signs and lights. Returns the number of pieces of all stop lines.
std::uint32_t paintStopLines(const Placer& placer, Shape& s, models::SurfaceIndex paint) {
  const Layout& l = placer.layout;
  std::uint32_t pieces = 0;
  for (const Road& road : l.roads()) {
    const std::optional<TrafficSign> sign = signAtMouth(l, road);
    if (sign) pieces += paintStopLine(l, s, paint, road, stopLineOfSideRoad(l), *sign);
  }
  for (const Placer::Light& light : placer.lights) {
    if (light.marked) pieces += paintStopLine(l, s, paint, l.mainRoad(), light.stopAgainstLine, TrafficSign::Stop);
  }
  return pieces;
}

// True if another road joins `road` at `middle`: no dashes or repairs are placed there.
bool isJoint(const Layout& l, const Road& road, const Point2& middle) {
  constexpr double kInside = 0.5;  // m; at joints, the edge is farther away by more than this
  return l.besideAt(middle).edge < -road.section.half - kInside;
}

// Paints a dash in pieces that follow the ground. `start`: m along the road's line; `lateral`: m to the line's left.
void paintDash(Shape& s, models::SurfaceIndex paint, const Layout& l, const Road& road, double start, double length,
               double lateral, int pieces) {
  for (int k = 0; k < pieces; ++k) {
    paintBar(s, paint, l, road, {start + length * k / pieces, start + length * (k + 1) / pieces},
             {lateral - kHalfLine, lateral + kHalfLine});
  }
}

// Paints a road's dashed lines, with random lengths of dashes and gaps. Returns the number of dashes of each line.
std::uint32_t paintDashedLines(Shape& s, models::SurfaceIndex paint, const Layout& l, const Road& road, Draw& draw) {
  constexpr double kFromEdge = 0.25;  // m from an edge line to the edge of the lanes
  const double length = draw.in(2, 5);
  const double gap = length * draw.in(1, 2);
  const bool edgeLines = l.character.country && draw.chance(0.6);
  const double edge = road.section.half - road.section.parking - road.section.shoulder;  // m from the middle
  std::vector<double> lines;  // m to the left of the road's middle
  if (road.section.median <= 0) lines.push_back(0);
  for (int lane = 1; lane < road.section.lanes; ++lane) {
    for (const double side : {-1.0, 1.0}) {
      lines.push_back(side * (road.section.median + lane * road.section.laneWidth()));
    }
  }
  std::uint32_t dashes = 0;
  for (double start = kEndOfRoad; start + length < road.length() - kEndOfRoad; start += length + gap) {
    if (isJoint(l, road, road.point(start + length / 2))) continue;
    for (const double line : lines) paintDash(s, paint, l, road, start, length, line, 3);
    ++dashes;
    if (!edgeLines) continue;
    for (const double side : {-1.0, 1.0}) {
      paintDash(s, paint, l, road, start, length, side * (edge - kFromEdge), 1);
    }
  }
  return dashes;
}

// Adds a manhole cover. At a pothole, returns false and adds nothing.
bool addManhole(Shape& s, models::SurfaceIndex iron, const Layout& l, const Point2& middle) {
  constexpr int kCorners = 16;
  constexpr double kRadius = 0.31;  // m, radius of a manhole cover
  if (l.nearPothole(middle, kRadius)) return false;
  const Vec3d center = l.onGround(middle, kMarkingHeight);
  std::vector<Vec3d> rim;
  for (const Point2& p : models::regularPolygon(kCorners, kRadius)) {
    rim.push_back(l.onGround({middle.x + p.x, middle.y + p.y}, kMarkingHeight));
  }
  for (std::size_t i = 0; i < kCorners; ++i) s.triangle(iron, center, rim[i], rim[(i + 1) % kCorners]);
  return true;
}

// Adds a rectangle of newer asphalt: a grid of quads, at most 0.5 m long and wide, that follows the road's surface.
// `along`: extent along the road's line (m); `lateral`: extent to the left of the line (m).
void addRepair(Shape& s, models::SurfaceIndex asphalt, const Layout& l, const Road& road, const models::Span& along,
               const models::Span& lateral) {
  constexpr double kAboveRoad = 0.005;  // m, height of the quads above the road
  const double length = along.high - along.low;
  const double width = lateral.high - lateral.low;
  const auto rows = static_cast<int>(std::ceil(length / 0.5));
  const auto columns = static_cast<int>(std::ceil(width / 0.5));
  std::vector<std::vector<Vec3d>> grid;
  for (int r = 0; r <= rows; ++r) {
    std::vector<Vec3d>& row = grid.emplace_back();
    for (int c = 0; c <= columns; ++c) {
      const Spot spot = besideRoad(road, along.low + length * r / rows, lateral.high - width * c / columns);
      row.push_back(l.onGround(spot.at, kAboveRoad));
    }
  }
  s.grid(grid, models::Loop::Open, asphalt);
}

}  // namespace

void paintBar(Shape& s, models::SurfaceIndex paint, const Layout& l, const Road& road, const models::Span& along,
              const models::Span& lateral) {
  const auto corner = [&](double u, double v) { return l.onGround(besideRoad(road, u, v).at, kMarkingHeight); };
  s.quad(paint, corner(along.low, lateral.low), corner(along.high, lateral.low), corner(along.high, lateral.high),
         corner(along.low, lateral.high));
}

// Paints stop lines, dashed lines between lanes and in the middle of some roads, and edge lines outside of towns.
void placeMarkings(Placer& placer) {
  constexpr double kNarrow = 2.6;  // m; narrower lanes are not marked
  const Layout& l = placer.layout;
  Shape s(placer.builder, "road markings");
  const models::SurfaceIndex paint = s.surface("road_marking", "road_paint");
  std::uint32_t painted = paintStopLines(placer, s, paint);
  for (const Road& road : l.roads()) {
    if (road.section.laneWidth() < kNarrow) continue;
    Draw draw(l.seed, Kind::Markings, road.number);
    if (!draw.chance(road.section.lanes > 1 ? 1 : road.main ? 0.8 : 0.35)) continue;
    painted += paintDashedLines(s, paint, l, road, draw);
  }
  if (painted > 0) placer.putShape(s);
}

// Places manhole covers and then, with the same random stream, repairs, which are rectangles of newer asphalt.
void placeCovers(Placer& placer) {
  const Layout& l = placer.layout;
  Shape s(placer.builder, "manholes and repairs");
  const auto [iron, asphalt] = s.surfaces("road", "metal_bare", "asphalt_new");
  int covers = 0;
  for (const Road& road : l.roads()) {
    Draw draw(l.seed, Kind::Cover, road.number);
    const double half = road.section.half - road.section.parking - 0.3;  // m from the middle to the covers' edge
    const double manholesPer100m = l.character.country ? 0.3 : 3;
    const auto manholes = static_cast<int>(manholesPer100m * road.length() / 100 + draw.next());
    for (int k = 0; k < manholes; ++k) {
      const double along = draw.in(kEndOfRoad, road.length() - kEndOfRoad);
      const double lateral = draw.in(-half + 0.3, half - 0.3);
      if (addManhole(s, iron, l, besideRoad(road, along, lateral).at)) ++covers;
    }
    constexpr double kMostRepairsPer100m = 8;
    const auto repairs = static_cast<int>(kMostRepairsPer100m * l.character.wear * road.length() / 100 + draw.next());
    for (int k = 0; k < repairs; ++k) {
      const double along = draw.in(kEndOfRoad, road.length() - 12);
      const double width = draw.in(0.5, 2);
      const double right = draw.in(-half, half - width);
      const double length = draw.in(0.8, 8);
      const Point2 middle = besideRoad(road, along + length / 2, right + width / 2).at;
      if (isJoint(l, road, middle) || l.nearPothole(middle, std::hypot(length, width) / 2)) continue;
      addRepair(s, asphalt, l, road, {along, along + length}, {right, right + width});
      ++covers;
    }
  }
  if (covers > 0) placer.builder.place(s.finish().mesh, placer.worldFromTown, "road covers");
}

}  // namespace scanmill::town
