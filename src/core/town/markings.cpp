// Places road markings, manhole covers and repairs.

#include <cmath>

#include "town/lanes.h"
#include "town/placer.h"

namespace scanmill::town {
namespace {

using models::Kind;
using models::Shape;
using models::TrafficSign;

// Paints a stop line at `along` (m) across the lane for vehicles that drive against the road's line: a solid line if
// `whole`, else a dashed line. Returns the number of its pieces.
std::uint32_t stopLine(const Layout& l, Shape& s, models::SurfaceIndex paint, const Road& road, double along,
                       bool whole) {
  constexpr double kGap = 0.15;  // m between the line and the lane's edges
  const double left = road.section.half - road.section.parking - kGap;
  const double right = road.oneWay() ? -left : kGap;
  const double from = along - (whole ? 0.6 : 0.4);
  const double to = along - 0.1;
  const double piece = whole ? 0.7 : 0.5;  // m, length of a piece; it is short, to follow the road's camber
  std::uint32_t lines = 0;
  for (const double start : models::steps(right, left, whole ? piece : 2 * piece)) {
    paintBar(s, paint, l, road, from, to, start, std::min(start + piece, left));
    ++lines;
  }
  return lines;
}

// Paints the stop lines at signs and lights. Returns the number of pieces of all stop lines.
std::uint32_t stopLines(const Placer& placer, Shape& s, models::SurfaceIndex paint) {
  const Layout& l = placer.layout;
  std::uint32_t lines = 0;
  for (const Road& road : l.roads()) {
    if (const std::optional<TrafficSign> sign = signAtMouth(l, road)) {
      lines += stopLine(l, s, paint, road, stopLineOfSideRoad(l), *sign == TrafficSign::Stop);
    }
  }
  for (const Placer::Light& light : placer.lights) {
    if (light.marked) lines += stopLine(l, s, paint, l.mainRoad(), light.along, true);
  }
  return lines;
}

}  // namespace

void paintBar(Shape& s, models::SurfaceIndex paint, const Layout& l, const Road& road, double from, double to,
              double right, double left) {
  constexpr double kAbove = 0.004;  // m, height of markings above the road
  const auto corner = [&](double along, double lateral) {
    return l.onGround(besideRoad(road, along, lateral).at, kAbove);
  };
  s.quad(paint, corner(from, right), corner(to, right), corner(to, left), corner(from, left));
}

// Paints stop lines, dashed lines between lanes, and dashed middle lines on some roads without a central reservation.
// Some roads outside of towns get dashed edge lines too.
void placeMarkings(Placer& placer) {
  const Layout& l = placer.layout;
  Shape s(placer.builder, "road markings");
  const models::SurfaceIndex paint = s.surface("road_marking", "road_paint");
  std::uint32_t dashes = stopLines(placer, s, paint);
  for (const Road& road : l.roads()) {
    const double lanes = road.section.half - road.section.parking - road.section.shoulder;
    if (road.section.laneWidth() < 2.6) continue;
    Draw draw(l.seed, Kind::Markings, road.number);
    if (!draw.chance(road.section.lanes > 1 ? 1 : road.main ? 0.8 : 0.35)) continue;
    const double dash = draw.in(2, 5);
    const double gap = dash * draw.in(1, 2);
    const bool edges = l.character.country && draw.chance(0.6);
    for (double at = 4; at + dash < road.length() - 4; at += dash + gap) {
      const Point2 middle = road.point(at + dash / 2);
      // Leaves out the line where another road joins.
      const Beside b = l.besideAt(middle);
      if (b.edge < -road.section.half - 0.5) continue;
      const int pieces = 3;
      for (int lane = road.section.median > 0 ? 1 : 0; lane < road.section.lanes; ++lane) {
        for (const double side : {-1.0, 1.0}) {
          if (lane == 0 && side < 0) continue;  // the middle line
          const double middleOfLine = lane == 0 ? 0 : side * (road.section.median + lane * road.section.laneWidth());
          for (int k = 0; k < pieces; ++k) {
            paintBar(s, paint, l, road, at + dash * k / pieces, at + dash * (k + 1) / pieces, middleOfLine - 0.06,
                     middleOfLine + 0.06);
          }
        }
      }
      ++dashes;
      if (!edges) continue;
      for (const double side : {-1.0, 1.0}) {
        const double out = side * (lanes - 0.25);
        paintBar(s, paint, l, road, at, at + dash, out - 0.06, out + 0.06);
      }
    }
  }
  if (dashes > 0) placer.builder.place(s.finish().mesh, placer.worldFromTown, "road markings");
}

// Places manhole covers, and rectangles of newer asphalt where roads were repaired.
void placeCovers(Placer& placer) {
  const Layout& l = placer.layout;
  Shape s(placer.builder, "manholes and repairs");
  const models::SurfaceIndex iron = s.surface("road", "metal_bare");
  const models::SurfaceIndex fresh = s.surface("road", "asphalt_new");
  const auto corner = [&](const Road& road, double along, double lateral, double above) {
    return l.onGround(besideRoad(road, along, lateral).at, above);
  };
  // Adds a grid of quads that follows the road's surface. A quad is at most half a metre long and wide.
  const auto cover = [&](const Road& road, double from, double to, double right, double left) {
    constexpr double kAbove = 0.005;  // m, height of the quads above the road
    const auto rows = static_cast<int>(std::ceil((to - from) / 0.5));
    const auto columns = static_cast<int>(std::ceil((left - right) / 0.5));
    std::vector<std::vector<Vec3d>> grid;
    for (int r = 0; r <= rows; ++r) {
      std::vector<Vec3d>& row = grid.emplace_back();
      for (int c = 0; c <= columns; ++c) {
        row.push_back(corner(road, from + (to - from) * r / rows, left + (right - left) * c / columns, kAbove));
      }
    }
    s.grid(grid, false, [&](int, int) { return fresh; });
  };
  int count = 0;
  for (const Road& road : l.roads()) {
    Draw draw(l.seed, Kind::Cover, road.number);
    const double half = road.section.half - road.section.parking - 0.3;
    const double covers = l.character.country ? 0.3 : 3;
    const auto manholes = static_cast<int>(covers * road.length() / 100 + draw.next());
    for (int k = 0; k < manholes; ++k) {
      const double along = draw.in(4, road.length() - 4);
      const double lateral = draw.in(-half + 0.3, half - 0.3);
      constexpr int kCorners = 16;
      constexpr double kRadius = 0.31;  // m, radius of a manhole cover
      const Vec3d middle = corner(road, along, lateral, 0.004);
      if (l.nearPothole({middle.x, middle.y}, kRadius)) continue;
      const auto rim = [&](int i) {
        const double angle = 2 * kPi * i / kCorners;
        return l.onGround({middle.x + kRadius * std::cos(angle), middle.y + kRadius * std::sin(angle)}, 0.004);
      };
      for (int i = 0; i < kCorners; ++i) s.triangle(iron, middle, rim(i), rim(i + 1));
      ++count;
    }
    const auto repairs = static_cast<int>(8 * l.character.wear * road.length() / 100 + draw.next());
    for (int k = 0; k < repairs; ++k) {
      const double along = draw.in(4, road.length() - 12);
      const double width = draw.in(0.5, 2);
      const double right = draw.in(-half, half - width);
      const double length = draw.in(0.8, 8);
      const Point2 middle = besideRoad(road, along + length / 2, right + width / 2).at;
      const Beside b = l.besideAt(middle);
      // There are no repairs where another road joins, and none over a pothole.
      if (b.edge < -road.section.half - 0.5 || l.nearPothole(middle, std::hypot(length, width) / 2)) continue;
      cover(road, along, along + length, right, right + width);
      ++count;
    }
  }
  if (count > 0) placer.builder.place(s.finish().mesh, placer.worldFromTown, "road covers");
}

}  // namespace scanmill::town
