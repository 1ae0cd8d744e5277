#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "pipeline/run/sample_maker.h"

namespace scanmill {

namespace {

// Largest number of cached beam grids. Each sensor needs one grid, or one per revolution if its pattern is a rosette.
constexpr std::size_t kMostGrids = 16;
constexpr int kCells = 6;  // samples along each edge of a box's face; see truncationOf()

// A shot's view of one object: the number of its points, the number of beams whose axis hits it, and the least range of
// these beams (m).
struct ThingHits {
  std::uint64_t points = 0;
  std::uint32_t beams = 0;
  float nearest = kMiss;
};

// Returns, by instance id, the points, beams and least range of each thing that beams of the shot hit.
std::unordered_map<std::uint32_t, ThingHits> hitsByThing(const Hits& hits, const Returns& returns,
                                                         std::uint32_t raysPerBeam) {
  std::unordered_map<std::uint32_t, ThingHits> things;
  for (std::size_t beam = 0; beam < hits.size(); ++beam) {
    const std::size_t axis = beam * raysPerBeam;
    if (!hits.hit(axis) || hits.instance[axis] == 0) continue;
    ThingHits& thing = things[hits.instance[axis]];
    ++thing.beams;
    thing.nearest = std::min(thing.nearest, hits.range[axis]);
  }
  for (std::size_t row = 0; row < returns.size(); ++row) {
    const std::uint32_t id = returns.returned(row) ? returns.instanceOf(row, hits) : 0;
    if (id != 0) ++things[id].points;
  }
  return things;
}

// Returns the fraction of a box that is outside of the field of view or out of range, measured as solid angle of the
// faces that the sensor sees; 0 if the sensor is inside of the box. `maxRange`: in m.
double truncationOf(const Pose& sensorFromBox, const Vec3d& size, double maxRange, const BeamGrid& grid) {
  const Vec3d sensor = inverse(sensorFromBox).translation;
  double totalAngle = 0;
  double outsideAngle = 0;
  std::uint32_t nearBeam = 0;
  for (const auto axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
    const double sign = sensor.*axis > 0 ? 1 : -1;
    // Distance (m) from the sensor to the plane of the face that is on the sensor's side of the box. The sensor sees
    // the face only if the distance is positive.
    const double faceDistance = std::abs(sensor.*axis) - size.*axis / 2;
    if (!(faceDistance > 0)) continue;
    const auto second = axis == &Vec3d::x ? &Vec3d::y : &Vec3d::x;
    const auto third = axis == &Vec3d::z ? &Vec3d::y : &Vec3d::z;
    const double cellArea = size.*second * size.*third / (kCells * kCells);
    for (int i = 0; i < kCells * kCells; ++i) {
      const int row = i / kCells;
      Vec3d point;
      point.*axis = sign * size.*axis / 2;
      point.*second = ((i % kCells + 0.5) / kCells - 0.5) * size.*second;
      point.*third = ((row + 0.5) / kCells - 0.5) * size.*third;
      const Vec3d inSensor = sensorFromBox * point;
      const double distance = length(inSensor);
      const double angle = cellArea * faceDistance / (distance * distance * distance);
      totalAngle += angle;
      if (distance > maxRange || !grid.looksInto(inSensor * (1 / distance), nearBeam)) outsideAngle += angle;
    }
  }
  return totalAngle > 0 ? outsideAngle / totalAngle : 0;
}

// Returns the ids of the classes whose objects are listed; empty: all. Without classes of road users, as in an ontology
// of rooms, all objects are listed.
std::vector<std::uint16_t> listedClasses(const ListedObjects& listed, const Ontology& ontology) {
  if (listed.all || !listed.classes.empty()) return classIds(ontology, listed.classes, listed.where);
  std::vector<std::uint16_t> ids;
  for (const SemanticClass& c : ontology.classes) {
    if (c.roadUser) ids.push_back(c.id);
  }
  return ids;
}

}  // namespace

SceneObjects::SceneObjects(const Scene& scene, const Method& method, const ListedObjects& listed)
    : classes_(listedClasses(listed, scene.ontology)),
      boxes_(scene, classes_),
      own_(method.worlds() != nullptr ? nullptr
                                      : std::make_unique<const Worlds>(
                                            scene, Instancing::Auto, HierarchyOptions{.occlusionFilter = thingFilter})),
      unobstructed_(own_ != nullptr ? *own_ : *method.worlds(), boxes_) {}

std::shared_ptr<const BeamGrid> SceneObjects::gridOf(const std::shared_ptr<const BeamTable>& beams) const {
  const auto isOfBeams = [&](const Grid& grid) { return grid.beams == beams; };
  {
    const std::scoped_lock lock(mutex_);
    if (const Grid* const cached = grids_.find(isOfBeams)) return cached->grid;
  }
  auto made = std::make_shared<const BeamGrid>(*beams);
  const std::scoped_lock lock(mutex_);  // another thread may have added the same grid meanwhile
  return grids_.findOrAdd(isOfBeams, kMostGrids, [&] { return Grid{beams, std::move(made)}; }).grid;
}

ObjectList::ObjectList(const SceneObjects& objects, std::string key, double time,
                       std::shared_ptr<const Placements> placed)
    : objects_(objects),
      key_(std::move(key)),
      time_(time),
      placed_(std::move(placed)),
      views_(objects.boxes().things().size()) {
  for (std::size_t i = 0; i < views_.size(); ++i) boxes_.push_back(objects.boxes().at(i, time, placed_.get()));
}

void ObjectList::add(const Shot& shot, std::uint32_t raysPerBeam, const Hits& hits, const Returns& returns) {
  const std::shared_ptr<const BeamGrid> grid = objects_.gridOf(shot.beams);
  const double reach = shot.beams->maxRange + grid->farthestOrigin();
  const std::unordered_map<std::uint32_t, ThingHits> hitThings = hitsByThing(hits, returns, raysPerBeam);
  const Unobstructed::Sight sight =
      objects_.unobstructed().sightOf(shot, *grid, objects_.memoryBytes() == 0 ? &hits : nullptr, raysPerBeam);
  for (std::size_t i = 0; i < boxes_.size(); ++i) {
    if (const auto* placement = objects_.boxes().placement(i, placed_.get()); placement && placement->hidden) continue;
    const auto thingHits = hitThings.find(objects_.boxes().things()[i].id);
    const Vec3d sensor = inverse(boxes_[i].worldFromBox) * shot.worldFromSensor.front().translation;
    const Box extent{boxes_[i].size * -0.5, boxes_[i].size * 0.5};
    if (thingHits == hitThings.end() && extent.distanceTo(sensor) > reach) continue;
    const Unobstructed::View unoccluded = objects_.unobstructed().viewOf(i, sight);
    ObjectView view;
    view.sensor = shot.sensorName;
    // The view's time is the firing time of the middle beam among those that would hit the thing without occlusion.
    const std::uint32_t column = unoccluded.middle % shot.beams->columns;
    view.time = shot.duration > 0 ? shot.time + shot.beams->columnTime(column) : shot.time;
    const OrientedBox box = objects_.boxes().at(i, view.time, placed_.get());
    const Pose firingFromBox = inverse(shot.worldFromSensor[shot.stepOf(column)]) * box.worldFromBox;
    view.sensorFromBox = shot.deskew ? inverse(shot.worldFromSensor.front()) * box.worldFromBox : firingFromBox;
    view.beamsAlone = unoccluded.beams;
    view.truncation = truncationOf(firingFromBox, box.size, shot.beams->maxRange, *grid);
    if (thingHits != hitThings.end()) {
      view.points = thingHits->second.points;
      view.beams = thingHits->second.beams;
      if (thingHits->second.nearest < kMiss) view.nearestRange = thingHits->second.nearest;
    }
    views_[i].push_back(std::move(view));
  }
}

SampleObjects ObjectList::finish() const {
  SampleObjects listed{key_, time_, {}};
  for (std::size_t i = 0; i < views_.size(); ++i) {
    if (views_[i].empty()) continue;
    const Thing& thing = objects_.boxes().things()[i];
    std::vector<std::string> parts = thing.parts;
    std::erase(parts, "");
    const bool moves = thing.moves || objects_.boxes().placement(i, placed_.get()) != nullptr;
    listed.objects.push_back({thing.id, thing.semantic, thing.name, std::move(parts), moves, boxes_[i].worldFromBox,
                              boxes_[i].size, thing.headingKnown, objects_.boxes().velocity(i, time_, placed_.get()),
                              views_[i]});
  }
  return listed;
}

}  // namespace scanmill
