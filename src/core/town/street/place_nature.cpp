// Places trees, bushes and pedestrians.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "town/street/placer.h"

namespace scanmill::street {

void placeTrees(Placer& placer) {
  const Layout& l = placer.layout;
  const int count = l.p.count(l.p.trees);
  const auto forms = makeForms(count > 0 ? kTreeForms : 0, [&](int f) { return makeTree(placer.builder, l.seed, f); });
  for (int i = 0; i < count; ++i) {
    Draw draw(l.seed, Kind::Tree, static_cast<std::uint32_t>(1000 + i));
    const bool inFront = i % 2 == 0;
    for (int k = 0; k < Placer::kTries; ++k) {
      const int side = draw.chance(0.5) ? 1 : -1;
      // Conifers have branches down to the ground, so they are placed only behind the houses.
      const auto form = static_cast<std::size_t>(draw.below(inFront ? kBroadleafForms : kTreeForms));
      Spot s;
      s.at.x = placer.alongStreet(draw, 2);
      s.yaw = draw.in(0, 2 * kPi);
      s.scale = draw.in(0.8, 1.2);
      const TreeModel& tree = forms[form];
      if (inFront) {
        // The crown must end before the wall of a house.
        const double room = l.p.frontGarden - 1.2;
        s.scale = std::min(s.scale, room / tree.crownRadius);
        if (s.scale < 0.55) continue;
        s.at.y = side * (l.front - 0.2 - tree.crownRadius * s.scale * 1.05);
        if (placer.nearCrossing(s.at.x, 0)) continue;
      } else {
        s.at.y = side * draw.in(l.front + 14, l.halfY - 4);
        if (l.cross && std::abs(s.at.x - l.crossX) < l.crossWalk + 2.5) continue;
      }
      const double reach = tree.crownRadius * s.scale * (inFront ? 0.35 : 0.75);
      const Footprint around{{s.at.x, s.at.y}, reach, reach, 0};
      if (!placer.occupancy.isFree(around)) continue;
      placer.occupancy.add({{s.at.x, s.at.y}, 0.5, 0.5, 0});
      placer.put(tree.model, s, fmt::format("tree {}", i + 1), 0.05);
      break;
    }
  }
}

void placeBushes(Placer& placer) {
  const Layout& l = placer.layout;
  const int count = l.p.count(l.p.bushes);
  const auto forms = makeForms(std::min(count, 5), [&](int f) { return makeBush(placer.builder, l.seed, f); });
  for (int i = 0; i < count; ++i) {
    Draw draw(l.seed, Kind::Bush, static_cast<std::uint32_t>(1000 + i));
    const Model& m = draw.of(forms);
    placer.search(
        m, fmt::format("bush {}", i + 1),
        [&] {
          Spot s{placer.alongStreet(draw, 2), 0, draw.in(0, 2 * kPi), draw.in(0.7, 1.2), 0};
          const double reach = m.bounds.high.x * s.scale;
          const double near = l.walkOuter + 0.4 + reach;
          const double far = l.front - reach;
          const bool back = draw.chance(0.35) || near > far;
          s.at.y = draw.sign() * (back ? draw.in(l.front + 14, l.front + 30) : draw.in(near, far));
          if (placer.nearCrossing(s.at.x, 1)) s.at.x += (s.at.x > l.crossX ? 1 : -1) * (l.cornerRadius + 4);
          return s;
        },
        0.03);
  }
}

void placePedestrians(Placer& placer) {
  const Layout& l = placer.layout;
  const int count = l.p.count(l.p.pedestrians);
  const auto forms = makeForms(std::min(count, 8), [&](int f) { return makePedestrian(placer.builder, l.seed, f); });
  for (int i = 0; i < count; ++i) {
    Draw draw(l.seed, Kind::Person, static_cast<std::uint32_t>(1000 + i));
    const Model& m = forms[static_cast<std::size_t>(i) % forms.size()];
    const bool onZebra = l.cross && i % 8 == 5;
    placer.search(m, fmt::format("pedestrian {}", i + 1), [&] {
      Spot s;
      s.scale = draw.in(0.96, 1.04);
      // On a zebra the pedestrian crosses the cross street.
      s.at.x = onZebra ? l.crossX + draw.in(-0.7, 0.7) * l.crossEdge : placer.alongStreet(draw, 1);
      s.at.y = draw.sign() * draw.in(l.walkInner + 0.4, l.walkOuter - 0.4);
      s.yaw = (draw.chance(0.5) ? 0 : kPi) + draw.in(-0.25, 0.25);
      return s;
    });
  }
}

}  // namespace scanmill::street
