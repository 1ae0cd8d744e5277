#include "scene/thing_boxes.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <ranges>
#include <set>
#include <utility>

namespace scanmill {

namespace {

// Returns a positive number if the path from `start` over `middle` to `end` turns left, a negative one if it turns
// right.
double turnDirection(const Vec2d& start, const Vec2d& middle, const Vec2d& end) {
  return (middle.x - start.x) * (end.y - start.y) - (middle.y - start.y) * (end.x - start.x);
}

// Returns the points' convex hull, counter-clockwise (Andrew, "Another efficient algorithm for convex hulls in two
// dimensions", Information Processing Letters 9 (1979)).
std::vector<Vec2d> hullOf(std::vector<Vec2d> points) {
  std::ranges::sort(points, {}, [](const Vec2d& p) { return std::pair(p.x, p.y); });
  std::vector<Vec2d> hull;
  // Appends the lower or the upper half of the hull, without its last point, which is the first one of the other half.
  const auto appendHalf = [&](const auto& sorted) {
    const std::size_t start = hull.size();
    for (const Vec2d& point : sorted) {
      while (hull.size() >= start + 2 && turnDirection(hull[hull.size() - 2], hull.back(), point) <= 0) hull.pop_back();
      hull.push_back(point);
    }
    hull.pop_back();
  };
  appendHalf(points);
  appendHalf(std::views::reverse(points));
  return hull;
}

// Returns the rotation of a placed mesh without its scale: x keeps its direction, z is made perpendicular to x.
Quat rotationOf(const Mat3& linear) {
  const Vec3d x = normalized(linear.x);
  const Vec3d z = normalized(linear.z - x * dot(linear.z, x));
  return fromMatrix({x, cross(z, x), z});
}

const RigidMotion* placementOf(std::uint32_t instance, const Placements* placed) {
  return placed == nullptr ? nullptr : placed->find(instance);
}

// Returns the transform from the pose of an instance at time 0 to its pose at `time`, in the world's frame.
Pose motion(const Scene& scene, std::uint32_t index, double time, const Placements* placed) {
  const Instance& instance = scene.instances[index];
  if (placementOf(index, placed) != nullptr) {
    const Affine moved = worldFromMeshAt(instance, index, placed, time) * inverse(instance.worldFromMesh);
    return {fromMatrix(moved.linear), moved.translation};
  }
  if (instance.movement == nullptr) return {};
  return instance.movement->at(time) * inverse(instance.movement->at(0));
}

struct ObjectFacts {
  std::uint64_t triangles = 0;  // number of the object's triangles
  std::map<std::uint16_t, std::uint64_t> trianglesByClass;
  std::set<std::string> nodes;  // names of the nodes that contain the object
};

// Returns facts about each object of a mesh; object n has the index n - 1.
std::vector<ObjectFacts> objectFactsOf(const Mesh& mesh) {
  std::vector<ObjectFacts> facts(mesh.objects);
  for (const std::uint16_t surfaceIndex : mesh.surfaceOf) {
    const Surface& surface = mesh.surfaces[surfaceIndex];
    if (surface.object == 0) continue;
    ObjectFacts& object = facts[surface.object - 1];
    ++object.triangles;
    ++object.trianglesByClass[surface.semantic];
  }
  for (const Surface& surface : mesh.surfaces) {
    if (surface.object != 0) facts[surface.object - 1].nodes.insert(surface.node);
  }
  return facts;
}

}  // namespace

double longSideOf(std::vector<Vec2d> points) {
  if (points.empty()) return 0;
  const std::vector<Vec2d> hull = hullOf(std::move(points));
  constexpr double kTie = 1e-9;  // a rectangle must be smaller than the best so far by more than this fraction
  double leastArea = std::numeric_limits<double>::infinity();
  double direction = 0;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vec2d& a = hull[i];
    const Vec2d& b = hull[(i + 1) % hull.size()];
    const double sideLength = std::hypot(b.x - a.x, b.y - a.y);
    if (!(sideLength > 0)) continue;
    const Vec2d along{(b.x - a.x) / sideLength, (b.y - a.y) / sideLength};
    double low = 0, high = 0, depth = 0;
    for (const Vec2d& p : hull) {
      const double offset = (p.x - a.x) * along.x + (p.y - a.y) * along.y;
      low = std::min(low, offset);
      high = std::max(high, offset);
      depth = std::max(depth, (p.y - a.y) * along.x - (p.x - a.x) * along.y);
    }
    const double area = (high - low) * depth;
    if (area >= leastArea * (1 - kTie)) continue;
    leastArea = area;
    direction = std::atan2(along.y, along.x) + (high - low < depth ? kPi / 2 : 0);
  }
  return direction;
}

std::vector<Vec3d> OrientedBox::corners() const {
  std::vector<Vec3d> corners;
  for (const Vec3d& corner : Box{size * -0.5, size * 0.5}.corners()) corners.push_back(worldFromBox * corner);
  return corners;
}

class ThingBoxes::Builder {
 public:
  explicit Builder(const Scene& scene) : scene_(scene) {
    for (const Mesh& mesh : scene.meshes) objectFacts_.push_back(objectFactsOf(mesh));
  }

  // Returns the parts of each thing by its id, the part with the most triangles first.
  std::map<std::uint32_t, std::vector<Part>> partsOfThings() const {
    std::map<std::uint32_t, std::vector<Part>> partsOf;
    for (std::uint32_t i = 0; i < scene_.instances.size(); ++i) {
      const Instance& instance = scene_.instances[i];
      for (std::uint32_t object = 1; object <= objectFacts_[instance.mesh].size(); ++object) {
        if (objectFacts_[instance.mesh][object - 1].triangles == 0) continue;
        partsOf[instanceId(instance.firstInstanceId, object)].push_back({i, object});
      }
    }
    for (auto& [id, parts] : partsOf) {
      std::ranges::stable_sort(parts, std::greater{}, [&](const Part& part) { return factsOf(part).triangles; });
    }
    return partsOf;
  }

  // Returns the description of a thing. `parts`: the thing's parts, as partsOfThings() returns them.
  Thing thingOf(std::uint32_t id, const std::vector<Part>& parts) const {
    const Instance& main = instanceOf(parts.front());
    Thing thing;
    thing.id = id;
    thing.name = main.name;
    thing.headingKnown = main.facing.has_value() || scene_.meshes[main.mesh].objects == 1;
    std::map<std::uint16_t, std::uint64_t> trianglesByClass;
    std::set<std::string> nodes;
    for (const Part& part : parts) {
      thing.moves = thing.moves || instanceOf(part).everMoves();
      for (const auto& [semantic, count] : factsOf(part).trianglesByClass) trianglesByClass[semantic] += count;
      nodes.insert(factsOf(part).nodes.begin(), factsOf(part).nodes.end());
    }
    thing.semantic = std::ranges::max_element(trianglesByClass, {}, [](const auto& e) { return e.second; })->first;
    thing.parts.assign(nodes.begin(), nodes.end());
    return thing;
  }

  // Returns the thing's pose at time 0: the axes of its first part, turned to its heading (see Thing::headingKnown).
  Pose worldFromThing(const Thing& thing, const std::vector<Part>& parts) {
    const Instance& main = instanceOf(parts.front());
    Pose pose{rotationOf(main.worldFromMesh.linear), main.worldFromMesh.translation};
    if (main.facing) {
      pose.rotation = pose.rotation * fromYawPitchRoll(*main.facing, 0, 0);
    } else if (!thing.headingKnown) {
      std::vector<Vec2d> footprint;
      const Pose partFromWorld = inverse(pose);
      for (const Part& part : parts) {
        const Instance& instance = instanceOf(part);
        forEachCorner(instance.mesh, part.object, [&](const Vec3d& corner) {
          const Vec3d p = partFromWorld * (instance.worldFromMesh * corner);
          footprint.push_back({p.x, p.y});
        });
      }
      pose.rotation = pose.rotation * fromYawPitchRoll(longSideOf(std::move(footprint)), 0, 0);
    }
    return pose;
  }

  void addBoxes(const Pose& worldFromThing, Part& part) {
    const Instance& instance = instanceOf(part);
    // This transform is the same at all times if the part moves like the first part; else at() moves the box.
    const Affine thingFromMesh = toAffine(inverse(worldFromThing)) * instance.worldFromMesh;
    const std::vector<std::uint32_t> onlyMesh{instance.mesh};
    for (const std::uint32_t mesh : instance.animation == nullptr ? onlyMesh : instance.animation->meshes) {
      Box& box = part.boxes.emplace_back();
      forEachCorner(mesh, part.object, [&](const Vec3d& corner) { box.add(thingFromMesh * corner); });
    }
  }

 private:
  const Instance& instanceOf(const Part& part) const { return scene_.instances[part.instance]; }
  const ObjectFacts& factsOf(const Part& part) const { return objectFacts_[instanceOf(part).mesh][part.object - 1]; }
  // Calls visit(position) for each corner of each triangle of an object, in the mesh's frame (m).
  template <class Visit>
  void forEachCorner(std::uint32_t meshIndex, std::uint32_t object, const Visit& visit) {
    const Mesh& mesh = scene_.meshes[meshIndex];
    const auto [entry, isNew] = triangles_.try_emplace(meshIndex, mesh.objects + std::size_t{1});
    for (std::uint32_t t = 0; isNew && t < mesh.triangles.size(); ++t) {
      entry->second[mesh.surfaces[mesh.surfaceOf[t]].object].push_back(t);
    }
    for (const std::uint32_t t : entry->second[object]) {
      for (const std::uint32_t corner : mesh.triangles[t]) visit(Vec3d(mesh.positions[corner]));
    }
  }

  const Scene& scene_;
  std::vector<std::vector<ObjectFacts>> objectFacts_;  // by mesh and object
  // Indices of triangles, by mesh and object (0: stuff), so that a mesh of thousands of objects is searched once.
  std::map<std::uint32_t, std::vector<std::vector<std::uint32_t>>> triangles_;
};

ThingBoxes::ThingBoxes(const Scene& scene, const std::vector<std::uint16_t>& classes) : scene_(scene) {
  Builder builder(scene);
  for (auto& [id, parts] : builder.partsOfThings()) {
    Thing thing = builder.thingOf(id, parts);
    if (!classes.empty() && std::ranges::find(classes, thing.semantic) == classes.end()) continue;
    things_.push_back(std::move(thing));
    const Pose worldFromThing = builder.worldFromThing(things_.back(), parts);
    for (Part& part : parts) builder.addBoxes(worldFromThing, part);
    shapes_.push_back({worldFromThing, std::move(parts)});
  }
}

const RigidMotion* ThingBoxes::placement(std::size_t thing, const Placements* placed) const {
  return placementOf(shapes_[thing].parts.front().instance, placed);
}

OrientedBox ThingBoxes::at(std::size_t thing, double time, const Placements* placed) const {
  const Shape& shape = shapes_[thing];
  const std::uint32_t main = shape.parts.front().instance;
  const Pose worldFromThing = motion(scene_, main, time, placed) * shape.worldFromThing;
  Box box;
  for (const Part& part : shape.parts) {
    const Instance& instance = scene_.instances[part.instance];
    const RigidMotion* const placement = placementOf(part.instance, placed);
    if (placement != nullptr && placement->hidden) continue;
    std::size_t boxIndex = 0;
    if (instance.animation != nullptr) {
      const auto& meshes = instance.animation->meshes;
      boxIndex = static_cast<std::size_t>(std::ranges::find(meshes, instance.meshAt(time)) - meshes.begin());
    }
    const Box& partBox = part.boxes[boxIndex];
    if (partBox.empty()) continue;
    const bool movesWithMain = placement == nullptr && placementOf(main, placed) == nullptr &&
                               instance.movement == scene_.instances[main].movement;
    if (part.instance == main || movesWithMain) {
      box.add(partBox);
      continue;
    }
    // This part moves differently from the first part, so the corners of its moved box are added.
    const Pose thingFromStart =
        inverse(worldFromThing) * motion(scene_, part.instance, time, placed) * shape.worldFromThing;
    for (const Vec3d& corner : partBox.corners()) box.add(thingFromStart * corner);
  }
  return {worldFromThing * Pose{{}, box.center()}, box.high - box.low};
}

Vec3d ThingBoxes::velocity(std::size_t thing, double time, const Placements* placed) const {
  constexpr double kStep = 0.005;  // s; the velocity is measured over this time before and after `time`
  const Shape& shape = shapes_[thing];
  const std::uint32_t main = shape.parts.front().instance;
  if (scene_.instances[main].movement == nullptr && placementOf(main, placed) == nullptr) return {};
  const auto positionAt = [&](double atTime) {
    return (motion(scene_, main, atTime, placed) * shape.worldFromThing).translation;
  };
  const double start = std::max(time - kStep, 0.0);
  return (positionAt(time + kStep) - positionAt(start)) * (1 / (time + kStep - start));
}

}  // namespace scanmill
