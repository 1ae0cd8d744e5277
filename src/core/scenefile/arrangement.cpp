#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "base/error.h"
#include "base/path.h"
#include "base/random.h"
#include "config/fields.h"
#include "scene/surface_heights.h"
#include "scenefile/object_placer.h"

namespace scanmill {
namespace {

// Limits of the search for positions of copies, chosen by eye.
constexpr std::uint64_t kTriesPerCopy = 30;         // tries for each copy if only `count` is given, not `distance_from`
constexpr std::uint64_t kMostMissesInRow = 30'000;  // with `count`, the search ends after this many rejections
constexpr double kCoverHeight = 0.05;  // m; a surface is covered if another surface lies more than this above it
constexpr double kSameHeight = 1e-3;   // m; surfaces whose heights differ by less are the same surface

// Purposes of random numbers. The values are part of the addresses of the random numbers and never change.
enum class Draw : std::uint32_t { Place = 0, Pose = 1, Direction = 2, Variant = 3 };

// Returns the random numbers for an object's n-th try (Draw::Place) or n-th copy (all other purposes).
RandomBlock draw(std::uint64_t seed, std::uint32_t object, std::uint64_t n, Draw purpose) {
  return randomBlock({seed, object, static_cast<std::uint32_t>(n), static_cast<std::uint32_t>(purpose),
                      static_cast<std::uint32_t>(n >> 32), 0, Purpose::Placement});
}

// Throws InputError if `count` is more than the number of copies that a scene may have.
void refuseTooMany(double count, const Location& where) {
  if (count > static_cast<double>(Placement::mostCopies())) {
    throw InputError(where, "{:.4g} copies are too many: {}", count, Placement::mostCopiesText());
  }
}

std::vector<std::uint16_t> readClasses(Fields& f, const char* key, const Ontology& ontology) {
  const Location where = f.require(key).where;
  std::vector<std::uint16_t> ids = classIds(ontology, f.texts(key), where);
  if (ids.empty()) throw InputError(where, "{} must name at least one class", key);
  return ids;
}

// Accepts positions that keep a least horizontal distance `spacing` (m) from each other; 0: accepts all positions.
class Spaced {
 public:
  explicit Spaced(double spacing) : spacing_(spacing) {}

  // Returns true, and remembers the position, if it is at least `spacing` from every position accepted before.
  bool accept(const Vec3d& position) {
    if (spacing_ <= 0) return true;
    const auto column = static_cast<std::int64_t>(std::floor(position.x / spacing_));
    const auto row = static_cast<std::int64_t>(std::floor(position.y / spacing_));
    for (std::int64_t i = column - 1; i <= column + 1; ++i) {
      for (std::int64_t j = row - 1; j <= row + 1; ++j) {
        const auto cell = acceptedByCell_.find({i, j});
        if (cell == acceptedByCell_.end()) continue;
        for (const Vec3d& accepted : cell->second) {
          if (std::hypot(position.x - accepted.x, position.y - accepted.y) < spacing_) return false;
        }
      }
    }
    acceptedByCell_[{column, row}].push_back(position);
    return true;
  }

 private:
  double spacing_;
  // Accepted positions by column and row of cells with the edge `spacing`; near positions are in neighbouring cells.
  std::map<std::pair<std::int64_t, std::int64_t>, std::vector<Vec3d>> acceptedByCell_;
};

// Reads the key `distance_from`: {class: [least, most]} or {class: least}, in m.
std::vector<Arrangement::Distance> readDistances(const Value& value, const Ontology& ontology) {
  if (value.kind != Value::Kind::Map || value.entries.empty()) {
    throw InputError(value.where, "distance_from must be {class: [least, most]} in m, or {class: least}");
  }
  std::vector<Arrangement::Distance> distances;
  for (const auto& [name, limits] : value.entries) {
    Arrangement::Distance distance{.semantic = ontology.require(name, limits.where).id, .where = limits.where};
    constexpr Range kDistances{0, 1000};  // m
    if (limits.kind == Value::Kind::Sequence) {
      const std::vector<double> leastAndMost = readNumbers(limits, "distance_from", kDistances);
      if (leastAndMost.size() != 2 || leastAndMost[0] > leastAndMost[1]) {
        throw InputError(limits.where, "a distance must be [least, most] in m, or only the least");
      }
      distance.least = leastAndMost[0];
      distance.most = leastAndMost[1];
    } else {
      distance.least = readNumber(limits, "distance_from", kDistances);
    }
    distances.push_back(distance);
  }
  return distances;
}

Arrangement::Scatter readScatter(const Value& value, const Ontology& ontology) {
  Fields fields(value, "scatter");
  fields.also({"on", "count", "density", "spacing", "slope_deg", "within", "covered", "distance_from"}).finish();
  Arrangement::Scatter scatter;
  scatter.where = value.where;
  scatter.classes = readClasses(fields, "on", ontology);
  if (fields.has("count") == fields.has("density")) {
    throw InputError(value.where, "scatter needs either `count` or `density` (copies per square metre)");
  }
  const auto mostCopies = static_cast<std::int64_t>(Placement::mostCopies());
  if (fields.has("count")) scatter.count = static_cast<std::uint64_t>(fields.integer("count", 1, mostCopies));
  scatter.density = fields.number("density", {1e-9, 1e4}, 0);
  if (fields.has("spacing")) scatter.spacing = fields.number("spacing", {1e-3, 1e5});
  scatter.slope = radians(fields.number("slope_deg", {0, 90}, 90));
  scatter.covered = fields.boolean("covered", false);
  if (const Value* limits = fields.find("distance_from")) scatter.distances = readDistances(*limits, ontology);
  if (const Value* within = fields.find("within")) scatter.within = readRectangle(*within, "within");
  return scatter;
}

Arrangement::Along readAlong(const Value& value) {
  Fields f(value, "along");
  f.also({"waypoints", "from", "to", "on", "keep", "every", "left"}).finish();
  if (f.has("to") == f.has("waypoints")) {
    throw InputError(value.where, "along needs either waypoints or, for a path on a road, from, to and on");
  }
  Arrangement::Along along;
  along.interval = f.number("every", {1e-3, 1e6});
  along.leftOffset = f.number("left", {-1e5, 1e5}, 0);
  along.where = value.where;
  if (f.has("to")) along.trip = readRoadTrip(f);
  if (f.has("waypoints")) along.waypoints = readWaypoints(f.require("waypoints"));
  return along;
}

// Returns, for each limit, an object that computes distances to surfaces of the limit's class. If the scene has no
// triangle of a limit's class, throws InputError if the limit has a largest distance, otherwise warns.
std::vector<SurfaceDistance> classDistances(const Scene& scene, const std::vector<Arrangement::Distance>& limits) {
  std::vector<SurfaceDistance> distances;
  for (const Arrangement::Distance& limit : limits) {
    const double range = std::isfinite(limit.most) ? limit.most : limit.least;
    if (!distances.emplace_back(scene, std::vector{limit.semantic}, range).empty()) continue;
    const std::string none = fmt::format("no earlier object of the list has triangles of the class {}",
                                         scene.ontology.find(limit.semantic)->name);
    if (std::isfinite(limit.most)) throw InputError(limit.where, none + ", to which these copies must be near");
    warn("{}: {}, from which these copies must keep a distance: list the objects of this class first",
         limit.where.text(), none);
  }
  return distances;
}

// True if a position is within all limits. `distances`: the result of classDistances() for the same limits.
bool keepsDistances(const std::vector<Arrangement::Distance>& limits, const std::vector<SurfaceDistance>& distances,
                    const Vec3d& position) {
  for (std::size_t i = 0; i < limits.size(); ++i) {
    const double distance = distances[i].at(position.x, position.y);
    if (distance < limits[i].least || distance > limits[i].most) return false;
  }
  return true;
}

// Returns the number of copies that `count` or `density` gives for an area. Throws InputError for 0 or too many copies.
std::uint64_t requestedCopies(const Arrangement::Scatter& scatter, double squareMetres) {
  const double copies = scatter.count ? static_cast<double>(*scatter.count) : scatter.density * squareMetres;
  refuseTooMany(copies, scatter.where);
  const auto rounded = static_cast<std::uint64_t>(std::llround(copies));
  if (rounded > 0) return rounded;
  throw InputError(scatter.where, "gives {:.2g} copies on {:.4g} square metres: give a higher density, or a count",
                   copies, squareMetres);
}

// Returns `position` moved vertically to the highest suitable surface; nothing if there is none. Without `within`, only
// surfaces at the position's own height are suitable. Covered surfaces are suitable only if `covered` is true.
std::optional<Vec3d> scatterPoint(const Arrangement::Scatter& scatter, const SurfaceHeights& heights,
                                  const Vec3d& position) {
  const std::vector<SurfaceHeights::Surface> surfaces = heights.at(position.x, position.y);  // the highest first
  for (const SurfaceHeights::Surface& surface : surfaces) {
    if (!scatter.covered && surface.height < surfaces.front().height - kCoverHeight) break;
    const bool hasClass = std::ranges::find(scatter.classes, surface.semantic) != scatter.classes.end();
    const bool hasHeight = scatter.within || std::fabs(surface.height - position.z) < kSameHeight;
    if (hasClass && hasHeight && surface.slope <= scatter.slope) return Vec3d{position.x, position.y, surface.height};
  }
  return std::nullopt;
}

// Keeps each copy with the probability `presence`; returns the kept copies with random rotations, scales and
// displacements. The random numbers of a copy depend on its index in `copies`.
std::vector<Arrangement::Copy> varied(const Arrangement::Vary& vary, const std::vector<Arrangement::Copy>& copies,
                                      std::uint64_t seed, std::uint32_t object) {
  std::vector<Arrangement::Copy> keptCopies;
  for (std::uint64_t index = 0; index < copies.size(); ++index) {
    const RandomBlock random = draw(seed, object, index, Draw::Pose);
    if (uniform(random[0]) >= vary.presence) continue;
    const double yaw = vary.yaw.low + (vary.yaw.high - vary.yaw.low) * uniform(random[1]);
    const double scale = vary.scale.low + (vary.scale.high - vary.scale.low) * uniform(random[2]);
    const double distance = vary.position * std::sqrt(uniform(random[3]));
    const double direction = 2 * kPi * uniform(draw(seed, object, index, Draw::Direction)[0]);
    Arrangement::Copy copy = copies[index];
    copy.worldFromMesh.translation += Vec3d{std::cos(direction), std::sin(direction), 0} * distance;
    copy.worldFromMesh.linear =
        toMatrix(fromYawPitchRoll(yaw, 0, 0)) * copy.worldFromMesh.linear * Mat3::scale({scale, scale, scale});
    keptCopies.push_back(copy);
  }
  return keptCopies;
}

// Returns poses at random positions on the surfaces of the scatter, with random yaws.
std::vector<Pose> scattered(const Arrangement::Scatter& scatter, const Scene& scene, const SurfaceHeights& heights,
                            std::uint64_t seed, std::uint32_t object) {
  const SurfaceHeights::Area area = heights.area(scatter.classes);
  if (area.squareMetres() <= 0) {
    throw InputError(scatter.where,
                     "no surface to scatter on: no earlier object of the list has triangles of these classes that face "
                     "up (`scanmill info` of the scene lists its classes), and later objects are placed afterwards");
  }
  const auto [lowX, lowY, highX, highY] = scatter.within.value_or(std::array<double, 4>{});
  const std::uint64_t copies =
      requestedCopies(scatter, scatter.within ? (highX - lowX) * (highY - lowY) : area.squareMetres());
  const std::vector<SurfaceDistance> distances = classDistances(scene, scatter.distances);
  // With a density, each copy has one try; a copy whose try fails is left out. With a count, there are several tries
  // for each copy, and the search ends after kMostMissesInRow failures in a row.
  const std::uint64_t triesPerCopy = !scatter.count ? 1 : scatter.distances.empty() ? kTriesPerCopy : kMostMissesInRow;
  const std::uint64_t mostMisses = scatter.count ? kMostMissesInRow : std::numeric_limits<std::uint64_t>::max();
  std::uint64_t misses = 0;  // since the last accepted position
  std::vector<Pose> poses;
  Spaced spaced(scatter.spacing);
  for (std::uint64_t n = 0; n < triesPerCopy * copies && poses.size() < copies && misses < mostMisses; ++n) {
    const RandomBlock random = draw(seed, object, n, Draw::Place);
    const std::array<double, 3> u{uniform(random[0]), uniform(random[1]), uniform(random[2])};
    const Vec3d candidate =
        scatter.within ? Vec3d{lowX + (highX - lowX) * u[0], lowY + (highY - lowY) * u[1], 0} : area.sample(u);
    const std::optional<Vec3d> position = scatterPoint(scatter, heights, candidate);
    ++misses;
    if (!position || !keepsDistances(scatter.distances, distances, *position) || !spaced.accept(*position)) continue;
    misses = 0;
    poses.push_back({fromYawPitchRoll(2 * kPi * uniform(random[3]), 0, 0), *position});
  }
  if (scatter.count && poses.size() < copies) {
    throw InputError(scatter.where,
                     "only {} of {} copies fit with the seed {}: give a smaller count or spacing, "
                     "wider distances, or more classes or a larger area to scatter on",
                     poses.size(), copies, seed);
  }
  return poses;
}

// Returns poses at equal distances along the path, with the path's heading but without pitch and roll. `heights` may be
// null unless the path is on roads.
std::vector<Pose> alongPath(const Arrangement::Along& along, const Scene& scene, const SurfaceHeights* heights) {
  const Path path(along.trip ? findRoadPath(*heights, scene.ontology, *along.trip) : along.waypoints);
  constexpr double kRounding = 1 + 1e-12;  // a pose at the path's very end must not be lost by rounding
  const double count = std::floor(path.length() / along.interval * kRounding) + 1;
  refuseTooMany(count, along.where);
  std::vector<Pose> poses;
  for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(count); ++i) {
    const Pose onPath = path.pose(static_cast<double>(i) * along.interval);
    const Quat level = fromYawPitchRoll(headingOf(onPath.rotation), 0, 0);
    poses.push_back({level, onPath.translation + toMatrix(level).y * along.leftOffset});
  }
  return poses;
}

// Returns the copies below or above which there is a surface of `stand_on`, each moved vertically so that its lowest
// point touches the surface. Warns of copies without such a surface; throws InputError if no copy has one.
std::vector<Arrangement::Copy> stoodOnSurfaces(const Arrangement::StandOn& standOn,
                                               const std::vector<Arrangement::Copy>& copies,
                                               const SurfaceHeights& heights, std::uint64_t seed,
                                               const std::function<double(const Arrangement::Copy&)>& lowestZ) {
  const std::vector<std::uint16_t>& classes = standOn.classes;
  const auto carries = [&](const SurfaceHeights::Surface& surface) {
    return classes.empty() ? !surface.thing : std::ranges::find(classes, surface.semantic) != classes.end();
  };
  std::vector<Arrangement::Copy> standing;
  std::optional<Vec3d> firstWithoutGround;  // position of the first copy without a surface
  for (Arrangement::Copy copy : copies) {
    Vec3d& position = copy.worldFromMesh.translation;
    if (const auto ground = heights.under(position, carries)) {
      position.z += ground->height - lowestZ(copy);
      standing.push_back(copy);
    } else if (!firstWithoutGround) {
      firstWithoutGround = position;
    }
  }
  if (!firstWithoutGround) return standing;
  const std::string reason = fmt::format(
      "no surface to stand on at [{:.6g}, {:.6g}]: earlier objects of the list have no surface there {}that is less "
      "than 60 degrees steep (later objects are placed afterwards)",
      firstWithoutGround->x, firstWithoutGround->y, classes.empty() ? "" : "of these classes ");
  if (standing.empty()) throw InputError(standOn.where, reason);
  warn("{}: left out {} of {} copies with the seed {}: {}", standOn.where.text(), copies.size() - standing.size(),
       copies.size(), seed, reason);
  return standing;
}

}  // namespace

Arrangement::Arrangement(Fields& object, const Ontology& ontology) {
  if (const Value* copies = object.find("copies"); copies != nullptr && copies->kind == Value::Kind::Map) {
    if (const Value* scatter = copies->find("scatter")) scatter_ = readScatter(*scatter, ontology);
    if (const Value* along = copies->find("along")) {
      if (scatter_) throw InputError(along->where, "copies must have either `scatter` or `along`, not both");
      along_ = readAlong(*along);
    }
  }
  if (const Value* value = object.find("vary")) {
    Fields fields(*value, "vary");
    fields.also({"yaw_deg", "scale", "position", "presence", "material"}).finish();
    materials_ = fields.texts("material");
    const Range yaw = fields.range("yaw_deg", {-360, 360}).value_or(Range{0, 0});
    vary_ = Vary{.yaw = {radians(yaw.low), radians(yaw.high)},
                 .scale = fields.range("scale", {1e-3, 1e3}).value_or(Range{1, 1}),
                 .position = fields.number("position", {0, 1e5}, 0),
                 .presence = fields.number("presence", {0, 1}, 1)};
    if (vary_->position > 0 && scatter_ && !object.has("stand_on")) {
      throw InputError(fields.require("position").where,
                       "position would move scattered copies off their surface: leave it out, or add stand_on");
    }
  }
  if (const Value* value = object.find("stand_on")) {
    const bool ground = value->kind == Value::Kind::Scalar && value->text == "ground" && !value->quoted;
    standOn_ = StandOn{ground ? std::vector<std::uint16_t>() : readClasses(object, "stand_on", ontology), value->where};
  }
}

std::vector<Arrangement::Copy> Arrangement::copies(const Placement& placement, const Scene& scene,
                                                   const SurfaceHeights* heights, std::uint64_t seed,
                                                   std::uint32_t object, std::size_t variants,
                                                   const std::function<double(const Copy&)>& lowestZ) const {
  std::vector<Pose> basePoses{Pose{}};  // `placement` places all its copies at each of these poses
  if (scatter_) basePoses = scattered(*scatter_, scene, *heights, seed, object);
  if (along_) basePoses = alongPath(*along_, scene, heights);
  if (basePoses.size() * placement.count() > Placement::mostCopies()) {
    const Location where = scatter_ ? scatter_->where : along_ ? along_->where : Location{};
    throw InputError(where, "{} places with {} copies each are too many: {}", basePoses.size(), placement.count(),
                     Placement::mostCopiesText());
  }
  std::vector<Copy> copies;
  for (const Pose& basePose : basePoses) {
    placement.forEach([&](const Affine& baseFromMesh) {
      const double u = variants > 1 ? uniform(draw(seed, object, copies.size(), Draw::Variant)[0]) : 0;
      const auto variant = std::min(static_cast<std::size_t>(u * static_cast<double>(variants)), variants - 1);
      copies.push_back({toAffine(basePose) * baseFromMesh, variant, copies.size() + 1});
    });
  }
  if (vary_) copies = varied(*vary_, copies, seed, object);
  return standOn_ ? stoodOnSurfaces(*standOn_, copies, *heights, seed, lowestZ) : copies;
}

}  // namespace scanmill
