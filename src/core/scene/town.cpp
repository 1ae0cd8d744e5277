#include "scene/town.h"

#include "scene/town/lanes.h"
#include "scene/town/placer.h"

namespace scanmill {

void addTown(SceneBuilder& builder, Fields& fields, std::uint64_t seed, const Affine& worldFromTown) {
  const town::Parameters parameters = town::readParameters(fields);
  fields.finish();
  const town::Layout layout(parameters, seed);
  builder.place(town::makeGround(builder, layout).mesh, worldFromTown, "ground");
  town::populate(builder, layout, worldFromTown);
}

SceneLanes townLanes(Fields& fields, std::uint64_t seed) {
  constexpr double kEnds = 20;  // m of the built part before the lane begins and after it ends
  const town::Parameters parameters = town::readParameters(fields);
  fields.finish();
  const town::Layout layout(parameters, seed);
  const town::Way through{{{0, layout.mainFrom() + kEnds, layout.mainTo() - kEnds}}, 0, 0};
  const std::vector<town::Road>& roads = layout.roads().roads();
  const town::Tour tour = town::tourOf(layout);
  town::Way turns = through;
  if (tour.from) {
    turns.stretches.front().from = roads[*tour.from].joins + town::cornerOf(layout, *tour.from);
    turns.stretches.insert(turns.stretches.begin(),
                           {*tour.from, town::endOf(layout, *tour.from), town::mouthOf(layout)});
  }
  if (tour.into) {
    turns.stretches.back().to = roads[*tour.into].joins - town::cornerOf(layout, *tour.into);
    turns.stretches.push_back({*tour.into, town::mouthOf(layout), town::endOf(layout, *tour.into)});
  }
  return {town::layOut(layout, through, 0, 0).points, town::layOut(layout, turns, 0, 0).points};
}

}  // namespace scanmill
