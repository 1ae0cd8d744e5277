#include "scenefile/object_placer.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "base/hash.h"
#include "base/memory.h"
#include "base/path.h"
#include "base/short_text.h"

namespace scanmill {
namespace {

constexpr double kFarthest = 1e9;  // m, largest coordinate; UTM coordinates reach 1e7 m
constexpr double kLeastScale = 1e-9;
constexpr double kLargestScale = 1e9;

// Reads one scale factor for all axes, or [x, y, z].
Vec3d readScale(const Value& value) {
  Vec3d scale;
  if (value.kind == Value::Kind::Sequence) {
    scale = readVec3(value, "scale");
  } else {
    const double factor = readNumber(value, "scale");
    scale = {factor, factor, factor};
  }
  for (const double factor : {scale.x, scale.y, scale.z}) {
    if (std::abs(factor) < kLeastScale || std::abs(factor) > kLargestScale) {
      throw InputError(value.where, "scale must have an absolute value from 1e-9 to 1e9, not {}", factor);
    }
  }
  return scale;
}

Placement::Copy readCopy(Fields& f) {
  Placement::Copy copy{.pose = f.pose()};
  const Vec3d& p = copy.pose.translation;
  if (std::abs(p.x) > kFarthest || std::abs(p.y) > kFarthest || std::abs(p.z) > kFarthest) {
    throw InputError(f.require("position").where, "position is more than 1e9 m from the origin");
  }
  if (const Value* scale = f.find("scale")) copy.scale = readScale(*scale);
  return copy;
}

void readGrid(const Value& value, Placement& placement) {
  Fields f(value, "grid");
  const Value& count = f.require("count");
  if (count.kind != Value::Kind::Sequence || count.items.size() != 3) {
    throw InputError(count.where, "count must be [nx, ny, nz]");
  }
  for (std::size_t i = 0; i < 3; ++i) {
    placement.gridCount[i] = readInteger(count.items[i], "count", 1, 1'000'000'000);
  }
  placement.gridSpacing = readVec3(f.require("spacing"), "spacing");
  f.finish();
}

void readCopies(const Value& value, Placement& placement) {
  Fields f(value, "copies");
  if (const Value* list = f.find("at")) {
    placement.at.clear();
    for (const Value& item : readList(*list, "at")) {
      Fields fields(item, "copy");
      placement.at.push_back(readCopy(fields));
      fields.finish();
    }
  }
  if (const Value* grid = f.find("grid")) readGrid(*grid, placement);
  f.also({"scatter", "along"}).finish();  // read by Arrangement, see object_placer.h
  const auto& cells = placement.gridCount;
  const double copies = double(cells[0]) * double(cells[1]) * double(cells[2]) * double(placement.at.size());
  if (copies > double(Placement::mostCopies())) {
    throw InputError(value.where, "{} x {} x {} grid cells x {} places = {:.4g} copies, but {}", cells[0], cells[1],
                     cells[2], placement.at.size(), copies, Placement::mostCopiesText());
  }
}

}  // namespace

// Returns the surfaces of the objects that have been placed so far.
const SurfaceHeights& ObjectPlacer::surfaces() {
  if (!heights_) heights_.emplace(builder_.soFar());
  heights_->update();
  return *heights_;
}

// Returns the movements that the key `moving` gives: one for a velocity, or one for each start on a path. The path has
// waypoints, or is on the surfaces of earlier objects.
std::vector<std::shared_ptr<const Movement>> ObjectPlacer::movementsOf(const Value& moving) {
  // The keys that can define the motion, each with the keys that are allowed beside it.
  static const std::map<std::string_view, std::set<std::string_view>> kKeysBeside{
      {"to", {"from", "on", "keep", "speed", "start"}}, {"waypoints", {"ground", "speed", "start"}}, {"velocity", {}}};
  Fields fields(moving, "moving");
  fields.also({"velocity", "waypoints", "from", "to", "on", "keep", "speed", "start", "ground"}).finish();
  const std::string_view mode = fields.has("to") ? "to" : fields.has("waypoints") ? "waypoints" : "velocity";
  if (!fields.has(mode)) {
    throw InputError(moving.where,
                     "moving needs velocity, such as [8, 0, 0] in m/s, or waypoints or from, to and on, with a speed");
  }
  for (const Value::Entry& entry : moving.entries) {
    if (entry.key == mode || !fields.has(entry.key) || kKeysBeside.at(mode).contains(entry.key)) continue;
    throw InputError(entry.value.where, "{} has no effect beside `{}`: leave it out", entry.key, mode);
  }
  if (mode == "velocity") {
    const Vec3d velocity = fields.vec3("velocity", {});
    if (length(velocity) <= kFastestObject) return {std::make_shared<Movement>(velocity)};
    throw InputError(fields.require("velocity").where, "velocity is above {:g} m/s", kFastestObject);
  }
  std::vector<Vec3d> waypoints = fields.has("to") ? findRoadPath(surfaces(), builder_.ontology(), readRoadTrip(fields))
                                                  : readWaypoints(fields.require("waypoints"));
  if (fields.has("ground")) {
    fields.choice("ground", {"drop"}, "");
    waypoints = droppedOnGround(surfaces(), waypoints, fields.require("ground").where);
  }
  const auto path = std::make_shared<const Path>(waypoints);
  const double speed = fields.number("speed", {0.001, kFastestObject});
  const Range limits{0, path->length() * (1 + 1e-9)};  // m; a start at the very end may be rounded
  const Value* const start = fields.find("start");
  const bool isList = start != nullptr && start->kind == Value::Kind::Sequence;
  const std::vector<double> starts =
      isList ? fields.numbers("start", limits) : std::vector{fields.number("start", limits, 0)};
  if (starts.empty()) throw InputError(fields.require("start").where, "start must be at least one distance in m");
  std::vector<std::shared_ptr<const Movement>> movements;
  movements.reserve(starts.size());
  for (const double distance : starts) {
    movements.push_back(std::make_shared<Movement>(path, std::min(distance, path->length()), speed));
  }
  return movements;
}

Copies ObjectPlacer::read(Fields& object) {
  constexpr std::pair<const char*, double> kDirections[]{{"x", 0}, {"y", kPi / 2}, {"-x", kPi}, {"-y", -kPi / 2}};
  Copies copies{readPlacement(object), Arrangement(object, builder_.ontology()), object.text("thing", "")};
  if (object.has("facing")) copies.facing = namedChoice(object, "facing", kDirections, 0.0).second;
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

// Returns the z (m, world frame) of the lowest point of an asset's meshes.
double ObjectPlacer::lowestZ(const std::vector<PlacedMesh>& meshes, const Affine& worldFromAsset) const {
  double lowest = std::numeric_limits<double>::infinity();
  for (const PlacedMesh& placed : meshes) {
    const Mesh& mesh = builder_.soFar().meshes[placed.mesh];
    const Box box = mesh.bounds();
    const auto addMesh = [&](const Affine& worldFromMesh) {
      // A corner of a tilted box can be lower than the mesh.
      if (worldFromMesh.linear.x.z != 0 || worldFromMesh.linear.y.z != 0) {
        for (const Vec3f& p : mesh.positions) lowest = std::min(lowest, (worldFromMesh * Vec3d(p)).z);
        return;
      }
      lowest = std::min(lowest, boxAround(worldFromMesh, box).low.z);
    };
    if (placed.assetFromMesh.empty()) addMesh(worldFromAsset);
    for (const Affine& assetFromMesh : placed.assetFromMesh) addMesh(worldFromAsset * assetFromMesh);
  }
  return lowest;
}

void ObjectPlacer::place(const Variants& variants, const std::string& name, const Copies& copies,
                         const Location& where) {
  random_ = random_ || copies.arrangement.random() || variants.count > 1;
  std::vector<const std::vector<PlacedMesh>*> loaded(variants.count, nullptr);
  const auto meshesOf = [&](std::size_t variant) -> const std::vector<PlacedMesh>& {
    if (loaded[variant] == nullptr) loaded[variant] = &variants.meshes(variant);
    return *loaded[variant];
  };
  // An object's random numbers depend only on the scene's seed, the object's name, and how many earlier objects have
  // that name, not on objects with other names. Objects with the same `thing` share their numbers, so that their n-th
  // copies stay together.
  const std::uint32_t object = copies.thing.empty() ? fnv1a(fmt::format("{}\n{}", name, objectsByName_[name]++))
                                                    : fnv1a("thing\n" + copies.thing);
  const std::vector<Arrangement::Copy> arranged = copies.arrangement.copies(
      copies.placement, builder_.soFar(), copies.arrangement.needsSurfaces() ? &surfaces() : nullptr, seed_, object,
      variants.count, [&](const Arrangement::Copy& c) { return lowestZ(meshesOf(c.variant), c.worldFromMesh); });
  const std::size_t perCopy = std::max<std::size_t>(copies.movements.size(), 1);
  std::uint64_t meshCount = 0;
  for (const Arrangement::Copy& copy : arranged) {
    for (const PlacedMesh& m : meshesOf(copy.variant)) {
      meshCount += perCopy * std::max<std::size_t>(m.assetFromMesh.size(), 1);
    }
  }
  placedMeshes_ += meshCount;
  if (placedMeshes_ > Placement::mostCopies()) {
    throw InputError(where, "with these {} copies the scene has {} placed objects, but {}", meshCount, placedMeshes_,
                     Placement::mostCopiesText());
  }
  // A single copy has the name of the object; several copies are called NAME#1, NAME#2 and so on. Meshes that the
  // asset's file places several times are called NAME/NODE 1 or NAME#1/NODE 1.
  std::uint64_t number = 0;
  for (const auto& [worldFromAsset, variant, copyNumber] : arranged) {
    for (std::size_t m = 0; m < perCopy; ++m) {
      ++number;
      const std::shared_ptr<const Movement> movement = copies.movements.empty() ? nullptr : copies.movements[m];
      const std::string copyName = arranged.size() * perCopy == 1 ? name : fmt::format("{}#{}", name, number);
      const std::string thing =
          copies.thing.empty() ? "" : fmt::format("{}#{}", copies.thing, (copyNumber - 1) * perCopy + m + 1);
      const std::vector<PlacedMesh>& meshes = meshesOf(variant);
      for (const PlacedMesh& placed : meshes) {
        const auto put = [&](const Affine& worldFromMesh, const std::string& meshName, const auto& animation) {
          builder_.place(placed.mesh, worldFromMesh, meshName, where, movement, animation, thing).facing =
              copies.facing;
        };
        if (placed.assetFromMesh.empty()) put(worldFromAsset, copyName, copies.animation);
        const bool isOnly = meshes.size() == 1 && placed.assetFromMesh.size() == 1;
        for (std::size_t i = 0; i < placed.assetFromMesh.size(); ++i) {
          put(worldFromAsset * placed.assetFromMesh[i],
              isOnly ? copyName : fmt::format("{}/{} {}", copyName, placed.node, i + 1), nullptr);
        }
      }
    }
  }
}

void ObjectPlacer::place(std::uint32_t mesh, const std::string& name, const Copies& copies, const Location& where) {
  const std::vector<PlacedMesh> meshes{{mesh, {}, {}}};
  place({1, [&](std::size_t) -> const std::vector<PlacedMesh>& { return meshes; }}, name, copies, where);
}

std::uint64_t Placement::mostCopies() {
  constexpr std::uint64_t kMost = 10'000'000;
  constexpr std::uint64_t kCopyBytes = 1000;  // of an instance: its name, its poses, and its part of Embree's hierarchy
  return std::min(kMost, memoryLimitBytes() / 2 / kCopyBytes);
}

std::string Placement::mostCopiesText() {
  return fmt::format("at most {} are possible with {} of memory (--memory-limit, the machine or its container)",
                     grouped(mostCopies()), shortBytes(memoryLimitBytes()));
}

std::uint64_t Placement::count() const {
  return static_cast<std::uint64_t>(gridCount[0] * gridCount[1] * gridCount[2]) * at.size();
}

void Placement::forEach(const std::function<void(const Affine&)>& visit) const {
  for (std::int64_t k = 0; k < gridCount[2]; ++k) {
    for (std::int64_t j = 0; j < gridCount[1]; ++j) {
      for (std::int64_t i = 0; i < gridCount[0]; ++i) {
        const Vec3d cell{double(i) * gridSpacing.x, double(j) * gridSpacing.y, double(k) * gridSpacing.z};
        for (const auto& [pose, scale] : at) {
          const Affine worldFromCopy = toAffine(object.pose * Pose{{}, cell} * pose);
          const Vec3d& s = object.scale;
          visit(worldFromCopy * Affine{Mat3::scale({s.x * scale.x, s.y * scale.y, s.z * scale.z}), {}});
        }
      }
    }
  }
}

Placement readPlacement(Fields& object) {
  Placement placement;
  placement.object = readCopy(object);
  if (const Value* copies = object.find("copies")) readCopies(*copies, placement);
  return placement;
}

std::array<double, 4> readRectangle(const Value& value, std::string_view key) {
  std::vector<double> limits;
  for (const Value& corner : value.items) {
    for (const double coordinate : readNumbers(corner, key)) limits.push_back(coordinate);
  }
  if (value.kind != Value::Kind::Sequence || limits.size() != 4 || limits[0] >= limits[2] || limits[1] >= limits[3]) {
    throw InputError(value.where,
                     "{} must be [[x, y], [x, y]]: the corner with the least coordinates, "
                     "then the one with the greatest",
                     key);
  }
  return {limits[0], limits[1], limits[2], limits[3]};
}

}  // namespace scanmill
