#include "town/street/placer.h"

#include <cmath>

namespace scanmill::street {
namespace {

void reserveHouses(Placer& placer) {
  const Layout& l = placer.layout;
  for (const House& h : l.houses) {
    const Vec3d c = h.place * Vec3d{h.width / 2, h.depth / 2, 0};
    const Vec3d x = h.place.linear.x;
    placer.occupancy.add({{c.x, c.y}, h.width / 2 + 0.5, h.depth / 2 + 0.5, std::atan2(x.y, x.x)});
    const Vec3d door = h.place * Vec3d{h.doorX(), -0.9, 0};  // the steps in front of the door
    placer.occupancy.add({{door.x, door.y}, 1.0, 1.0, std::atan2(x.y, x.x)});
  }
  for (const Lot& lot : l.lots) {
    for (const Span& s : {lot.walkway, lot.driveway}) {
      if (s.high <= s.low) continue;
      placer.occupancy.add({{(s.low + s.high) / 2, lot.side * (l.walkOuter + l.front) / 2},
                            (s.high - s.low) / 2,
                            l.p.frontGarden / 2,
                            0});
    }
  }
}

}  // namespace

void Placer::put(const Model& m, const Spot& s, std::string name, double sink) {
  builder.place(m.mesh, worldFromStreet * poseOf(s, layout.heightAt(s.at.x, s.at.y) - sink), std::move(name));
}

bool Placer::tryPut(const Model& m, const Spot& s, std::string name, double sink) {
  if (!occupancy.isFree(footprint(m, s, kGap))) return false;
  occupancy.add(footprint(m, s, 0));
  put(m, s, std::move(name), sink);
  return true;
}

double Placer::alongStreet(Draw& draw, double margin) const {
  return draw.in(-layout.halfLength + margin, layout.halfLength - margin);
}

bool Placer::nearCrossing(double x, double margin) const {
  return layout.cross && std::abs(x - layout.crossX) < layout.crossEdge + layout.cornerRadius + margin;
}

double Placer::walkFrom(double x) const {
  return layout.besideParking(x, 1) ? layout.walkInner : layout.roadEdge + Layout::kCurb;
}

Spot Placer::onSidewalk(Draw& draw, double from, double margin) const {
  Spot s;
  for (int k = 0; k < kTries; ++k) {
    s.at.x = alongStreet(draw, 3);
    const int side = draw.chance(0.5) ? 1 : -1;
    s.at.y = side * (from >= 0 ? layout.walkInner + from : layout.walkOuter + from);
    const auto on = [&](Span Lot::*strip) { return layout.onStrip(strip, s.at.x, side, margin); };
    if (!nearCrossing(s.at.x, margin) && !on(&Lot::driveway) && !on(&Lot::walkway)) break;
  }
  return s;
}

void populate(SceneBuilder& builder, const Layout& layout, const Affine& worldFromStreet) {
  Placer placer{builder, layout, worldFromStreet, {}};
  reserveHouses(placer);
  placeTrafficLights(placer);
  placeBoundaries(placer);
  placeLamps(placer);
  placeSigns(placer);
  placeShelters(placer);
  placeVehicles(placer);
  placeTrees(placer);
  placeFurniture(placer);
  placeBicycles(placer);
  placeBushes(placer);
  placePedestrians(placer);
}

}  // namespace scanmill::street
