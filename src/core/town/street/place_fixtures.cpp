// Places fixed objects along the street.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "town/street/placer.h"

namespace scanmill::street {
namespace {

// Places panels of 2 m from a to b, stretched to fill the distance.
void placeRow(Placer& placer, int& panels, const Model& m, Point2 a, Point2 b) {
  const Layout& l = placer.layout;
  const double dx = b.x - a.x;
  const double dy = b.y - a.y;
  const double length = std::hypot(dx, dy);
  if (length < 0.8) return;
  const int count = std::max(1, static_cast<int>(std::lround(length / 2)));
  const double yaw = std::atan2(dy, dx);
  for (int k = 0; k < count; ++k) {
    const Point2 p = lerp(a, b, (k + 0.5) / count);
    Affine place = at({p.x, p.y, l.heightAt(p.x, p.y)}, yaw);
    place.linear = place.linear * Mat3::scale({length / count / 2, 1, 1});
    placer.builder.place(m.mesh, placer.worldFromStreet * place, fmt::format("boundary {}", ++panels));
  }
  placer.occupancy.add({{(a.x + b.x) / 2, (a.y + b.y) / 2}, length / 2, (m.bounds.high.y - m.bounds.low.y) / 2, yaw});
}

}  // namespace

void placeTrafficLights(Placer& placer) {
  const Layout& l = placer.layout;
  if (!l.cross || l.p.signs == 0) return;
  const Model m = makeTrafficLight(placer.builder, l.seed);
  const double out = l.cornerRadius * 0.38;  // m from the edges of both roads: behind the rounded curb
  int number = 0;
  for (const int sx : {-1, 1}) {
    for (const int sy : {-1, 1}) {
      // Each light is at the right-hand curb of an approach and faces the approaching vehicles. The two lights with
      // sx = sy are for the main road.
      const Spot s{l.crossX + sx * (l.crossEdge + out), sy * (l.roadEdge + out),
                   sx == sy ? (sx > 0 ? 0.0 : kPi) : (sy > 0 ? kPi / 2 : -kPi / 2), 1, 0};
      placer.tryPut(m, s, fmt::format("traffic light {}", ++number));
    }
  }
}

void placeBoundaries(Placer& placer) {
  const Layout& l = placer.layout;
  if (l.p.boundaries == 0) return;
  int count = 0;
  std::array<Model, 5> panels{};
  for (const Fencing f : {Fencing::Pickets, Fencing::Bars, Fencing::Brick}) {
    panels[static_cast<std::size_t>(f)] = makeFencePanel(placer.builder, l.seed, f);
  }
  panels[static_cast<std::size_t>(Fencing::Hedge)] = makeHedge(placer.builder, l.seed);
  for (const Lot& lot : l.lots) {
    if (lot.fencing == Fencing::None) continue;
    const Model& m = panels[static_cast<std::size_t>(lot.fencing)];
    const double inset = lot.fencing == Fencing::Hedge ? 0.5 : 0.25;
    // Adds the boundary along the sidewalk, with gaps for driveway and walkway.
    std::vector<Span> gaps;
    for (const Span& s : {lot.driveway, lot.walkway}) {
      if (s.high > s.low) gaps.push_back({s.low - 0.15, s.high + 0.15});
    }
    std::sort(gaps.begin(), gaps.end(), [](const Span& a, const Span& b) { return a.low < b.low; });
    gaps.push_back({lot.x.high - 0.35, lot.x.high});
    double from = lot.x.low + 0.35;
    for (const Span& gap : gaps) {
      placeRow(placer, count, m, {from, lot.side * (l.walkOuter + inset)}, {gap.low, lot.side * (l.walkOuter + inset)});
      from = std::max(from, gap.high);
    }
    // Adds the boundary along the lot's side at high x, from the sidewalk back to the front of the house.
    const double x = lot.x.high - 0.35;
    placeRow(placer, count, m, {x, lot.side * (l.walkOuter + inset + 0.45)}, {x, lot.side * (l.front - 0.2)});
  }
}

void placeLamps(Placer& placer) {
  const Layout& l = placer.layout;
  const int count = l.p.count(l.p.lamps);
  if (count == 0) return;
  const std::array<Model, 2> forms{makeLamp(placer.builder, l.seed, 0), makeLamp(placer.builder, l.seed, 1)};
  for (int i = 0; i < count; ++i) {
    Draw draw(l.seed, Kind::Lamp, static_cast<std::uint32_t>(1000 + i));
    const int side = i % 2 == 0 ? 1 : -1;
    const double even = -l.halfLength + l.p.length * (i + 0.5) / count;
    placer.search(forms[draw.chance(0.8) ? 0 : 1], fmt::format("lamp {}", i + 1), [&] {
      const double x = even + draw.in(-3, 3);
      return Spot{x, side * (placer.walkFrom(x) + 0.3), -side * kPi / 2, 1, 0};
    });
  }
}

void placeSigns(Placer& placer) {
  const Layout& l = placer.layout;
  const int count = l.p.count(l.p.signs);
  const auto forms = makeForms(std::min(count, 8), [&](int f) {
    return makeSign(placer.builder, l.seed, static_cast<TrafficSign>(f % kSigns), f);
  });
  for (int i = 0; i < count; ++i) {
    Draw draw(l.seed, Kind::Sign, static_cast<std::uint32_t>(1000 + i));
    placer.search(forms[static_cast<std::size_t>(i) % forms.size()], fmt::format("sign {}", i + 1), [&] {
      Spot s = placer.onSidewalk(draw, 0, 0.8);
      const double side = s.at.y > 0 ? 1 : -1;
      s.at.y = side * (placer.walkFrom(s.at.x) + 0.5);
      s.yaw = (side < 0 ? kPi : 0) + draw.in(-0.12, 0.12);  // the sign faces vehicles on this side
      return s;
    });
  }
}

void placeShelters(Placer& placer) {
  const Layout& l = placer.layout;
  const int count = l.p.count(l.p.shelters);
  if (count == 0) return;
  const std::array<Model, 2> forms{makeShelter(placer.builder, l.seed), makeColumn(placer.builder, l.seed)};
  for (int i = 0; i < count; ++i) {
    Draw draw(l.seed, Kind::Shelter, static_cast<std::uint32_t>(1000 + i));
    const bool column = i % 2 == 1;
    placer.search(forms[column ? 1 : 0], fmt::format("shelter {}", i + 1), [&] {
      Spot s = placer.onSidewalk(draw, -0.75, 3);
      s.yaw = s.at.y > 0 ? 0 : kPi;
      return s;
    });
  }
}

void placeFurniture(Placer& placer) {
  const Layout& l = placer.layout;
  const int count = l.p.count(l.p.furniture);
  constexpr int kKinds = static_cast<int>(Furnishing::Count);
  const auto forms = makeForms(std::min(count, kKinds), [&](int f) {
    return makeFurnishing(placer.builder, l.seed, static_cast<Furnishing>(f));
  });
  for (int i = 0; i < count; ++i) {
    Draw draw(l.seed, Kind::Furniture, static_cast<std::uint32_t>(i));
    const int kind = i % kKinds;
    const auto what = static_cast<Furnishing>(kind);
    const bool atCurb = what == Furnishing::Hydrant || what == Furnishing::Bollard || what == Furnishing::Bin;
    placer.search(forms[static_cast<std::size_t>(kind)], fmt::format("furniture {}", i + 1), [&] {
      Spot s = placer.onSidewalk(draw, atCurb ? 0.35 : -0.4, 0.6);
      s.yaw = s.at.y > 0 ? 0 : kPi;  // the furniture's back is towards the gardens
      if (what == Furnishing::WheelieBin || what == Furnishing::LetterBox) s.yaw += -kPi / 2;
      s.yaw += draw.in(-0.08, 0.08);
      return s;
    });
  }
}

}  // namespace scanmill::street
