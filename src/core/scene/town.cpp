#include "scene/town.h"

#include "scene/town/placer.h"

namespace scanmill {

void addTown(SceneBuilder& builder, Fields& fields, std::uint64_t seed, const Affine& worldFromTown) {
  const town::Parameters parameters = town::readParameters(fields);
  fields.finish();
  const town::Layout layout(parameters, seed);
  builder.place(town::makeGround(builder, layout).mesh, worldFromTown, "ground");
  town::populate(builder, layout, worldFromTown);
}

std::vector<Vec3d> townLane(Fields& fields, std::uint64_t seed) {
  constexpr double kStep = 6;   // m
  constexpr double kEnds = 20;  // m of the built part before the lane begins and after it ends
  const town::Parameters parameters = town::readParameters(fields);
  fields.finish();
  const town::Layout layout(parameters, seed);
  const town::Road& main = layout.roads().roads().front();
  const double lane = (main.section.half - main.section.parking) / 2;
  std::vector<Vec3d> places;
  for (const double at : parts::steps(layout.mainFrom() + kEnds, layout.mainTo() - kEnds, kStep)) {
    const town::Point2 p = town::besideRoad(main, at, -lane).at;
    places.push_back({p.x, p.y, layout.heightAt(p)});
  }
  return places;
}

}  // namespace scanmill
