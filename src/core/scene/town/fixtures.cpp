// What stands beside roads: lamps, signs, furniture, shelters; and the paint on them.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "scene/town/lanes.h"
#include "scene/town/placer.h"

namespace scanmill::town {
namespace {

using parts::Furnishing;
using parts::Kind;
using parts::Shape;

// Where along the built part of a road something may stand, by a share of it.
struct Stretch {
  std::uint32_t road;
  double from, to;
};

std::vector<Stretch> stretches(const Layout& l) {
  std::vector<Stretch> found;
  for (std::uint32_t r = 0; r < l.roads().roads().size(); ++r) {
    const Road& road = l.roads().roads()[r];
    if (road.minor) continue;
    found.push_back(road.main ? Stretch{r, l.mainFrom(), l.mainTo()} : Stretch{r, 10, road.length() - 3});
  }
  return found;
}

// On the pavement or the verge at so much from the curb's outer edge; not where another road comes in.
template <class Place>
void along(const Layout& l, Kind kind, double per100m, const Place& place) {
  std::uint32_t number = 0;
  for (const Stretch& s : stretches(l)) {
    const Road& road = l.roads().roads()[s.road];
    Draw draw(l.seed(), kind, 5000 + s.road);
    const int count = static_cast<int>(per100m * std::max(0.0, s.to - s.from) / 100 + draw.next());
    for (int k = 0; k < count; ++k) {
      for (int attempt = 0; attempt < Placer::kTries; ++attempt) {
        if (place(draw, road, draw.in(s.from, s.to), draw.chance(0.5) ? 1 : -1, number + 1)) {
          ++number;
          break;
        }
      }
    }
  }
}

// The place `out` metres beyond the road's edge, or none where that is on another road.
bool beyondEdge(const Layout& l, const Road& road, double distance, int side, double out, Spot& spot) {
  spot = besideRoad(road, distance, side * (road.section.half + out));
  const Beside b = l.roads().at(spot.at.x, spot.at.y);
  return b.edge > out - 0.25 && l.areas().outsideHard(spot.at) > 0.3;
}

}  // namespace

void placeFixtures(Placer& placer) {
  const Layout& l = placer.layout;
  const Character& c = l.character();
  const std::uint64_t seed = l.seed();
  const auto lamps = parts::makeForms(2, [&](int f) { return parts::makeLamp(placer.builder, seed, f); });
  const auto signs = parts::makeForms(6, [&](int f) { return parts::makeSign(placer.builder, seed, f); });
  const auto furnishings = parts::makeForms(static_cast<int>(Furnishing::Count), [&](int f) {
    return parts::makeFurnishing(placer.builder, seed, static_cast<Furnishing>(f));
  });
  const bool rural = c.district == District::Rural;
  for (const Stretch& s : stretches(l)) {
    const Road& road = l.roads().roads()[s.road];
    Draw draw(seed, Kind::Lamp, 5000 + s.road);
    const double spacing = rural ? draw.in(60, 120) : draw.in(22, 40);
    const int side = draw.chance(0.5) ? 1 : -1;
    const Model& lamp = lamps[static_cast<std::size_t>(draw.below(2))];
    int number = 0;
    for (const double at : parts::steps(s.from + draw.in(3, spacing), s.to, spacing)) {
      Spot spot;
      if (!beyondEdge(l, road, at, side, road.section.curb + 0.45, spot)) continue;
      spot.yaw += -side * kPi / 2;  // its arm reaches over the road
      if (placer.tryPut(lamp, spot, fmt::format("lamp {}.{}", s.road + 1, ++number))) continue;
    }
  }
  constexpr std::array<std::size_t, 4> kOnTheWay{0, 1, 2, 4};  // forms of signs: see makeSign()
  constexpr std::size_t kStop = 3;
  constexpr std::size_t kGiveWay = 5;
  along(l, Kind::Sign, rural ? 1.5 : 5, [&](Draw& draw, const Road& road, double at, int side, std::uint32_t number) {
    Spot spot;
    if (!beyondEdge(l, road, at, side, road.section.curb + draw.in(0.35, 0.7), spot)) return false;
    // It faces those who drive on its side: on the right of the line they come from behind.
    spot.yaw += (side < 0 ? kPi : 0) + draw.in(-0.15, 0.15);
    return placer.tryPut(signs[kOnTheWay[static_cast<std::size_t>(draw.below(4))]], spot,
                         fmt::format("sign {}", number));
  });
  // Who comes out of a side road stops there, or gives way.
  for (std::uint32_t r = 0; r < l.roads().roads().size(); ++r) {
    const Road& road = l.roads().roads()[r];
    Draw draw(seed, Kind::Sign, 9000 + r);
    const std::size_t form = draw.chance(0.3) ? kStop : kGiveWay;
    if (!road.joins || road.minor || draw.chance(0.3)) continue;
    for (const double back : {1.0, 2.5, 4.0, 6.0}) {
      Spot spot;
      if (!beyondEdge(l, road, mouthOf(l) + back, 1, road.section.curb + 0.5, spot)) continue;
      if (placer.tryPut(signs[form], spot, fmt::format("sign at a mouth {}", r))) break;
    }
  }
  if (!rural) {
    const Model shelter = parts::makeShelter(placer.builder, seed);
    along(l, Kind::Shelter, 0.5, [&](Draw&, const Road& road, double at, int side, std::uint32_t number) {
      Spot spot;
      if (road.section.verge + road.section.sidewalk < 2.4) return false;
      if (!beyondEdge(l, road, at, side, road.section.outer() - 0.9, spot)) return false;
      spot.yaw += side > 0 ? 0 : kPi;
      return placer.tryPut(shelter, spot, fmt::format("shelter {}", number));
    });
  }
  along(l, Kind::Furniture, c.clutter, [&](Draw& draw, const Road& road, double at, int side, std::uint32_t number) {
    Spot spot;
    const bool inside = draw.chance(0.5);
    const double out = inside ? road.section.curb + draw.in(0.3, 0.6) : road.section.outer() + draw.in(-0.5, 1.5);
    if (!beyondEdge(l, road, at, side, out, spot)) return false;
    spot.yaw += (side > 0 ? 0 : kPi) + draw.in(-0.3, 0.3);
    const Model& m = furnishings[static_cast<std::size_t>(draw.below(static_cast<int>(furnishings.size())))];
    return placer.tryPut(m, spot, fmt::format("furniture {}", number));
  });
}

// A dashed line in the middle of the roads that are wide enough for two, and edge lines in the country.
void placeMarkings(Placer& placer) {
  const Layout& l = placer.layout;
  Shape s(placer.builder, "road markings");
  const parts::SurfaceIndex paint = s.surface("road_marking", "road_paint");
  const auto corner = [&](const Road& road, double along, double lateral) {
    const Point2 p = besideRoad(road, along, lateral).at;
    return Vec3d{p.x, p.y, l.heightAt(p) + 0.004};
  };
  std::uint32_t dashes = 0;
  for (const Road& road : l.roads().roads()) {
    const double lanes = road.section.half - road.section.parking;
    if (lanes < 2.6) continue;
    Draw draw(l.seed(), Kind::Markings, static_cast<std::uint32_t>(&road - l.roads().roads().data()));
    if (!draw.chance(road.main ? 0.8 : 0.35)) continue;
    const double dash = draw.in(2, 5);
    const double gap = dash * draw.in(1, 2);
    const bool edges = l.character().district == District::Rural && draw.chance(0.6);
    for (double at = 4; at + dash < road.length() - 4; at += dash + gap) {
      const Point2 middle = road.point(at + dash / 2);
      // Not where another road joins.
      const Beside b = l.roads().at(middle.x, middle.y);
      if (b.edge < -road.section.half - 0.5) continue;
      const int pieces = 3;
      for (int k = 0; k < pieces; ++k) {
        const double from = at + dash * k / pieces;
        const double to = at + dash * (k + 1) / pieces;
        s.quad(paint, corner(road, from, -0.06), corner(road, to, -0.06), corner(road, to, 0.06),
               corner(road, from, 0.06));
      }
      ++dashes;
      if (!edges) continue;
      for (const double side : {-1.0, 1.0}) {
        const double out = side * (lanes - 0.25);
        s.quad(paint, corner(road, at, out - 0.06), corner(road, at + dash, out - 0.06),
               corner(road, at + dash, out + 0.06), corner(road, at, out + 0.06));
      }
    }
  }
  if (dashes > 0) placer.builder.place(s.finish().mesh, placer.worldFromTown, "road markings");
}

// Manhole covers, and where roads were mended with newer asphalt.
void placeCovers(Placer& placer) {
  const Layout& l = placer.layout;
  Shape s(placer.builder, "manholes and repairs");
  const parts::SurfaceIndex iron = s.surface("road", "metal_bare");
  const parts::SurfaceIndex fresh = s.surface("road", "asphalt_new");
  const auto corner = [&](const Road& road, double along, double lateral, double above) {
    const Point2 p = besideRoad(road, along, lateral).at;
    return Vec3d{p.x, p.y, l.heightAt(p) + above};
  };
  // A grid of quads that follows the road, in pieces of at most half a metre.
  const auto cover = [&](const Road& road, double from, double to, double right, double left) {
    constexpr double kAbove = 0.005;  // m
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
  for (std::uint32_t r = 0; r < l.roads().roads().size(); ++r) {
    const Road& road = l.roads().roads()[r];
    Draw draw(l.seed(), Kind::Cover, r);
    const double half = road.section.half - road.section.parking - 0.3;
    const double covers = l.character().district == District::Rural ? 0.3 : 3;
    const auto manholes = static_cast<int>(covers * road.length() / 100 + draw.next());
    for (int k = 0; k < manholes; ++k) {
      const double along = draw.in(4, road.length() - 4);
      const double lateral = draw.in(-half + 0.3, half - 0.3);
      constexpr int kCorners = 16;
      constexpr double kRadius = 0.31;  // m
      const Vec3d middle = corner(road, along, lateral, 0.004);
      if (l.nearPothole({middle.x, middle.y}, kRadius)) continue;
      const auto rim = [&](int i) {
        const double angle = 2 * kPi * i / kCorners;
        const Point2 p{middle.x + kRadius * std::cos(angle), middle.y + kRadius * std::sin(angle)};
        return Vec3d{p.x, p.y, l.heightAt(p) + 0.004};
      };
      for (int i = 0; i < kCorners; ++i) s.triangle(iron, middle, rim(i), rim(i + 1));
      ++count;
    }
    const auto repairs = static_cast<int>(8 * l.character().wear * road.length() / 100 + draw.next());
    for (int k = 0; k < repairs; ++k) {
      const double along = draw.in(4, road.length() - 12);
      const double width = draw.in(0.5, 2);
      const double right = draw.in(-half, half - width);
      const double length = draw.in(0.8, 8);
      const Point2 middle = besideRoad(road, along + length / 2, right + width / 2).at;
      const Beside b = l.roads().at(middle.x, middle.y);
      // Not where another road joins, nor into a hole.
      if (b.edge < -road.section.half - 0.5 || l.nearPothole(middle, std::hypot(length, width) / 2)) continue;
      cover(road, along, along + length, right, right + width);
      ++count;
    }
  }
  if (count > 0) placer.builder.place(s.finish().mesh, placer.worldFromTown, "road covers");
}

}  // namespace scanmill::town
