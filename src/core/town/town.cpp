#include "town/town.h"

#include "town/lanes.h"
#include "town/placer.h"

namespace scanmill {

namespace {

town::Layout readLayout(Fields& fields, std::uint64_t seed) {
  const town::Parameters parameters = town::readParameters(fields);
  fields.finish();
  if (parameters.map.empty()) return {parameters, seed};
  const Location& where = fields.find("map")->where;
  const town::Map map = town::readMap(parameters.map, parameters.keepsLeft, where);
  return {parameters, seed,
          town::cutOut(map, parameters, seed, town::Layout::reachOf(parameters) - town::Layout::kEdge, where)};
}

// Transforms a point from the layout's frame to the town's frame. A layout is always for right-hand traffic; for
// left-hand traffic the town is its mirror image.
Vec3d inWorld(const town::Layout& layout, const Vec3d& p) {
  return layout.parameters.keepsLeft ? Vec3d{p.x, -p.y, p.z} : p;
}

}  // namespace

void addTown(SceneBuilder& builder, Fields& fields, std::uint64_t seed, const Affine& place) {
  const town::Layout layout = readLayout(fields, seed);
  builder.describe(layout.about);
  builder.drawReflectances();
  Affine worldFromTown = place;
  worldFromTown.linear.y = place.linear * inWorld(layout, {0, 1, 0});
  builder.place(town::makeGround(builder, layout).mesh, worldFromTown, "ground");
  town::populate(builder, layout, worldFromTown);
}

SceneLanes townLanes(Fields& fields, std::uint64_t seed) {
  constexpr double kEnds = 20;  // m; the lane ends this far inside the built-up part, at both ends
  const town::Layout layout = readLayout(fields, seed);
  const town::Way through{{{0, layout.mainFrom + kEnds, layout.mainTo - kEnds}}, 0, 0};
  const town::Tour tour = town::tourOf(layout);
  town::Way turns = through;
  if (tour.from != nullptr) {
    turns.stretches.front().from = *tour.from->joins + town::cornerOf(*tour.from);
    turns.stretches.insert(turns.stretches.begin(),
                           {tour.from->number, town::endOf(*tour.from), town::mouthOf(layout)});
  }
  if (tour.into != nullptr) {
    turns.stretches.back().to = *tour.into->joins - town::cornerOf(*tour.into);
    turns.stretches.push_back({tour.into->number, town::mouthOf(layout), town::endOf(*tour.into)});
  }
  SceneLanes lanes{town::layOut(layout, through, 0, 0).points, town::layOut(layout, turns, 0, 0).points,
                   static_cast<int>(turns.stretches.size()) - 1};
  for (std::vector<Vec3d>* lane : {&lanes.lane, &lanes.turns}) {
    for (Vec3d& p : *lane) p = inWorld(layout, p);
  }
  return lanes;
}

}  // namespace scanmill
