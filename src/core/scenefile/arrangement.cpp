#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "base/error.h"
#include "base/path.h"
#include "base/random.h"
#include "config/waypoints.h"
#include "scene/surface_heights.h"
#include "scenefile/object_placer.h"

namespace scanmill {
namespace {

constexpr std::uint64_t kTries = 30;       // tries per copy, if `count` is given without `distance_from`
constexpr std::uint64_t kMisses = 30'000;  // rejected places in a row after which the search for a `count` ends
constexpr double kOverhead = 0.05;         // m; a surface is covered if another surface lies more than this above it
constexpr double kSame = 1e-3;             // m; surfaces whose heights differ by less are the same surface

// Purposes of the random numbers of an object's copy. The values are part of their addresses and never change.
enum class Draw : std::uint32_t { Place = 0, Pose = 1, Direction = 2, Variant = 3 };

// Returns the random numbers of an object's n-th try (Draw::Place) or n-th copy.
RandomBlock draw(std::uint64_t seed, std::uint32_t object, std::uint64_t n, Draw what) {
  return randomBlock({seed, object, static_cast<std::uint32_t>(n), static_cast<std::uint32_t>(what),
                      static_cast<std::uint32_t>(n >> 32), 0, Purpose::Placement});
}

void refuseTooMany(double count, const Location& where) {
  if (count > static_cast<double>(Placement::mostCopies())) {
    throw InputError(where, fmt::format("{:.4g} copies are too many: {}", count, Placement::mostCopiesText()));
  }
}

std::vector<std::uint16_t> readClasses(Fields& f, const char* key, const Ontology& ontology) {
  const Location where = f.require(key).where;
  std::vector<std::uint16_t> ids = classIds(ontology, f.texts(key), where);
  if (ids.empty()) throw InputError(where, fmt::format("{} must name at least one class", key));
  return ids;
}

// Accepts a place if its horizontal distance from every place accepted before is at least `spacing` (m).
class Spaced {
 public:
  explicit Spaced(double spacing) : spacing_(spacing) {}
  bool take(const Vec3d& p) {
    if (spacing_ <= 0) return true;
    const auto cell = [&](double d) { return static_cast<std::int64_t>(std::floor(d / spacing_)); };
    for (std::int64_t i = cell(p.x) - 1; i <= cell(p.x) + 1; ++i) {
      for (std::int64_t j = cell(p.y) - 1; j <= cell(p.y) + 1; ++j) {
        const auto cellOf = places_.find({i, j});
        if (cellOf == places_.end()) continue;
        for (const Vec3d& other : cellOf->second) {
          if (std::hypot(p.x - other.x, p.y - other.y) < spacing_) return false;
        }
      }
    }
    places_[{cell(p.x), cell(p.y)}].push_back(p);
    return true;
  }

 private:
  double spacing_;
  std::map<std::pair<std::int64_t, std::int64_t>, std::vector<Vec3d>> places_;
};

std::vector<Arrangement::Distance> readDistances(const Value& value, const Ontology& ontology) {
  if (value.kind != Value::Kind::Map || value.entries.empty()) {
    throw InputError(value.where, "distance_from must be {class: [least, most]} in m, or {class: least}");
  }
  std::vector<Arrangement::Distance> distances;
  for (const auto& [name, ends] : value.entries) {
    Arrangement::Distance d;
    d.where = ends.where;
    d.semantic = ontology.require(name, ends.where).id;
    constexpr Range kMetres{0, 1000};
    if (ends.kind == Value::Kind::Sequence) {
      const std::vector<double> both = readNumbers(ends, "distance_from", kMetres);
      if (both.size() != 2 || both[0] > both[1]) {
        throw InputError(ends.where, "a distance must be [least, most] in m, or only the least");
      }
      d.least = both[0];
      d.most = both[1];
    } else {
      d.least = readNumber(ends, "distance_from", kMetres);
      d.most = std::numeric_limits<double>::infinity();
    }
    distances.push_back(d);
  }
  return distances;
}

Arrangement::Scatter readScatter(const Value& value, const Ontology& ontology) {
  Fields f(value, "scatter");
  f.also({"on", "count", "density", "spacing", "slope_deg", "within", "covered", "distance_from"}).finish();
  Arrangement::Scatter s;
  s.where = value.where;
  s.classes = readClasses(f, "on", ontology);
  if (f.has("count") == f.has("density")) {
    throw InputError(value.where, "scatter needs either `count` or `density` (copies per square metre)");
  }
  const auto most = static_cast<std::int64_t>(Placement::mostCopies());
  if (f.has("count")) s.count = static_cast<std::uint64_t>(f.integer("count", 1, most));
  s.density = f.number("density", {1e-9, 1e4}, 0);
  if (f.has("spacing")) s.spacing = f.number("spacing", {1e-3, 1e5});
  s.slope = radians(f.number("slope_deg", {0, 90}, 90));
  s.covered = f.boolean("covered", false);
  if (const Value* from = f.find("distance_from")) s.distances = readDistances(*from, ontology);
  if (const Value* within = f.find("within")) s.within = readRectangle(*within, "within");
  return s;
}

Arrangement::Along readAlong(const Value& value) {
  Fields f(value, "along");
  f.also({"waypoints", "from", "to", "on", "keep", "every", "left"}).finish();
  if (f.has("to") == f.has("waypoints")) {
    throw InputError(value.where, "along needs either waypoints or, for a path on a road, from, to and on");
  }
  Arrangement::Along along{{}, {}, f.number("every", {1e-3, 1e6}), f.number("left", {-1e5, 1e5}, 0), value.where};
  if (f.has("to")) along.trip = readRoadTrip(f);
  if (f.has("waypoints")) along.waypoints = readWaypoints(f.require("waypoints"));
  return along;
}

// Returns the distances from the surfaces of each class that `s` names, in its order.
std::vector<SurfaceDistance> distancesIn(const Scene& scene, const Arrangement::Scatter& s) {
  std::vector<SurfaceDistance> from;
  for (const Arrangement::Distance& d : s.distances) {
    from.emplace_back(scene, std::vector{d.semantic}, std::isfinite(d.most) ? d.most : d.least);
    if (!from.back().empty()) continue;
    const std::string none = fmt::format("no earlier object of the list has triangles of the class {}",
                                         scene.ontology.find(d.semantic)->name);
    if (std::isfinite(d.most)) throw InputError(d.where, none + ", to which these copies must be near");
    warn(fmt::format("{}: {}, from which these copies must keep a distance: list the objects of this class first",
                     d.where.text(), none));
  }
  return from;
}

// Returns the point of a surface that may get copies at x and y of `p`: the highest such surface or, without `within`,
// the one at the height of `p`. Nothing if there is none, or if another surface covers it.
std::optional<Vec3d> onSurface(const Arrangement::Scatter& s, const SurfaceHeights& heights, const Vec3d& p) {
  const std::vector<SurfaceHeights::Surface> surfaces = heights.at(p.x, p.y);
  for (const SurfaceHeights::Surface& surface : surfaces) {
    if (!s.covered && surface.height < surfaces.front().height - kOverhead) break;
    const bool fits = std::ranges::find(s.classes, surface.semantic) != s.classes.end() && surface.slope <= s.slope &&
                      (s.within || std::fabs(surface.height - p.z) < kSame);
    if (fits) return Vec3d{p.x, p.y, surface.height};
  }
  return std::nullopt;
}

// Turns, scales and moves copies at random, and leaves out those that are not present.
std::vector<Arrangement::Copy> varied(const Arrangement::Vary& vary, const std::vector<Arrangement::Copy>& copies,
                                      std::uint64_t seed, std::uint32_t object) {
  std::vector<Arrangement::Copy> present;
  for (std::uint64_t n = 0; n < copies.size(); ++n) {
    const RandomBlock b = draw(seed, object, n, Draw::Pose);
    if (uniform(b[0]) >= vary.presence) continue;
    const double yaw = vary.yaw.low + (vary.yaw.high - vary.yaw.low) * uniform(b[1]);
    const double scale = vary.scale.low + (vary.scale.high - vary.scale.low) * uniform(b[2]);
    const double far = vary.position * std::sqrt(uniform(b[3]));
    const double around = 2 * kPi * uniform(draw(seed, object, n, Draw::Direction)[0]);
    Arrangement::Copy copy = copies[n];
    copy.worldFromMesh.translation += Vec3d{std::cos(around), std::sin(around), 0} * far;
    copy.worldFromMesh.linear =
        toMatrix(fromYawPitchRoll(yaw, 0, 0)) * copy.worldFromMesh.linear * Mat3::scale({scale, scale, scale});
    present.push_back(copy);
  }
  return present;
}

}  // namespace

Arrangement::Arrangement(Fields& object, const Ontology& ontology) {
  if (const Value* copies = object.find("copies"); copies != nullptr && copies->kind == Value::Kind::Map) {
    const Value* const scatter = copies->find("scatter");
    const Value* const along = copies->find("along");
    if (scatter != nullptr) scatter_ = readScatter(*scatter, ontology);
    if (scatter_ && along != nullptr) {
      throw InputError(along->where, "copies must have either `scatter` or `along`, not both");
    }
    if (along != nullptr) along_ = readAlong(*along);
  }
  if (const Value* value = object.find("vary")) {
    Fields f(*value, "vary");
    f.also({"yaw_deg", "scale", "position", "presence", "material"}).finish();
    materials_ = f.texts("material");
    Vary v;
    const Range yaw = f.range("yaw_deg", {-360, 360}).value_or(Range{0, 0});
    v.yaw = {radians(yaw.low), radians(yaw.high)};
    v.scale = f.range("scale", {1e-3, 1e3}).value_or(Range{1, 1});
    v.position = f.number("position", {0, 1e5}, 0);
    v.presence = f.number("presence", {0, 1}, 1);
    if (v.position > 0 && scatter_ && !object.has("stand_on")) {
      throw InputError(f.require("position").where,
                       "position would move scattered copies off their surface: leave it out, or add stand_on");
    }
    vary_ = v;
  }
  if (const Value* value = object.find("stand_on")) {
    StandOn s;
    s.where = value->where;
    const bool ground = value->kind == Value::Kind::Scalar && value->text == "ground" && !value->quoted;
    if (!ground) s.classes = readClasses(object, "stand_on", ontology);
    standOn_ = std::move(s);
  }
}

std::vector<Pose> Arrangement::scattered(const Scene& scene, const SurfaceHeights& heights, std::uint64_t seed,
                                         std::uint32_t object) const {
  const Scatter& s = *scatter_;
  const SurfaceHeights::Area area = heights.area(s.classes);
  if (area.squareMetres() <= 0) {
    throw InputError(s.where,
                     "no surface to scatter on: no earlier object of the list has triangles of these classes that face "
                     "up (`scanmill info` of the scene lists its classes), and later objects are placed afterwards");
  }
  const auto [left, front, right, back] = s.within.value_or(std::array<double, 4>{});
  const double squareMetres = s.within ? (right - left) * (back - front) : area.squareMetres();
  const double wanted = s.count ? static_cast<double>(*s.count) : s.density * squareMetres;
  refuseTooMany(wanted, s.where);
  const auto most = static_cast<std::uint64_t>(std::llround(wanted));
  if (most == 0) {
    throw InputError(s.where, fmt::format("gives {:.2g} copies on {:.4g} square metres: give a higher density, or a "
                                          "count",
                                          wanted, squareMetres));
  }
  const std::vector<SurfaceDistance> distances = distancesIn(scene, s);
  const auto keepsDistances = [&](const Vec3d& p) {
    for (std::size_t i = 0; i < distances.size(); ++i) {
      const double distance = distances[i].at(p.x, p.y);
      if (distance < s.distances[i].least || distance > s.distances[i].most) return false;
    }
    return true;
  };
  // A density gives each copy one try, and leaves out a copy whose place is not free. A count gives kTries tries per
  // copy (kMisses with `distance_from`); after kMisses misses in a row the search ends.
  const std::uint64_t tries = s.count ? (s.distances.empty() ? kTries : kMisses) * most : most;
  std::uint64_t misses = 0;
  std::vector<Pose> poses;
  Spaced spaced(s.spacing);
  for (std::uint64_t n = 0; n < tries && poses.size() < most && (!s.count || misses < kMisses); ++n) {
    const RandomBlock b = draw(seed, object, n, Draw::Place);
    const std::array<double, 3> u{uniform(b[0]), uniform(b[1]), uniform(b[2])};
    const Vec3d random =
        s.within ? Vec3d{left + (right - left) * u[0], front + (back - front) * u[1], 0} : area.place(u);
    const std::optional<Vec3d> p = onSurface(s, heights, random);
    ++misses;
    if (!p || !keepsDistances(*p) || !spaced.take(*p)) continue;
    misses = 0;
    poses.push_back({fromYawPitchRoll(2 * kPi * uniform(b[3]), 0, 0), *p});
  }
  if (s.count && poses.size() < most) {
    throw InputError(s.where, fmt::format("only {} of {} copies fit with the seed {}: give a smaller count or spacing, "
                                          "wider distances, or more classes or a larger area to scatter on",
                                          poses.size(), most, seed));
  }
  return poses;
}

std::vector<Pose> Arrangement::alongPath(const Scene& scene, const SurfaceHeights* heights) const {
  const Path path(along_->trip ? findRoadPath(*heights, scene.ontology, *along_->trip) : along_->waypoints);
  std::vector<Pose> places;
  const double count = std::floor(path.length() / along_->every * (1 + 1e-12)) + 1;
  refuseTooMany(count, along_->where);
  for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(count); ++i) {
    const Pose on = path.pose(static_cast<double>(i) * along_->every);
    const Quat level = fromYawPitchRoll(headingOf(on.rotation), 0, 0);
    places.push_back({level, on.translation + toMatrix(level).y * along_->left});
  }
  return places;
}

std::vector<Arrangement::Copy> Arrangement::places(const Placement& placement, const Scene& scene,
                                                   const SurfaceHeights* heights, std::uint64_t seed,
                                                   std::uint32_t object, std::size_t variants,
                                                   const std::function<double(const Copy&)>& lowest) const {
  std::vector<Pose> outer{Pose{}};
  if (scatter_) outer = scattered(scene, *heights, seed, object);
  if (along_) outer = alongPath(scene, heights);
  if (outer.size() * placement.count() > Placement::mostCopies()) {
    const Location where = scatter_ ? scatter_->where : along_ ? along_->where : Location{};
    throw InputError(where, fmt::format("{} places with {} copies each are too many: {}", outer.size(),
                                        placement.count(), Placement::mostCopiesText()));
  }
  std::vector<Copy> copies;
  for (const Pose& place : outer) {
    placement.forEach([&](const Affine& copy) {
      const double u = variants > 1 ? uniform(draw(seed, object, copies.size(), Draw::Variant)[0]) : 0;
      const auto chosen = static_cast<std::size_t>(u * static_cast<double>(variants));
      copies.push_back({toAffine(place) * copy, std::min(chosen, variants - 1), copies.size() + 1});
    });
  }
  if (vary_) copies = varied(*vary_, copies, seed, object);
  return standOn_ ? standing(std::move(copies), *heights, seed, lowest) : copies;
}

std::vector<Arrangement::Copy> Arrangement::standing(std::vector<Copy> copies, const SurfaceHeights& heights,
                                                     std::uint64_t seed,
                                                     const std::function<double(const Copy&)>& lowest) const {
  const std::vector<std::uint16_t>& classes = standOn_->classes;
  const auto carries = [&](const SurfaceHeights::Surface& surface) {
    return classes.empty() ? !surface.thing : std::ranges::find(classes, surface.semantic) != classes.end();
  };
  std::vector<Copy> standing;
  std::optional<Vec3d> first;  // position of the first copy that has no surface to stand on
  for (Copy& copy : copies) {
    Vec3d& position = copy.worldFromMesh.translation;
    const auto ground = heights.under(position, carries);
    if (!ground) {
      if (!first) first = position;
      continue;
    }
    position.z += ground->height - lowest(copy);
    standing.push_back(copy);
  }
  if (!first) return standing;
  const std::string why = fmt::format(
      "no surface to stand on at [{:.6g}, {:.6g}]: earlier objects of the list have no surface there {}that is less "
      "than 60 degrees steep (later objects are placed afterwards)",
      first->x, first->y, classes.empty() ? "" : "of these classes ");
  if (standing.empty()) throw InputError(standOn_->where, why);
  warn(fmt::format("{}: left out {} of {} copies with the seed {}: {}", standOn_->where.text(),
                   copies.size() - standing.size(), copies.size(), seed, why));
  return standing;
}

}  // namespace scanmill
