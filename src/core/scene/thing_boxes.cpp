#include "scene/thing_boxes.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <utility>

namespace scanmill {

namespace {

double turn(const Vec2d& o, const Vec2d& a, const Vec2d& b) {
  return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
}

// Returns the convex hull, counter-clockwise: Andrew, "Another efficient algorithm for convex hulls in two dimensions",
// Information Processing Letters 9 (1979).
std::vector<Vec2d> hullOf(std::vector<Vec2d> points) {
  std::ranges::sort(points, {}, [](const Vec2d& p) { return std::pair(p.x, p.y); });
  std::vector<Vec2d> hull;
  const auto half = [&](auto from, auto to) {
    const std::size_t first = hull.size();
    for (; from != to; ++from) {
      while (hull.size() >= first + 2 && turn(hull[hull.size() - 2], hull.back(), *from) <= 0) hull.pop_back();
      hull.push_back(*from);
    }
    hull.pop_back();
  };
  half(points.begin(), points.end());
  half(points.rbegin(), points.rend());
  return hull;
}

// Returns the rotation of a placed mesh without its scale: x keeps its direction, z is made perpendicular to x.
Quat axesOf(const Mat3& linear) {
  const Vec3d x = normalized(linear.x);
  const Vec3d z = normalized(linear.z - x * dot(linear.z, x));
  return fromMatrix({x, cross(z, x), z});
}

// The triangles of a mesh by object, so that a mesh of thousands of objects is not searched once for each object.
class ObjectTriangles {
 public:
  explicit ObjectTriangles(const Mesh& mesh) : mesh_(mesh), firstOf_(mesh.objects + std::size_t{2}) {
    const auto objectOf = [&](std::size_t t) { return mesh.surfaces[mesh.surfaceOf[t]].object; };
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) ++firstOf_[objectOf(t) + std::size_t{1}];
    for (std::size_t i = 1; i < firstOf_.size(); ++i) firstOf_[i] += firstOf_[i - 1];
    triangles_.resize(mesh.triangles.size());
    std::vector<std::uint32_t> next(firstOf_.begin(), firstOf_.end() - 1);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) triangles_[next[objectOf(t)]++] = t;
  }

  template <class Visit>
  void forCorners(std::uint32_t object, const Visit& visit) const {
    for (std::uint32_t i = firstOf_[object]; i < firstOf_[object + std::size_t{1}]; ++i) {
      for (const std::uint32_t corner : mesh_.triangles[triangles_[i]]) visit(Vec3d(mesh_.positions[corner]));
    }
  }

 private:
  const Mesh& mesh_;
  std::vector<std::uint32_t> firstOf_;    // first index into triangles_, by object (0: stuff); last entry: size of
                                          // triangles_
  std::vector<std::uint32_t> triangles_;  // indices of triangles, ordered by their objects
};

// The number of triangles of one object of a mesh, in total and by class, and the nodes that contain the object.
struct Share {
  std::uint64_t triangles = 0;
  std::map<std::uint16_t, std::uint64_t> ofClass;
  std::set<std::string> nodes;
};

std::vector<Share> sharesOf(const Mesh& mesh) {
  std::vector<Share> shares(mesh.objects);
  for (const std::uint16_t number : mesh.surfaceOf) {
    const Surface& surface = mesh.surfaces[number];
    if (surface.object == 0) continue;
    Share& share = shares[surface.object - 1];
    ++share.triangles;
    ++share.ofClass[surface.semantic];
  }
  for (const Surface& surface : mesh.surfaces) {
    if (surface.object != 0) shares[surface.object - 1].nodes.insert(surface.node);
  }
  return shares;
}

}  // namespace

double longSideOf(std::vector<Vec2d> points) {
  if (points.empty()) return 0;
  const std::vector<Vec2d> hull = hullOf(std::move(points));
  double best = std::numeric_limits<double>::infinity();
  double heading = 0;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vec2d& a = hull[i];
    const Vec2d& b = hull[(i + 1) % hull.size()];
    const double side = std::hypot(b.x - a.x, b.y - a.y);
    if (!(side > 0)) continue;
    const Vec2d along{(b.x - a.x) / side, (b.y - a.y) / side};
    double low = 0, high = 0, deep = 0;
    for (const Vec2d& p : hull) {
      const double x = (p.x - a.x) * along.x + (p.y - a.y) * along.y;
      low = std::min(low, x);
      high = std::max(high, x);
      deep = std::max(deep, (p.y - a.y) * along.x - (p.x - a.x) * along.y);
    }
    const double area = (high - low) * deep;
    if (area >= best * (1 - 1e-9)) continue;
    best = area;
    heading = std::atan2(along.y, along.x) + (high - low < deep ? kPi / 2 : 0);
  }
  return heading;
}

std::vector<Vec3d> OrientedBox::corners() const {
  std::vector<Vec3d> all;
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      for (const double z : {-0.5, 0.5}) all.push_back(worldFromBox * Vec3d{x * size.x, y * size.y, z * size.z});
    }
  }
  return all;
}

class ThingBoxes::Builder {
 public:
  explicit Builder(const Scene& scene) : scene_(scene) {
    for (const Mesh& mesh : scene.meshes) shares_.push_back(sharesOf(mesh));
  }

  // Returns the parts of each thing by its id, the part with the most triangles first.
  std::map<std::uint32_t, std::vector<Part>> partsOfThings() const {
    std::map<std::uint32_t, std::vector<Part>> partsOf;
    for (std::uint32_t i = 0; i < scene_.instances.size(); ++i) {
      const Instance& instance = scene_.instances[i];
      for (std::uint32_t object = 1; object <= shares_[instance.mesh].size(); ++object) {
        if (shares_[instance.mesh][object - 1].triangles == 0) continue;
        partsOf[instanceId(instance.firstInstanceId, object)].push_back({i, object});
      }
    }
    for (auto& [id, parts] : partsOf) {
      std::ranges::stable_sort(parts, std::greater{}, [&](const Part& part) { return shareOf(part).triangles; });
    }
    return partsOf;
  }

  Thing thingOf(std::uint32_t id, const std::vector<Part>& parts) const {
    const Instance& main = instanceOf(parts.front());
    Thing thing;
    thing.id = id;
    thing.name = main.name;
    thing.headingKnown = main.facing.has_value() || scene_.meshes[main.mesh].objects == 1;
    std::map<std::uint16_t, std::uint64_t> ofClass;
    std::set<std::string> nodes;
    for (const Part& part : parts) {
      thing.moves = thing.moves || instanceOf(part).everMoves();
      for (const auto& [semantic, count] : shareOf(part).ofClass) ofClass[semantic] += count;
      nodes.insert(shareOf(part).nodes.begin(), shareOf(part).nodes.end());
    }
    thing.semantic =
        std::ranges::max_element(ofClass, [](const auto& a, const auto& b) { return a.second < b.second; })->first;
    thing.parts.assign(nodes.begin(), nodes.end());
    return thing;
  }

  // Returns the thing's pose at time 0: the axes of its first part, turned to its heading (see Thing::headingKnown).
  Pose worldFromThing(const Thing& thing, const std::vector<Part>& parts) {
    const Instance& main = instanceOf(parts.front());
    Pose pose{axesOf(main.worldFromMesh.linear), main.worldFromMesh.translation};
    if (main.facing) {
      pose.rotation = pose.rotation * fromYawPitchRoll(*main.facing, 0, 0);
    } else if (!thing.headingKnown) {
      std::vector<Vec2d> ground;
      const Pose partFromWorld = inverse(pose);
      for (const Part& part : parts) {
        const Instance& instance = instanceOf(part);
        trianglesOf(instance.mesh).forCorners(part.object, [&](const Vec3d& corner) {
          const Vec3d p = partFromWorld * (instance.worldFromMesh * corner);
          ground.push_back({p.x, p.y});
        });
      }
      pose.rotation = pose.rotation * fromYawPitchRoll(longSideOf(std::move(ground)), 0, 0);
    }
    return pose;
  }

  // Sets Part::ofShape.
  void addShapes(const Pose& worldFromThing, Part& part) {
    const Instance& instance = instanceOf(part);
    // This transform is the same at all times if the part moves like the first part; else at() moves the box.
    const Affine thingFromMesh = toAffine(inverse(worldFromThing)) * instance.worldFromMesh;
    const std::vector<std::uint32_t> still{instance.mesh};
    for (const std::uint32_t mesh : instance.animation == nullptr ? still : instance.animation->meshes) {
      Box& box = part.ofShape.emplace_back();
      trianglesOf(mesh).forCorners(part.object, [&](const Vec3d& corner) { box.add(thingFromMesh * corner); });
    }
  }

 private:
  const Instance& instanceOf(const Part& part) const { return scene_.instances[part.instance]; }
  const Share& shareOf(const Part& part) const { return shares_[instanceOf(part).mesh][part.object - 1]; }
  const ObjectTriangles& trianglesOf(std::uint32_t mesh) {
    return triangles_.try_emplace(mesh, scene_.meshes[mesh]).first->second;
  }

  const Scene& scene_;
  std::vector<std::vector<Share>> shares_;              // by mesh and object
  std::map<std::uint32_t, ObjectTriangles> triangles_;  // by mesh
};

ThingBoxes::ThingBoxes(const Scene& scene) : scene_(scene) {
  Builder builder(scene);
  for (auto& [id, parts] : builder.partsOfThings()) {
    things_.push_back(builder.thingOf(id, parts));
    const Pose worldFromThing = builder.worldFromThing(things_.back(), parts);
    for (Part& part : parts) builder.addShapes(worldFromThing, part);
    placed_.push_back({worldFromThing, std::move(parts)});
  }
}

// Returns the transform from the instance's pose at time 0 to its pose at `time`, in the world's frame.
Pose ThingBoxes::motion(const Instance& instance, double time) const {
  if (instance.movement == nullptr) return {};
  return instance.movement->at(time) * inverse(instance.movement->at(0));
}

OrientedBox ThingBoxes::at(std::size_t thing, double time) const {
  const Placed& placed = placed_[thing];
  const Instance& main = scene_.instances[placed.parts.front().instance];
  const Pose worldFromThing = motion(main, time) * placed.worldFromThing;
  Box box;
  for (const Part& part : placed.parts) {
    const Instance& instance = scene_.instances[part.instance];
    std::size_t shape = 0;
    if (instance.animation != nullptr) {
      const auto& meshes = instance.animation->meshes;
      shape = static_cast<std::size_t>(std::ranges::find(meshes, instance.meshAt(time)) - meshes.begin());
    }
    const Box& own = part.ofShape[shape];
    if (own.empty()) continue;
    if (instance.movement == main.movement) {
      box.add(own);
      continue;
    }
    // This part moves differently from the first part, so the corners of its moved box are added.
    const Pose thingFromStart = inverse(worldFromThing) * motion(instance, time) * placed.worldFromThing;
    for (const double x : {own.low.x, own.high.x}) {
      for (const double y : {own.low.y, own.high.y}) {
        for (const double z : {own.low.z, own.high.z}) box.add(thingFromStart * Vec3d{x, y, z});
      }
    }
  }
  return {worldFromThing * Pose{{}, box.center()}, box.high - box.low};
}

Vec3d ThingBoxes::velocity(std::size_t thing, double time) const {
  constexpr double kStep = 0.005;  // s; the velocity is measured over this time before and after `time`
  const Placed& placed = placed_[thing];
  const Instance& main = scene_.instances[placed.parts.front().instance];
  if (main.movement == nullptr) return {};
  const auto positionAt = [&](double when) { return (motion(main, when) * placed.worldFromThing).translation; };
  const double from = std::max(time - kStep, 0.0);
  return (positionAt(time + kStep) - positionAt(from)) * (1 / (time + kStep - from));
}

}  // namespace scanmill
