#include "town/placer.h"

namespace scanmill::town {

// Places objects in the order of their priority: later objects get only places that are still free.
void populate(SceneBuilder& builder, const Layout& layout, const Affine& worldFromTown) {
  Placer placer(builder, layout, worldFromTown);
  placeHouses(placer);
  placeBoundaries(placer);
  placeClutter(placer);
  placeMarkings(placer);
  placeCovers(placer);
  placeFixtures(placer);
  placeWires(placer);
  placeVehicles(placer);
  placeTrees(placer);
  placePeople(placer);
  placeAnimals(placer);
  placeBushes(placer);
  placeWoods(placer);
  placeGrass(placer);
}

}  // namespace scanmill::town
