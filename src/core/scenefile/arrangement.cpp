#include "scenefile/arrangement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "base/error.h"
#include "base/path.h"
#include "base/random.h"
#include "config/waypoints.h"
#include "scene/surface_distance.h"

namespace scanmill {
namespace {

constexpr std::uint64_t kTries = 30;       // tries per copy, if `count` is given without `distance_from`
constexpr std::uint64_t kMisses = 30'000;  // rejected places in a row after which the search for a `count` ends
constexpr double kOverhead = 0.05;         // m; a surface is covered if another surface lies more than this above it
constexpr double kSame = 1e-3;             // m; surfaces whose heights differ by less are the same surface

// Returns the random numbers of an object's n-th try or n-th copy; each purpose has its own value of `what`.
RandomBlock draw(std::uint64_t seed, std::uint32_t object, std::uint64_t n, std::uint32_t what) {
  return randomBlock(
      {seed, object, static_cast<std::uint32_t>(n), what, static_cast<std::uint32_t>(n >> 32), 0, Purpose::Placement});
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

}  // namespace

Arrangement::Arrangement(Fields& object, const Ontology& ontology) {
  if (const Value* copies = object.find("copies"); copies != nullptr && copies->kind == Value::Kind::Map) {
    if (const Value* value = copies->find("scatter")) {
      Fields f(*value, "scatter");
      f.also({"on", "count", "density", "spacing", "slope_deg", "within", "covered", "distance_from"}).finish();
      Scatter s;
      s.where = value->where;
      s.classes = readClasses(f, "on", ontology);
      if (f.has("count") == f.has("density")) {
        throw InputError(value->where, "scatter needs either `count` or `density` (copies per square metre)");
      }
      if (f.has("count"))
        s.count = static_cast<std::uint64_t>(f.integer("count", 1, static_cast<std::int64_t>(Placement::mostCopies())));
      s.density = f.number("density", {1e-9, 1e4}, 0);
      if (f.has("spacing")) s.spacing = f.number("spacing", {1e-3, 1e5});
      s.slope = radians(f.number("slope_deg", {0, 90}, 90));
      s.covered = f.boolean("covered", false);
      if (const Value* from = f.find("distance_from")) s.distances = readDistances(*from, ontology);
      if (const Value* within = f.find("within")) s.within = readRectangle(*within, "within");
      scatter_ = std::move(s);
    }
    if (const Value* value = copies->find("along")) {
      if (scatter_) throw InputError(value->where, "copies must have either `scatter` or `along`, not both");
      Fields f(*value, "along");
      f.also({"waypoints", "from", "to", "on", "keep", "every", "left"}).finish();
      if (f.has("to") == f.has("waypoints")) {
        throw InputError(value->where, "along needs either waypoints or, for a path on a road, from, to and on");
      }
      along_ = Along{{}, {}, f.number("every", {1e-3, 1e6}), f.number("left", {-1e5, 1e5}, 0), value->where};
      if (f.has("to")) along_->trip = readRoadTrip(f);
      if (f.has("waypoints")) along_->waypoints = readWaypoints(f.require("waypoints"));
    }
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

std::vector<Arrangement::Distance> Arrangement::readDistances(const Value& value, const Ontology& ontology) {
  if (value.kind != Value::Kind::Map || value.entries.empty()) {
    throw InputError(value.where, "distance_from must be {class: [least, most]} in m, or {class: least}");
  }
  std::vector<Distance> distances;
  for (const auto& [name, ends] : value.entries) {
    Distance d;
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

std::vector<Pose> Arrangement::scattered(const Scene& scene, const SurfaceHeights& heights, std::uint64_t seed,
                                         std::uint32_t object) const {
  const Scatter& s = *scatter_;
  const SurfaceHeights::Area area = heights.area(s.classes);
  if (area.squareMetres() <= 0) {
    throw InputError(s.where,
                     "no surface to scatter on: no earlier object of the list has triangles of these classes that face "
                     "up (`scanmill info` of the scene lists its classes), and later objects are placed afterwards");
  }
  const bool bounded = s.within.has_value();
  const auto [left, front, right, back] = s.within.value_or(std::array<double, 4>{});
  const double own = bounded ? (right - left) * (back - front) : area.squareMetres();
  const double wanted = s.count ? static_cast<double>(*s.count) : s.density * own;
  refuseTooMany(wanted, s.where);
  std::vector<Pose> places;
  Spaced spaced(s.spacing);
  const auto most = static_cast<std::uint64_t>(std::llround(wanted));
  if (most == 0) {
    throw InputError(
        s.where,
        fmt::format("gives {:.2g} copies on {:.4g} square metres: give a higher density, or a count", wanted, own));
  }
  std::vector<SurfaceDistance> from;
  for (const Distance& d : s.distances) {
    from.emplace_back(scene, std::vector{d.semantic}, std::isfinite(d.most) ? d.most : d.least);
    if (!from.back().empty()) continue;
    const std::string none = fmt::format("no earlier object of the list has triangles of the class {}",
                                         scene.ontology.find(d.semantic)->name);
    if (std::isfinite(d.most)) throw InputError(d.where, none + ", to which these copies must be near");
    warn(fmt::format("{}: {}, from which these copies must keep a distance: list the objects of this class first",
                     d.where.text(), none));
  }
  const auto keepsDistances = [&](const Vec3d& p) {
    for (std::size_t i = 0; i < from.size(); ++i) {
      const double distance = from[i].at(p.x, p.y);
      if (distance < s.distances[i].least || distance > s.distances[i].most) return false;
    }
    return true;
  };
  std::uint64_t misses = 0;
  // A density gives each copy one try, and leaves out a copy whose place is not free. A count gives kTries tries per
  // copy (kMisses with `distance_from`); after kMisses misses in a row the search ends.
  const std::uint64_t tries = s.count ? (s.distances.empty() ? kTries : kMisses) * most : most;
  for (std::uint64_t n = 0; n < tries && places.size() < most && (!s.count || misses < kMisses); ++n) {
    const RandomBlock b = draw(seed, object, n, 0);
    Vec3d p;
    if (bounded) {
      p = {left + (right - left) * uniform(b[0]), front + (back - front) * uniform(b[1]), 0};
    } else {
      p = area.place({uniform(b[0]), uniform(b[1]), uniform(b[2])});
    }
    bool free = false;
    const std::vector<SurfaceHeights::Surface> surfaces = heights.at(p.x, p.y);
    for (const SurfaceHeights::Surface& surface : surfaces) {
      if (!s.covered && surface.height < surfaces.front().height - kOverhead) break;
      const bool holds = std::find(s.classes.begin(), s.classes.end(), surface.semantic) != s.classes.end() &&
                         surface.slope <= s.slope && (bounded || std::fabs(surface.height - p.z) < kSame);
      if (holds) {
        p.z = surface.height;
        free = true;
        break;
      }
    }
    ++misses;
    if (!free || !keepsDistances(p) || !spaced.take(p)) continue;
    misses = 0;
    places.push_back({fromYawPitchRoll(2 * kPi * uniform(b[3]), 0, 0), p});
  }
  if (s.count && places.size() < most) {
    throw InputError(s.where, fmt::format("only {} of {} copies fit with the seed {}: give a smaller count or spacing, "
                                          "wider distances, or more classes or a larger area to scatter on",
                                          places.size(), most, seed));
  }
  return places;
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
    throw InputError(scatter_ ? scatter_->where
                     : along_ ? along_->where
                              : Location{},
                     fmt::format("{} places with {} copies each are too many: {}", outer.size(), placement.count(),
                                 Placement::mostCopiesText()));
  }
  std::vector<Copy> all;
  for (const Pose& place : outer) {
    placement.forEach([&](const Affine& copy) {
      const double u = variants > 1 ? uniform(draw(seed, object, all.size(), 3)[0]) : 0;
      const auto chosen = static_cast<std::size_t>(u * static_cast<double>(variants));
      all.push_back({toAffine(place) * copy, std::min(chosen, variants - 1), all.size() + 1});
    });
  }
  if (vary_) {
    std::vector<Copy> varied;
    for (std::uint64_t n = 0; n < all.size(); ++n) {
      const RandomBlock b = draw(seed, object, n, 1);
      const RandomBlock c = draw(seed, object, n, 2);
      if (uniform(b[0]) >= vary_->presence) continue;
      const double yaw = vary_->yaw.low + (vary_->yaw.high - vary_->yaw.low) * uniform(b[1]);
      const double scale = vary_->scale.low + (vary_->scale.high - vary_->scale.low) * uniform(b[2]);
      const double far = vary_->position * std::sqrt(uniform(b[3]));
      const double around = 2 * kPi * uniform(c[0]);
      Affine copy = all[n].worldFromMesh;
      copy.translation += Vec3d{std::cos(around), std::sin(around), 0} * far;
      copy.linear = toMatrix(fromYawPitchRoll(yaw, 0, 0)) * copy.linear * Mat3::scale({scale, scale, scale});
      varied.push_back({copy, all[n].variant, all[n].number});
    }
    all = std::move(varied);
  }
  if (!standOn_) return all;
  std::vector<Copy> standing;
  std::optional<Vec3d> lost;  // position of the first copy that has no surface to stand on
  for (Copy& own : all) {
    Affine& copy = own.worldFromMesh;
    const auto ground = heights->under(copy.translation, [&](const SurfaceHeights::Surface& s) {
      if (standOn_->classes.empty()) return !s.thing;
      return std::find(standOn_->classes.begin(), standOn_->classes.end(), s.semantic) != standOn_->classes.end();
    });
    if (!ground) {
      if (!lost) lost = copy.translation;
      continue;
    }
    copy.translation.z += ground->height - lowest(own);
    standing.push_back(own);
  }
  if (!lost) return standing;
  const std::string why = fmt::format(
      "no surface to stand on at [{:.6g}, {:.6g}]: earlier objects of the list have no surface there {}that is less "
      "than 60 degrees steep (later objects are placed afterwards)",
      lost->x, lost->y, standOn_->classes.empty() ? "" : "of these classes ");
  if (standing.empty()) throw InputError(standOn_->where, why);
  warn(fmt::format("{}: left out {} of {} copies with the seed {}: {}", standOn_->where.text(),
                   all.size() - standing.size(), all.size(), seed, why));
  return standing;
}

}  // namespace scanmill
