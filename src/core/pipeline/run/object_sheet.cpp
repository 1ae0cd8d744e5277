#include "pipeline/run/object_sheet.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <unordered_map>
#include <utility>

namespace scanmill {

namespace {

constexpr std::size_t kGridsInMemory = 16;  // sensors, or revolutions of rosettes
constexpr int kCells = 6;                   // along an edge of a box's face, to find what is outside of the field

// What a shot has of a thing.
struct Seen {
  std::uint64_t points = 0;
  std::uint32_t beams = 0;
  float nearest = kMiss;
};

std::unordered_map<std::uint32_t, Seen> seenThings(const Hits& hits, const Returns& returns,
                                                   std::uint32_t raysPerBeam) {
  std::unordered_map<std::uint32_t, Seen> seen;
  for (std::size_t beam = 0; beam < hits.size(); ++beam) {
    const std::size_t axis = beam * raysPerBeam;
    if (!hits.hit(axis) || hits.instance[axis] == 0) continue;
    Seen& own = seen[hits.instance[axis]];
    ++own.beams;
    own.nearest = std::min(own.nearest, hits.range[axis]);
  }
  for (std::size_t row = 0; row < returns.size(); ++row) {
    const std::uint32_t thing = returns.returned(row) ? returns.instanceOf(row, hits) : 0;
    if (thing != 0) ++seen[thing].points;
  }
  return seen;
}

// How far a box is from a point in its own frame (m).
double distanceTo(const Vec3d& size, const Vec3d& point) {
  const auto beyond = [](double p, double extent) { return std::max(std::abs(p) - extent / 2, 0.0); };
  return length(Vec3d{beyond(point.x, size.x), beyond(point.y, size.y), beyond(point.z, size.z)});
}

// The part of the solid angle of a box's faces, as seen from the sensor, in which no beam looks or which is out of
// range. 0 where the sensor is within the box.
double truncationOf(const Pose& sensorFromBox, const Vec3d& size, double maxRange, const BeamGrid& grid) {
  const Vec3d sensor = inverse(sensorFromBox).translation;
  double all = 0;
  double outside = 0;
  for (const auto axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
    const double side = sensor.*axis > 0 ? 1 : -1;
    const double height = std::abs(sensor.*axis) - size.*axis / 2;  // of the sensor over the face
    if (!(height > 0)) continue;
    const auto second = axis == &Vec3d::x ? &Vec3d::y : &Vec3d::x;
    const auto third = axis == &Vec3d::z ? &Vec3d::y : &Vec3d::z;
    const double cell = size.*second * size.*third / (kCells * kCells);
    for (int i = 0; i < kCells * kCells; ++i) {
      Vec3d place;
      place.*axis = side * size.*axis / 2;
      place.*second = ((i % kCells + 0.5) / kCells - 0.5) * size.*second;
      place.*third = ((i / kCells + 0.5) / kCells - 0.5) * size.*third;
      const Vec3d seen = sensorFromBox * place;
      const double distance = length(seen);
      const double angle = cell * height / (distance * distance * distance);
      all += angle;
      if (distance > maxRange || !grid.looksInto(seen * (1 / distance))) outside += angle;
    }
  }
  return all > 0 ? outside / all : 0;
}

std::unique_ptr<const Worlds> ownWorlds(const Scene& scene, const Method& method) {
  if (method.worlds() != nullptr) return nullptr;
  HierarchyOptions options;
  options.occlusionFilter = thingFilter;
  return std::make_unique<const Worlds>(scene, Instancing::Auto, options);
}

}  // namespace

SceneObjects::SceneObjects(const Scene& scene, const Method& method)
    : boxes_(scene),
      own_(ownWorlds(scene, method)),
      unobstructed_(own_ != nullptr ? *own_ : *method.worlds(), boxes_) {}

std::uint64_t SceneObjects::memoryBytes() const {
  return own_ == nullptr ? 0 : own_->memoryBytes();
}

std::shared_ptr<const BeamGrid> SceneObjects::gridOf(const std::shared_ptr<const BeamTable>& beams) const {
  const auto find = [&]() -> std::shared_ptr<const BeamGrid> {
    const auto known = std::find_if(grids_.begin(), grids_.end(), [&](const Grid& g) { return g.beams == beams; });
    if (known == grids_.end()) return nullptr;
    grids_.splice(grids_.begin(), grids_, known);
    return known->grid;
  };
  {
    const std::scoped_lock lock(mutex_);
    if (auto known = find()) return known;
  }
  auto made = std::make_shared<const BeamGrid>(*beams);
  const std::scoped_lock lock(mutex_);
  if (auto known = find()) return known;  // another thread was faster
  if (grids_.size() >= kGridsInMemory) grids_.pop_back();
  grids_.push_front({beams, made});
  return made;
}

ObjectSheet::ObjectSheet(const SceneObjects& objects, std::string key, double time) : objects_(objects) {
  sample_.key = std::move(key);
  sample_.time = time;
  const ThingBoxes& boxes = objects.boxes();
  for (std::size_t i = 0; i < boxes.things().size(); ++i) {
    const Thing& thing = boxes.things()[i];
    const OrientedBox box = boxes.at(i, time);
    ObjectRecord record{
        thing.id,           thing.semantic,          thing.name, {}, thing.moves, box.worldFromBox, box.size,
        thing.headingKnown, boxes.velocity(i, time), {}};
    std::copy_if(thing.parts.begin(), thing.parts.end(), std::back_inserter(record.parts),
                 [](const std::string& part) { return !part.empty(); });
    sample_.objects.push_back(std::move(record));
  }
}

void ObjectSheet::add(const Shot& shot, std::uint32_t raysPerBeam, const Hits& hits, const Returns& returns) {
  const std::shared_ptr<const BeamGrid> grid = objects_.gridOf(shot.beams);
  const double reach = shot.beams->maxRange + grid->farthestOrigin();
  const std::unordered_map<std::uint32_t, Seen> seen = seenThings(hits, returns, raysPerBeam);
  for (std::size_t i = 0; i < sample_.objects.size(); ++i) {
    ObjectRecord& object = sample_.objects[i];
    const auto own = seen.find(object.id);
    const Vec3d sensor = inverse(object.worldFromBox) * shot.worldFromSensor.front().translation;
    if (own == seen.end() && distanceTo(object.size, sensor) > reach) continue;
    const Unobstructed::View alone = objects_.unobstructed().of(i, shot, *grid);
    ObjectView view;
    view.sensor = shot.sensorName;
    const std::uint32_t column = alone.middle % shot.beams->columns;
    view.time = shot.duration > 0 ? shot.time + shot.beams->columnTime(column) : shot.time;
    const OrientedBox box = objects_.boxes().at(i, view.time);
    const Pose firing = inverse(shot.worldFromSensor[shot.stepOf(column)]) * box.worldFromBox;
    view.sensorFromBox = shot.deskew ? inverse(shot.worldFromSensor.front()) * box.worldFromBox : firing;
    view.beamsAlone = alone.beams;
    view.truncation = truncationOf(firing, box.size, shot.beams->maxRange, *grid);
    if (own != seen.end()) {
      view.points = own->second.points;
      view.beams = own->second.beams;
      if (own->second.nearest < kMiss) view.nearestRange = own->second.nearest;
    }
    object.views.push_back(std::move(view));
  }
}

SampleObjects ObjectSheet::finish() const {
  SampleObjects reached{sample_.key, sample_.time, {}};
  std::copy_if(sample_.objects.begin(), sample_.objects.end(), std::back_inserter(reached.objects),
               [](const ObjectRecord& object) { return !object.views.empty(); });
  return reached;
}

}  // namespace scanmill
