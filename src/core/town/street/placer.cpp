#include "town/street/placer.h"

#include <algorithm>
#include <cmath>

namespace scanmill::street {
namespace {

bool onWalkway(const Layout& layout, double x, int side, double margin) {
  return std::any_of(layout.lots.begin(), layout.lots.end(), [&](const Lot& lot) {
    return lot.side == side && lot.walkway.high > lot.walkway.low && x > lot.walkway.low - margin &&
           x < lot.walkway.high + margin;
  });
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
  const bool parking = std::any_of(layout.parking.begin(), layout.parking.end(),
                                   [&](const Span& s) { return x > s.low - 1 && x < s.high + 1; });
  return parking ? layout.walkInner : layout.roadEdge + Layout::kCurb;
}

Spot Placer::onSidewalk(Draw& draw, double from, double margin) const {
  Spot s;
  for (int k = 0; k < kTries; ++k) {
    s.at.x = alongStreet(draw, 3);
    const int side = draw.chance(0.5) ? 1 : -1;
    s.at.y = side * (from >= 0 ? layout.walkInner + from : layout.walkOuter + from);
    const bool blocked = nearCrossing(s.at.x, margin) || layout.onDriveway(s.at.x, side, margin) ||
                         onWalkway(layout, s.at.x, side, margin);
    if (!blocked) break;
  }
  return s;
}

}  // namespace scanmill::street
