// Places houses, and the hedges and fences around their plots.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "town/placer.h"

namespace scanmill::town {
namespace {

using models::Fencing;
using models::Kind;
using models::Shape;

constexpr double kPanel = 2;        // m, length of a boundary's panel before it is scaled
constexpr double kSunk = 0.05;      // m that panels reach below the ground
constexpr double kPlinthDepth = 3;  // m, depth to which plinths extend below the door, to close gaps on slopes

Model makePlinth(SceneBuilder& builder, const models::House& house) {
  Shape s(builder, "plinth");
  s.box(s.surface("building", "concrete"), {house.width / 2, house.depth / 2, -kPlinthDepth / 2},
        {house.width - 0.04, house.depth - 0.04, kPlinthDepth});
  return s.finish();
}

class Boundaries {
 public:
  explicit Boundaries(Placer& placer) : placer_(placer) {}

  // Places a row of panels from a to b, unless it is too short.
  void row(Fencing what, int form, const Point2& a, const Point2& b) {
    constexpr double kShortest = 0.3;  // m
    if (distance(a, b) < kShortest) return;
    // The ground is marked as occupied only after the row is complete, because the panels of a row touch each other.
    for (const Footprint& f : panels(what, form, a, b)) placer_.occupancy.add(f);
  }

  // Places the barriers of a map. The ground is marked as occupied only after the last barrier, because panels overlap
  // at the corners of a barrier and where barriers meet.
  void barriers(const std::vector<MapBarrier>& all) {
    std::vector<Footprint> taken;
    std::array<models::Occupancy, kKinds> built;
    for (const MapBarrier& barrier : all) {
      models::Occupancy& same = built[static_cast<std::size_t>(barrier.kind)];
      const std::size_t first = taken.size();
      for (std::size_t i = 1; i < barrier.line.size(); ++i) {
        const std::vector<Footprint> row =
            panels(barrier.kind, 0, barrier.line[i - 1], barrier.line[i], barrier.height, &same);
        taken.insert(taken.end(), row.begin(), row.end());
      }
      for (std::size_t k = first; k < taken.size(); ++k) same.add(taken[k]);
    }
    for (const Footprint& f : taken) placer_.occupancy.add(f);
    // The text is the same for all places on the map, so that there is one warning.
    if (!lost_) return;
    warn(
        fmt::format("{}: left out: pieces of walls, fences and hedges where the town has roads, paths, houses or trees",
                    placer_.layout.parameters.map.string()));
  }

  // Returns half of a panel's thickness (m).
  double halfThickness(Fencing what, int form) {
    const Model& m = panel(what, form);
    return (m.bounds.high.y - m.bounds.low.y) / 2;
  }

 private:
  // Places panels from a to b, each at the height of the ground at its middle, and returns their rectangles. Panels
  // that would be on an object, a path or a road are left out, and panels whose middle is in one of the rectangles of
  // `same`, such as those of the fence that two gardens share. `height` (m) replaces the height of the panel's model.
  std::vector<Footprint> panels(Fencing what, int form, const Point2& a, const Point2& b,
                                std::optional<double> height = {}, const models::Occupancy* same = nullptr) {
    const double length = distance(a, b);
    const int count = std::max(1, static_cast<int>(std::lround(length / kPanel)));
    const double yaw = std::atan2(b.y - a.y, b.x - a.x);
    const Model& m = panel(what, form);
    const double half = (m.bounds.high.y - m.bounds.low.y) / 2;
    const double up = height ? (*height + kSunk) / m.bounds.high.z : 1;
    std::vector<Footprint> taken;
    for (int k = 0; k < count; ++k) {
      const Point2 p = models::lerp(a, b, (k + 0.5) / count);
      const double width = length / count;
      const Footprint covered{p, std::max(0.0, width / 2 - 0.1), half, yaw};
      if (same != nullptr && !same->isFree({p, 0, 0, 0})) continue;
      const Beside beside = placer_.layout.besideAt(p);
      const bool onRoad = beside.nearRoad && beside.edge < beside.section.outer() + 0.05;
      if (onRoad || !placer_.isFree(covered) || placer_.layout.areas.outsideHard(p) < half) {
        lost_ |= placer_.isOnGround(p);
        continue;
      }
      Affine place = models::at(placer_.layout.onGround(p, -kSunk), yaw);
      place.linear = place.linear * Mat3::scale({width / kPanel, 1, up});
      placer_.builder.place(m.mesh, placer_.worldFromTown * place, fmt::format("boundary {}", ++number_));
      taken.push_back(covered);
    }
    return taken;
  }

  const Model& panel(Fencing what, int form) {
    return placer_.model(Kind::Boundary, static_cast<int>(what) * kForms + form, [&] {
      return what == Fencing::Hedge ? models::makeHedgerow(placer_.builder, placer_.layout.seed, form)
                                    : models::makeFencePanel(placer_.builder, placer_.layout.seed, what, form);
    });
  }

  static constexpr int kForms = 4;
  static constexpr std::size_t kKinds = static_cast<std::size_t>(Fencing::Count);
  Placer& placer_;
  int number_ = 0;
  bool lost_ = false;  // true: a panel on the town's ground was left out
};

}  // namespace

void placeHouses(Placer& placer) {
  const std::size_t before = placer.builder.soFar().instances.size();
  const auto put = [&](const Model& m, const Affine& place, const std::string& name, std::int64_t relation) {
    const std::string thing = relation == 0 ? "" : fmt::format("relation {} after {} instances", relation, before);
    placer.builder.place(m.mesh, place, name, {}, nullptr, nullptr, thing);
  };
  int number = 0;
  for (const models::House& house : placer.layout.houses) {
    const Affine place = placer.worldFromTown * house.pose;
    const std::string name = fmt::format("house {}", ++number);
    put(models::makeHouse(placer.builder, placer.layout.seed, house), place, name, house.relation);
    put(makePlinth(placer.builder, house), place, name + " plinth", house.relation);
  }
  for (const PlacedBlock& b : placer.layout.blocks) {
    const Affine place = placer.worldFromTown * models::at({b.about.center.x, b.about.center.y, b.height});
    put(models::makeBlock(placer.builder, placer.layout.seed, b.block), place,
        fmt::format("block {}", b.block.number + 1), b.block.relation);
  }
}

void placeBoundaries(Placer& placer) {
  const Layout& l = placer.layout;
  Boundaries boundaries(placer);
  boundaries.barriers(l.barriers);
  for (const Plot& plot : l.plots) {
    Draw draw(l.seed, Kind::PlotBoundary, plot.number);
    const Road& road = l.roads()[plot.road];
    const int form = draw.below(4);
    const auto at = [&](double along, double depth) {
      return besideRoad(road, along, plot.side * (road.section.half + road.section.fenced() + depth)).at;
    };
    // Fences, walls and hedges stand at the edge of the sidewalk, with their whole thickness beyond it.
    const double thick = plot.fencing == Fencing::None ? 0 : boundaries.halfThickness(plot.fencing, form);
    const double front = thick + 0.06 + draw.in(0, 0.1);
    if (plot.fencing != Fencing::None) boundaries.row(plot.fencing, form, at(plot.from, front), at(plot.to, front));
    if (plot.bare) continue;
    const bool hedged = draw.chance(0.1 * l.character.hedges);
    if (!hedged && !draw.chance(0.04 * l.character.fences)) continue;
    const Fencing between = hedged                                                            ? Fencing::Hedge
                            : plot.fencing == Fencing::None || plot.fencing == Fencing::Hedge ? Fencing::Pickets
                                                                                              : plot.fencing;
    boundaries.row(between, form, at(plot.to - 0.4, front + 1), at(plot.to - 0.4, draw.in(14, 28)));
    if (draw.chance(0.6)) {
      const double back = draw.in(22, 30);
      boundaries.row(between, form, at(plot.from, back), at(plot.to, back));
    }
  }
}

}  // namespace scanmill::town
