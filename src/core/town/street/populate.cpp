#include <cmath>

#include "town/street/placer.h"

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
