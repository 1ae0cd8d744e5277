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

constexpr int kPanelForms = 4;      // number of forms of each kind of panel
constexpr double kPanel = 2;        // m, length of a boundary's panel before it is scaled
constexpr double kSunk = 0.05;      // m, depth of panels below the ground
constexpr double kPlinthDepth = 3;  // m, depth to which plinths extend below the door, to close gaps on slopes

// Places rows of fence panels, walls and hedges.
class Boundaries {
 public:
  explicit Boundaries(Placer& placer) : placer_(placer) {}

  // Places a row of panels from `a` to `b`, unless the points are less than kShortest apart.
  void placeRow(Fencing kind, int form, const Point2& a, const Point2& b) {
    constexpr double kShortest = 0.3;  // m
    if (distance(a, b) < kShortest) return;
    // The ground is marked as occupied only after the row is complete, because the panels of a row touch each other.
    for (const Footprint& f : placePanels(kind, form, a, b)) placer_.occupancy.add(f);
  }

  // Places the barriers of a map. Marks their ground as occupied only at the end, because panels overlap at corners.
  void placeBarriers(const std::vector<MapBarrier>& barriers) {
    std::vector<Footprint> panels;
    std::array<models::Occupancy, kKinds> panelsOfKind;
    for (const MapBarrier& barrier : barriers) {
      models::Occupancy& sameKind = panelsOfKind[static_cast<std::size_t>(barrier.kind)];
      const std::size_t first = panels.size();
      for (std::size_t i = 1; i < barrier.line.size(); ++i) {
        const std::vector<Footprint> row =
            placePanels(barrier.kind, 0, barrier.line[i - 1], barrier.line[i], barrier.height, &sameKind);
        panels.insert(panels.end(), row.begin(), row.end());
      }
      for (std::size_t k = first; k < panels.size(); ++k) sameKind.add(panels[k]);
    }
    for (const Footprint& f : panels) placer_.occupancy.add(f);
    // The text is the same for all towns on the map, because warn() reports equal texts only once.
    if (!leftOut_) return;
    warn("{}: left out: pieces of walls, fences and hedges where the town has roads, paths, houses or trees",
         placer_.layout.parameters.map.string());
  }

  // Returns half of a panel's thickness (m).
  double halfThickness(Fencing kind, int form) { return panel(kind, form).width() / 2; }

 private:
  // Places panels from `a` to `b`, each at the ground's height at its middle, and returns their rectangles. Leaves out
  // panels on an object, a path or a road, and panels whose middle is in a rectangle of `sameKind`: on maps, the fence
  // between two gardens may occur twice. `height`: height of the panels (m); not set: the height of the model.
  std::vector<Footprint> placePanels(Fencing kind, int form, const Point2& a, const Point2& b,
                                     std::optional<double> height = {}, const models::Occupancy* sameKind = nullptr) {
    const double length = distance(a, b);
    const int count = std::max(1, static_cast<int>(std::lround(length / kPanel)));
    const double width = length / count;
    const double yaw = std::atan2(b.y - a.y, b.x - a.x);
    const Model& m = panel(kind, form);
    const double half = m.width() / 2;
    const double heightFactor = height ? (*height + kSunk) / m.bounds.high.z : 1;
    std::vector<Footprint> placed;
    for (int k = 0; k < count; ++k) {
      const Point2 p = models::lerp(a, b, (k + 0.5) / count);
      const Footprint covered{p, std::max(0.0, width / 2 - 0.1), half, yaw};
      if (sameKind != nullptr && !sameKind->isFree({p, 0, 0, 0})) continue;
      if (placer_.layout.besideAt(p).isOnRoadOrSidewalk(0.05) || !placer_.isFree(covered) ||
          placer_.layout.areas.outsideHard(p) < half) {
        leftOut_ |= placer_.isOnGround(p);
        continue;
      }
      // Panels have settled: they stand a little beside the line, turned and leaning.
      constexpr double kAside = 0.04, kAngle = 0.026;  // m, rad
      Draw draw(placer_.layout.seed, Kind::Panel, number_);
      const Point2 aside = Footprint{p, 0, 0, yaw}.at(0, draw.in(-kAside, kAside));
      Affine pose{toMatrix(fromYawPitchRoll(yaw + draw.in(-kAngle, kAngle), 0, draw.in(-kAngle, kAngle))),
                  placer_.layout.onGround(aside, -kSunk)};
      pose.linear = pose.linear * Mat3::scale({width / kPanel, 1, heightFactor});
      placer_.builder.place(m.mesh, placer_.worldFromTown * pose, fmt::format("boundary {}", ++number_));
      placed.push_back(covered);
    }
    return placed;
  }

  const Model& panel(Fencing kind, int form) {
    return placer_.model(Kind::Boundary, static_cast<int>(kind) * kPanelForms + form, [&] {
      return kind == Fencing::Hedge ? models::makeHedgerow(placer_.builder, placer_.layout.seed, form)
                                    : models::makeFencePanel(placer_.builder, placer_.layout.seed, kind, form);
    });
  }

  static constexpr std::size_t kKinds = static_cast<std::size_t>(Fencing::Count);
  Placer& placer_;
  int number_ = 0;
  bool leftOut_ = false;  // true: a panel on the town's ground was left out
};

}  // namespace

// Places houses with plinths, and blocks. All buildings of one relation of the map become one object instance.
void placeHouses(Placer& placer) {
  constexpr double kPlinthInset = 0.02;  // m by which a plinth is behind each wall
  const std::size_t instancesBefore = placer.builder.soFar().instances.size();
  const auto put = [&](const Model& m, const Affine& pose, const std::string& name, std::int64_t relation) {
    // The number of instances keeps the towns of a scene apart, which may contain the same relation.
    const std::string objectKey =
        relation == 0 ? "" : fmt::format("relation {} after {} instances", relation, instancesBefore);
    placer.builder.place(m.mesh, pose, name, {}, nullptr, nullptr, objectKey);
  };
  int number = 0;
  for (const models::House& house : placer.layout.houses) {
    const Affine pose = placer.worldFromTown * house.pose;
    const std::string name = fmt::format("house {}", ++number);
    put(models::makeHouse(placer.builder, placer.layout.seed, house), pose, name, house.relation);
    Shape plinth(placer.builder, "plinth");
    plinth.box(plinth.surface("building", "concrete"), {house.width / 2, house.depth / 2, -kPlinthDepth / 2},
               {house.width - 2 * kPlinthInset, house.depth - 2 * kPlinthInset, kPlinthDepth});
    put(plinth.finish(), pose, name + " plinth", house.relation);
  }
  for (const PlacedBlock& b : placer.layout.blocks) {
    const Affine pose = placer.worldFromTown * models::at({b.about.center.x, b.about.center.y, b.height});
    put(models::makeBlock(placer.builder, placer.layout.seed, b.block), pose,
        fmt::format("block {}", b.block.number + 1), b.block.relation);
  }
}

// Places the barriers of the map, then, by plot, fences, walls and hedges along the road and around some gardens.
void placeBoundaries(Placer& placer) {
  const Layout& l = placer.layout;
  Boundaries boundaries(placer);
  boundaries.placeBarriers(l.barriers);
  for (const Plot& plot : l.plots) {
    Draw draw(l.seed, Kind::PlotBoundary, plot.number);
    const Road& road = l.roads()[plot.road];
    const int form = draw.below(kPanelForms);
    const bool fenced = plot.fencing != Fencing::None;
    const auto point = [&](double along, double depth) {
      return besideRoad(road, along, plot.side * (road.section.half + road.section.fenced() + depth)).at;
    };
    // Fences, walls and hedges are placed just beyond the sidewalk or a narrow apron: see CrossSection::fenced().
    const double front = (fenced ? boundaries.halfThickness(plot.fencing, form) : 0) + 0.06 + draw.in(0, 0.1);
    if (fenced) boundaries.placeRow(plot.fencing, form, point(plot.from, front), point(plot.to, front));
    if (plot.bare) continue;
    const bool hedged = draw.chance(0.1 * l.character.hedges);
    if (!hedged && !draw.chance(0.04 * l.character.fences)) continue;
    const Fencing between = hedged                                      ? Fencing::Hedge
                            : !fenced || plot.fencing == Fencing::Hedge ? Fencing::Pickets
                                                                        : plot.fencing;
    boundaries.placeRow(between, form, point(plot.to - 0.4, front + 1), point(plot.to - 0.4, draw.in(14, 28)));
    if (draw.chance(0.6)) {
      const double rear = draw.in(22, 30);
      boundaries.placeRow(between, form, point(plot.from, rear), point(plot.to, rear));
    }
  }
}

}  // namespace scanmill::town
