// Places guard rails and noise barriers along motorways.

#include <fmt/format.h>

#include <cmath>

#include "town/placer.h"

namespace scanmill::town {
namespace {

using models::Fencing;

constexpr double kPanel = 2;  // m, length of a panel

// Places a row of panels from `from` to `to` (m along the main road), `lateral` metres to the left of its line. Panels
// face to the left of the line if `facesLeft` is true. `up`: factor on their height.
void placeRow(Placer& placer, const Model& panel, double from, double to, double lateral, bool facesLeft, double up,
              const std::string& name) {
  const Road& road = placer.layout.roads().roads().front();
  int number = 0;
  for (const double at : models::steps(from, to, kPanel)) {
    const Spot spot = besideRoad(road, at + kPanel / 2, lateral);
    const Point2 first = besideRoad(road, at, lateral).at;
    const Point2 last = besideRoad(road, at + kPanel, lateral).at;
    Affine place = models::at(placer.layout.onGround(spot.at, -0.03), spot.yaw + (facesLeft ? kPi : 0));
    place.linear = place.linear * Mat3::scale({distance(first, last) / kPanel, 1, up});
    placer.builder.place(panel.mesh, placer.worldFromTown * place, fmt::format("{} {}", name, ++number));
    placer.occupancy.add({spot.at, kPanel / 2, 0.2, spot.yaw});
  }
}

}  // namespace

void placeRails(Placer& placer) {
  const Layout& l = placer.layout;
  const Road& road = l.roads().roads().front();
  if (l.character().district != District::Motorway || road.section.median <= 0) return;
  Draw draw(l.seed(), models::Kind::Rails);
  const auto panel = [&](Fencing what) { return models::makeFencePanel(placer.builder, l.seed(), what); };
  const Model rail = panel(Fencing::GuardRail);
  const double length = road.length();
  if (draw.chance(0.5)) {
    placeRow(placer, panel(Fencing::Barrier), 2, length - 2, 0, false, 1, "median barrier");
  } else {
    placeRow(placer, rail, 2, length - 2, 0.15, true, 1, "median rail to the left");
    placeRow(placer, rail, 2, length - 2, -0.15, false, 1, "median rail to the right");
  }
  for (const double side : {-1.0, 1.0}) {
    const bool left = side > 0;
    const double edge = road.section.half + 0.6;
    const double begin = draw.in(2, 60);
    const double end = length - draw.in(2, 60);
    placeRow(placer, rail, begin, end, side * edge, !left, 1, left ? "left rail" : "right rail");
    if (!draw.chance(0.4)) continue;
    const double from = draw.in(10, length / 2);
    const double to = from + draw.in(60, length / 2 - 12);
    const double beyond = draw.in(2.5, 5);
    const double up = draw.in(1.6, 2.4);
    placeRow(placer, panel(Fencing::Boards), from, to, side * (edge + beyond), !left, up,
             left ? "left noise barrier" : "right noise barrier");
  }
}

}  // namespace scanmill::town
