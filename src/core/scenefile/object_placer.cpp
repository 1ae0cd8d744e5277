#include "scenefile/object_placer.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>
#include <string_view>

#include "base/hash.h"
#include "base/path.h"
#include "config/fields.h"
#include "config/waypoints.h"
#include "scene/road_path.h"

namespace scanmill {
namespace {

// Returns the direction in which the object faces (rad about z, from its x axis).
std::optional<double> readFacing(Fields& object) {
  constexpr std::pair<const char*, double> kDirections[]{{"x", 0}, {"y", kPi / 2}, {"-x", kPi}, {"-y", -kPi / 2}};
  return object.has("facing") ? std::optional(namedChoice(object, "facing", kDirections, 0.0).second) : std::nullopt;
}

}  // namespace

// Returns the surfaces of the objects that have been placed.
const SurfaceHeights& ObjectPlacer::surfaces() {
  if (!heights_) heights_.emplace(builder_.soFar());
  heights_->update();
  return *heights_;
}

// Reads the key `moving`: a velocity, or a path by waypoints or on the surfaces of earlier objects, with one or several
// starts.
std::vector<std::shared_ptr<const Movement>> ObjectPlacer::movementsOf(const Value& moving) {
  static const std::map<std::string_view, std::set<std::string_view>> kKeysBeside{
      {"to", {"from", "on", "keep", "speed", "start"}}, {"waypoints", {"ground", "speed", "start"}}, {"velocity", {}}};
  Fields f(moving, "moving");
  f.also({"velocity", "waypoints", "from", "to", "on", "keep", "speed", "start", "ground"}).finish();
  const std::string_view by = f.has("to") ? "to" : f.has("waypoints") ? "waypoints" : "velocity";
  if (!f.has(by)) {
    throw InputError(moving.where,
                     "moving needs velocity, such as [8, 0, 0] in m/s, or waypoints or from, to and on, with a speed");
  }
  for (const Value::Entry& entry : moving.entries) {
    if (entry.key == by || !f.has(entry.key) || kKeysBeside.at(by).contains(entry.key)) continue;
    throw InputError(entry.value.where, fmt::format("{} has no effect beside `{}`: leave it out", entry.key, by));
  }
  if (by == "velocity") {
    const Vec3d velocity = f.vec3("velocity", {});
    if (length(velocity) <= kFastestObject) return {std::make_shared<Movement>(velocity)};
    throw InputError(f.require("velocity").where, fmt::format("velocity is above {:g} m/s", kFastestObject));
  }
  std::vector<Vec3d> points = f.has("to") ? findRoadPath(surfaces(), builder_.ontology(), readRoadTrip(f))
                                          : readWaypoints(f.require("waypoints"));
  if (f.has("ground")) {
    f.choice("ground", {"drop"}, "");
    points = droppedOnGround(surfaces(), points, f.require("ground").where);
  }
  const auto path = std::make_shared<const Path>(points);
  const double speed = f.number("speed", {0.001, kFastestObject});
  const Range along{0, path->length() * (1 + 1e-9)};
  const Value* const start = f.find("start");
  const bool several = start != nullptr && start->kind == Value::Kind::Sequence;
  const std::vector<double> starts = several ? f.numbers("start", along) : std::vector{f.number("start", along, 0)};
  std::vector<std::shared_ptr<const Movement>> movements;
  for (const double at : starts) {
    movements.push_back(std::make_shared<Movement>(path, std::min(at, path->length()), speed));
  }
  if (movements.empty()) throw InputError(start->where, "start must be at least one distance in m");
  return movements;
}

Copies ObjectPlacer::read(Fields& object) {
  Copies copies{readPlacement(object), Arrangement(object, builder_.ontology()), object.text("thing", ""), {}, nullptr,
                readFacing(object)};
  const Value* const moving = object.find("moving");
  if (moving == nullptr) return copies;
  if (copies.arrangement.needsSurfaces()) {
    throw InputError(
        moving->where,
        "scatter and stand_on are for objects that stand still: give the path of a moving object its heights instead");
  }
  copies.movements = movementsOf(*moving);
  return copies;
}

// Returns the height (m) of the lowest point of some meshes under a pose.
double ObjectPlacer::lowestOf(const std::vector<PlacedMesh>& meshes, const Affine& worldFromAsset) const {
  double lowest = std::numeric_limits<double>::infinity();
  for (const PlacedMesh& m : meshes) {
    const Mesh& mesh = builder_.soFar().meshes[m.mesh];
    const Box box = mesh.bounds();
    const auto add = [&](const Affine& worldFromMesh) {
      // A corner of a tilted box can be lower than the mesh.
      if (worldFromMesh.linear.x.z != 0 || worldFromMesh.linear.y.z != 0) {
        for (const Vec3f& p : mesh.positions) lowest = std::min(lowest, (worldFromMesh * Vec3d(p)).z);
        return;
      }
      lowest = std::min(lowest, boxAround(worldFromMesh, box).low.z);
    };
    if (m.assetFromMesh.empty()) add(worldFromAsset);
    for (const Affine& assetFromMesh : m.assetFromMesh) add(worldFromAsset * assetFromMesh);
  }
  return lowest;
}

// An object's random numbers depend only on the scene's seed, the object's name, and how many earlier objects have that
// name. Other objects do not change them. Objects with the same `thing` share their numbers, so that their n-th copies
// stay together.
std::vector<Arrangement::Copy> ObjectPlacer::placesOf(const Copies& copies, const std::string& name,
                                                      std::size_t variants, const Chosen& meshesOf) {
  const std::uint32_t object =
      copies.thing.empty() ? fnv1a(fmt::format("{}\n{}", name, named_[name]++)) : fnv1a("thing\n" + copies.thing);
  const SurfaceHeights* const heights = copies.arrangement.needsSurfaces() ? &surfaces() : nullptr;
  return copies.arrangement.places(
      copies.placement, builder_.soFar(), heights, seed_, object, variants,
      [&](const Arrangement::Copy& c) { return lowestOf(meshesOf(c.variant), c.worldFromMesh); });
}

void ObjectPlacer::place(const Variants& variants, const std::string& name, const Copies& copies,
                         const Location& where) {
  random_ = random_ || copies.arrangement.random() || variants.count > 1;
  std::vector<const std::vector<PlacedMesh>*> known(variants.count, nullptr);
  const Chosen meshesOf = [&](std::size_t k) -> const std::vector<PlacedMesh>& {
    if (known[k] == nullptr) known[k] = &variants.meshes(k);
    return *known[k];
  };
  const std::vector<Arrangement::Copy> places = placesOf(copies, name, variants.count, meshesOf);
  std::uint64_t count = 0;
  for (const Arrangement::Copy& copy : places) {
    for (const PlacedMesh& m : meshesOf(copy.variant)) count += std::max<std::size_t>(m.assetFromMesh.size(), 1);
  }
  const std::size_t rows = std::max<std::size_t>(copies.movements.size(), 1);
  count *= rows;
  placed_ += count;
  if (placed_ > Placement::mostCopies()) {
    throw InputError(where, fmt::format("with these {} copies the scene has {} placed objects, but {}", count, placed_,
                                        Placement::mostCopiesText()));
  }
  std::uint64_t number = 0;
  for (const auto& [worldFromAsset, variant, copyNumber] : places) {
    for (std::size_t row = 0; row < rows; ++row) {
      ++number;
      const std::shared_ptr<const Movement> movement = copies.movements.empty() ? nullptr : copies.movements[row];
      const std::string own = places.size() * rows == 1 ? name : fmt::format("{}#{}", name, number);
      const std::string thing =
          copies.thing.empty() ? "" : fmt::format("{}#{}", copies.thing, (copyNumber - 1) * rows + row + 1);
      const std::vector<PlacedMesh>& meshes = meshesOf(variant);
      for (const PlacedMesh& m : meshes) {
        const auto put = [&](const Affine& worldFromMesh, const std::string& called, const auto& animation) {
          builder_.place(m.mesh, worldFromMesh, called, where, movement, animation, thing).facing = copies.facing;
        };
        if (m.assetFromMesh.empty()) put(worldFromAsset, own, copies.animation);
        for (std::size_t i = 0; i < m.assetFromMesh.size(); ++i) {
          const bool alone = meshes.size() == 1 && m.assetFromMesh.size() == 1;
          put(worldFromAsset * m.assetFromMesh[i], alone ? own : fmt::format("{}/{} {}", own, m.node, i + 1), nullptr);
        }
      }
    }
  }
}

void ObjectPlacer::place(const std::vector<PlacedMesh>& meshes, const std::string& name, const Copies& copies,
                         const Location& where) {
  place({1, [&](std::size_t) -> const std::vector<PlacedMesh>& { return meshes; }}, name, copies, where);
}

}  // namespace scanmill
