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

// Transforms a point from the layout's frame (right-hand traffic) to the town's frame, mirrored for left-hand traffic.
Vec3d townFromLayout(const town::Layout& layout, const Vec3d& p) {
  return layout.parameters.keepsLeft ? Vec3d{p.x, -p.y, p.z} : p;
}

}  // namespace

void addTown(SceneBuilder& builder, Fields& fields, std::uint64_t seed, const Affine& place) {
  const town::Layout layout = readLayout(fields, seed);
  builder.describe(layout.about);
  Affine worldFromTown = place;
  worldFromTown.linear.y = place.linear * townFromLayout(layout, {0, 1, 0});
  builder.place(town::makeGround(builder, layout).mesh, worldFromTown, "ground");
  town::populate(builder, layout, worldFromTown);
}

SceneLanes townLanes(Fields& fields, std::uint64_t seed) {
  constexpr double kEnds = 20;  // m from the ends of the built-up part to the ends of the lane
  const town::Layout layout = readLayout(fields, seed);
  const town::LanePath through{{{0, layout.mainFrom + kEnds, layout.mainTo - kEnds}}, 0, 0};
  const town::EgoRoads ego = town::egoRoads(layout);
  town::LanePath turns = through;
  if (ego.from != nullptr) {
    turns.intervals.front().from = *ego.from->joins + town::turnStart(*ego.from);
    turns.intervals.insert(turns.intervals.begin(),
                           {ego.from->number, town::laneEnd(*ego.from), town::laneStart(layout)});
  }
  if (ego.into != nullptr) {
    turns.intervals.back().to = *ego.into->joins - town::turnStart(*ego.into);
    turns.intervals.push_back({ego.into->number, town::laneStart(layout), town::laneEnd(*ego.into)});
  }
  SceneLanes lanes{town::egoLanePoints(layout, through).points, town::egoLanePoints(layout, turns).points,
                   static_cast<int>(turns.intervals.size()) - 1};
  for (std::vector<Vec3d>* lane : {&lanes.lane, &lanes.turns}) {
    for (Vec3d& p : *lane) p = townFromLayout(layout, p);
  }
  return lanes;
}

}  // namespace scanmill
