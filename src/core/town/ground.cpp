// Builds the ground of a town as one surface without gaps: triangles that are small near roads and are cut along the
// edges of road, curb, verge, sidewalk and patches, with a height at each corner, and vertical walls at the curbs.

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "town/layout.h"
#include "town/tiling.h"

namespace scanmill::town {
namespace {

using models::Shape;
using models::SurfaceIndex;

constexpr double kSmallest = 1;  // m, side of the smallest cells away from potholes

class GroundMaker {
 public:
  // Adds a surface for each kind of ground. The materials depend on the season and on random properties of the town.
  GroundMaker(SceneBuilder& builder, const Layout& layout) : layout_(layout), shape_(builder, "ground") {
    const bool paved = Draw(layout.seed, models::Kind::Terrain).chance(0.5);
    const bool dry = Draw(layout.seed, models::Kind::DrySoil).chance(0.2);
    const auto set = [&](GroundKind kind, const char* className, const char* material) {
      surfaces_[static_cast<std::size_t>(kind)] = shape_.surface(className, material);
    };
    set(GroundKind::Road, "road", layout.character.cobbled ? "paving" : "asphalt");
    set(GroundKind::Parking, "parking", paved ? "paving" : "asphalt");
    set(GroundKind::Curb, "curb", "concrete");
    const Season season = layout.character.season;
    const char* const lawn = season == Season::Winter ? "snow" : dry ? "grass_dry" : "grass";
    const char* const verge = season == Season::Winter ? "snow" : season == Season::Autumn ? "leaf_litter" : "grass";
    set(GroundKind::Verge, "terrain", verge);
    set(GroundKind::Shoulder, "terrain", dry && season != Season::Winter ? "soil" : verge);
    set(GroundKind::Sidewalk, "sidewalk",
        Draw(layout.seed, models::Kind::Sidewalk).chance(0.7) ? "concrete" : "paving");
    set(GroundKind::Driveway, "driveway", "paving");
    set(GroundKind::Path, "driveway", "concrete");
    set(GroundKind::Lawn, "terrain", lawn);
    if (!layout.areas.list().empty() || layout.character.terraced) set(GroundKind::Paved, "sidewalk", "paving");
    if (layout.areas.list().empty()) return;
    set(GroundKind::Water, "water", "water");
    set(GroundKind::Lot, "parking", paved ? "paving" : "asphalt");
  }

  // Returns the model of the ground: makes the tiling, cuts it along the roads' five borders and the edges of patches,
  // water, parking lots and squares, and adds its triangles.
  models::Model make() {
    tile();
    for (const Road& road : layout_.roads()) sections_.push_back(road.section);
    besides_.reserve(tiling_.points.size() + tiling_.points.size() / 4);
    for (std::size_t border = 0; border < 5; ++border) {
      cut([&](std::uint32_t p) {
        makeBesides(p);
        const auto& [edge, section] = besides_[p];
        return section == kUnknown ? 1e3 : Layout::borders(edge, sections_[section])[border];
      });
    }
    cut([&](std::uint32_t p) { return layout_.outsidePatches(tiling_.points[p]); });
    if (!layout_.areas.list().empty()) {
      cut([&](std::uint32_t p) { return layout_.areas.outsideHard(tiling_.points[p]); });
    }
    addTriangles();
    return shape_.finish();
  }

 private:
  // Makes the tiling. Cells are kSmallest / 8 wide at potholes, kSmallest near roads and sharp edges, else up to 8 m.
  void tile() {
    tiling_ = makeTiling(layout_.halfSide, kSmallest / 8, [&](double x, double y, double size) {
      const double radius = 0.71 * size;  // m, half of the cell's diagonal, rounded up
      if (size > kSmallest / 8 && layout_.nearPothole({x, y}, radius)) return true;
      if (size <= kSmallest * 1.0001) return false;
      // Areas and patches have sharp edges. Distances from patches are known only up to kPatchReach (4 m).
      const double reach = std::min(radius, 3.9);
      if (std::abs(layout_.areas.outsideHard({x, y})) < reach) return true;
      if (std::abs(layout_.outsidePatches({x, y})) < reach) return true;
      const Beside b = layout_.besideAt({x, y});
      // The distance from roads is known only up to kReach; beyond, kReach is assumed.
      const double toRoad = (b.nearRoad ? b.edge : RoadNetwork::kReach) - radius;
      const double largest = toRoad < 14 ? kSmallest : toRoad < 34 ? 2 * kSmallest : 8;
      return size > largest * 1.0001;
    });
  }

  // Divides triangles along the line on which a field is zero. field(p): value (m) at the tiling's point p.
  template <class Field>
  void cut(const Field& field) {
    std::vector<double> values(tiling_.points.size());
    for (std::uint32_t p = 0; p < values.size(); ++p) values[p] = field(p);
    cutAlong(tiling_, std::move(values));
  }

  // Fills besides_ up to the index `point`.
  void makeBesides(std::uint32_t point) {
    while (besides_.size() <= point) {
      const Point2& p = tiling_.points[besides_.size()];
      const Beside b = layout_.besideAt(p);
      besides_.push_back({b.edge, b.nearRoad ? numberOf(b) : kUnknown});
    }
  }

  // Returns the index of b.section in sections_: the road's number or, where the sections of roads blend, a new index.
  std::uint32_t numberOf(const Beside& b) {
    if (b.section == sections_[b.road]) return b.road;
    sections_.push_back(b.section);
    return static_cast<std::uint32_t>(sections_.size() - 1);
  }

  // Returns a point's Beside with only `nearRoad`, `edge` and `section` set; kindAt() and heightAt() need no more.
  Beside beside(std::uint32_t point) {
    makeBesides(point);
    const auto& [edge, section] = besides_[point];
    Beside b;
    b.nearRoad = section != kUnknown;
    if (b.nearRoad) b.section = sections_[section];
    b.edge = edge;
    return b;
  }

  static bool isLow(GroundKind kind) { return kind == GroundKind::Road || kind == GroundKind::Parking; }

  // Returns the kind of ground of a triangle: the kind at its centre, since no border crosses a triangle.
  GroundKind kindOf(const std::array<std::uint32_t, 3>& t) {
    Beside middle = beside(t[0]);
    Point2 p{0, 0};
    middle.edge = 0;
    for (const std::uint32_t v : t) {
      makeBesides(v);
      if (besides_[v].section == kUnknown) middle.nearRoad = false;
      middle.edge += besides_[v].edge / 3;
      p.x += tiling_.points[v].x / 3;
      p.y += tiling_.points[v].y / 3;
    }
    return layout_.kindAt(middle, p);
  }

  // Returns the index of a point's vertex; adds a missing vertex. Low kinds (road, parking) share one, others another.
  std::uint32_t vertex(std::uint32_t point, GroundKind kind) {
    std::uint32_t& indexPlusOne = (isLow(kind) ? low_ : high_)[point];
    if (indexPlusOne == 0) {
      const Point2& p = tiling_.points[point];
      const double z = layout_.heightAt(kind, beside(point), p);
      shape_.mesh.positions.push_back(Vec3f(Vec3d{p.x, p.y, z}));
      indexPlusOne = static_cast<std::uint32_t>(shape_.mesh.positions.size());
    }
    return indexPlusOne - 1;
  }

  // Adds the triangles of the tiling to the mesh, and the curbs' walls between low and high ground.
  void addTriangles() {
    shape_.mesh.positions.reserve(tiling_.points.size() + tiling_.points.size() / 8);
    shape_.mesh.triangles.reserve(tiling_.triangles.size() + tiling_.triangles.size() / 8);
    shape_.mesh.surfaceOf.reserve(tiling_.triangles.size() + tiling_.triangles.size() / 8);
    low_.assign(tiling_.points.size(), 0);
    high_.assign(tiling_.points.size(), 0);
    std::vector<bool> isLowTriangle;
    isLowTriangle.reserve(tiling_.triangles.size());
    for (const std::array<std::uint32_t, 3>& t : tiling_.triangles) {
      const GroundKind kind = kindOf(t);
      isLowTriangle.push_back(isLow(kind));
      add(surfaces_[static_cast<std::size_t>(kind)], vertex(t[0], kind), vertex(t[1], kind), vertex(t[2], kind));
    }
    addWalls(isLowTriangle);
  }

  // Adds a curb's wall at each edge between a low and a high triangle, which have the edge in opposite directions.
  void addWalls(const std::vector<bool>& isLowTriangle) {
    const SurfaceIndex curb = surfaces_[static_cast<std::size_t>(GroundKind::Curb)];
    const auto forEdgesAtBothHeights = [&](bool low, const auto& visit) {
      for (std::size_t i = 0; i < isLowTriangle.size(); ++i) {
        if (isLowTriangle[i] != low) continue;
        const std::array<std::uint32_t, 3>& t = tiling_.triangles[i];
        for (std::size_t k = 0; k < 3; ++k) {
          const std::uint32_t a = t[k];
          const std::uint32_t b = t[(k + 1) % 3];
          if (low_[a] > 0 && high_[a] > 0 && low_[b] > 0 && high_[b] > 0) visit(a, b);
        }
      }
    };
    std::unordered_set<std::uint64_t> highEdges;
    forEdgesAtBothHeights(false,
                          [&](std::uint32_t a, std::uint32_t b) { highEdges.insert(std::uint64_t{a} << 32 | b); });
    forEdgesAtBothHeights(true, [&](std::uint32_t a, std::uint32_t b) {
      if (!highEdges.contains(std::uint64_t{b} << 32 | a)) return;
      add(curb, low_[b] - 1, low_[a] - 1, high_[a] - 1);
      add(curb, low_[b] - 1, high_[a] - 1, high_[b] - 1);
    });
  }

  void add(SurfaceIndex surface, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    shape_.mesh.triangles.push_back({a, b, c});
    shape_.mesh.surfaceOf.push_back(surface);
  }

  const Layout& layout_;
  Shape shape_;
  std::array<SurfaceIndex, 12> surfaces_{};
  Tiling tiling_;
  // A point's Beside::edge (m) and the index of its section in sections_. A Beside would take five times the memory.
  struct EdgeAndSection {
    double edge;
    std::uint32_t section;
  };
  static constexpr std::uint32_t kUnknown = 0xFFFFFFFFu;
  std::vector<EdgeAndSection> besides_;
  std::vector<CrossSection> sections_;     // cross sections of the roads, then of crossings
  std::vector<std::uint32_t> low_, high_;  // for each point, the index of its vertex plus 1; 0: none yet
};

}  // namespace

models::Model makeGround(SceneBuilder& builder, const Layout& layout) {
  return GroundMaker(builder, layout).make();
}

}  // namespace scanmill::town
