// Builds the ground as one closed surface without gaps. Straight lines cut the ground into cells that share their
// corners; without T-junctions no ray can pass between cells. Each cell has a kind, and a height at each corner. Where
// the heights of two neighbours differ there is a vertical wall. The rounded corners of the crossing are patches that
// end on the same lines.

#include <algorithm>
#include <cmath>
#include <functional>

#include "town/street/layout.h"

namespace scanmill::street {
namespace {

constexpr double kCell = 4;        // m, longest side of a cell
constexpr double kNearest = 5e-3;  // m; a line at a smaller distance from the line before is left out
constexpr int kArcSteps = 12;

std::vector<double> cut(std::vector<double> wanted, double low, double high) {
  wanted.push_back(low);
  wanted.push_back(high);
  std::sort(wanted.begin(), wanted.end());
  std::vector<double> lines;
  for (const double w : wanted) {
    if (w < low || w > high || (!lines.empty() && w - lines.back() < kNearest)) continue;
    if (!lines.empty()) {
      const double from = lines.back();
      const int pieces = static_cast<int>(std::ceil((w - from) / kCell));
      for (int i = 1; i < pieces; ++i) lines.push_back(lerp(from, w, double(i) / pieces));
    }
    lines.push_back(w);
  }
  return lines;
}

class GroundMaker {
 public:
  GroundMaker(SceneBuilder& builder, const Layout& layout) : layout_(layout), shape_(builder, "ground") {
    const SurfaceIndex road = shape_.surface("road", "asphalt");
    const SurfaceIndex parking = shape_.surface("parking", "paving");
    const SurfaceIndex curb = shape_.surface("curb", "concrete");
    const SurfaceIndex sidewalk = shape_.surface("sidewalk", "paving");
    const SurfaceIndex path = shape_.surface("ground", "concrete");
    const SurfaceIndex terrain = shape_.surface("terrain", "grass");
    surfaces_ = {road, parking, curb, curb, sidewalk, sidewalk, parking, path, terrain};
    makeLines();
  }

  Model make() {
    addCells();
    addWalls();
    if (layout_.cross) {
      for (const int sx : {-1, 1}) {
        for (const int sy : {-1, 1}) addCorner(sx, sy);
      }
    }
    return shape_.finish();
  }

 private:
  SurfaceIndex surface(Ground kind) const { return surfaces_[static_cast<std::size_t>(kind)]; }

  void makeLines() {
    const Layout& l = layout_;
    std::vector<double> xs{-l.halfLength, l.halfLength};
    std::vector<double> half{l.roadEdge,
                             l.roadEdge + Layout::kCurb,
                             l.parkingEdge,
                             l.walkInner,
                             l.walkOuter,
                             l.walkInner + Layout::kRamp,
                             l.front + Layout::kDrivewayDepth,
                             l.front + Layout::kPathDepth};
    for (const Span& s : l.parking) {
      for (const double x : {s.low - Layout::kCurb, s.low, s.high, s.high + Layout::kCurb}) xs.push_back(x);
    }
    for (const Lot& lot : l.lots) {
      for (const double x : {lot.driveway.low, lot.driveway.high, lot.walkway.low, lot.walkway.high}) xs.push_back(x);
    }
    if (l.cross) {
      for (const double d : {l.crossEdge, l.crossEdge + Layout::kCurb, l.crossWalk, l.crossEdge + l.cornerRadius}) {
        xs.push_back(l.crossX - d);
        xs.push_back(l.crossX + d);
      }
      half.push_back(l.crossSidewalkEnd);
    }
    xs_ = cut(std::move(xs), -l.halfX, l.halfX);
    ys_ = cut(std::move(half), 0, l.halfY);
    std::vector<double> mirrored(ys_.size());
    std::transform(ys_.rbegin(), ys_.rend(), mirrored.begin(), std::negate<>());
    ys_.insert(ys_.begin(), mirrored.begin(), mirrored.end() - 1);
  }

  struct Cell {
    Ground kind = Ground::Terrain;
    bool patch = false;  // true: the cell is part of a rounded corner of the crossing
  };

  Cell cell(std::size_t i, std::size_t j) const {
    const double x = (xs_[i] + xs_[i + 1]) / 2;
    const double y = (ys_[j] + ys_[j + 1]) / 2;
    return {layout_.kindAt(x, y), layout_.inCorner(x, y)};
  }

  Vec3d corner(const Cell& c, std::size_t i, std::size_t j) const {
    // Rounds heights to micrometres, so that equal heights compare equal.
    return {xs_[i], ys_[j], std::round(layout_.heightAt(c.kind, xs_[i], ys_[j]) * 1e6) / 1e6};
  }

  void addCells() {
    cells_.resize((xs_.size() - 1) * (ys_.size() - 1));
    for (std::size_t j = 0; j + 1 < ys_.size(); ++j) {
      for (std::size_t i = 0; i + 1 < xs_.size(); ++i) {
        const Cell c = cell(i, j);
        cells_[j * (xs_.size() - 1) + i] = c;
        if (c.patch) continue;
        shape_.quad(surface(c.kind), corner(c, i, j), corner(c, i + 1, j), corner(c, i + 1, j + 1),
                    corner(c, i, j + 1));
      }
    }
  }

  // Adds the wall between two cells along the edge from corner 0 to corner 1.
  void addWall(const Cell& a, const Cell& b, std::size_t i0, std::size_t j0, std::size_t i1, std::size_t j1) {
    if (a.patch || b.patch) return;
    const Vec3d a0 = corner(a, i0, j0);
    const Vec3d a1 = corner(a, i1, j1);
    const Vec3d b0 = corner(b, i0, j0);
    const Vec3d b1 = corner(b, i1, j1);
    if (a0 == b0 && a1 == b1) return;
    const SurfaceIndex higher = surface(a0.z + a1.z > b0.z + b1.z ? a.kind : b.kind);
    if (a0 == b0) {
      shape_.triangle(higher, a0, a1, b1);
    } else if (a1 == b1) {
      shape_.triangle(higher, a0, a1, b0);
    } else {
      shape_.quad(higher, a0, a1, b1, b0);
    }
  }

  void addWalls() {
    const std::size_t columns = xs_.size() - 1;
    for (std::size_t j = 0; j + 1 < ys_.size(); ++j) {
      for (std::size_t i = 0; i < columns; ++i) {
        const Cell& c = cells_[j * columns + i];
        // A wall must face the lower cell. The order of corners makes it face the second cell if the first cell is
        // higher.
        if (i + 1 < columns) addWall(c, cells_[j * columns + i + 1], i + 1, j + 1, i + 1, j);
        if (j + 2 < ys_.size()) addWall(c, cells_[(j + 1) * columns + i], i, j + 1, i + 1, j + 1);
      }
    }
  }

  // Returns the grid lines between the coordinates a and b, without a and b, in the order from a to b.
  static std::vector<double> between(const std::vector<double>& lines, double a, double b) {
    std::vector<double> found;
    for (const double v : lines) {
      if (v > std::min(a, b) + kNearest / 2 && v < std::max(a, b) - kNearest / 2) found.push_back(v);
    }
    if (a > b) std::reverse(found.begin(), found.end());
    return found;
  }

  static double onLine(const std::vector<double>& lines, double v) {
    return *std::min_element(lines.begin(), lines.end(),
                             [&](double a, double b) { return std::abs(a - v) < std::abs(b - v); });
  }

  // Adds the ground at a rounded corner of the crossing, a square between the edges of both roads: sidewalk inside a
  // quarter of a circle, curb along the circle, road outside.
  void addCorner(int sx, int sy) {
    const Layout& l = layout_;
    const double height = std::round(l.p.curbHeight * 1e6) / 1e6;
    const double cornerX = onLine(xs_, l.crossX + sx * l.crossEdge);
    const double cornerY = onLine(ys_, sy * l.roadEdge);
    const double centerX = onLine(xs_, l.crossX + sx * (l.crossEdge + l.cornerRadius));
    const double centerY = onLine(ys_, sy * (l.roadEdge + l.cornerRadius));
    // Returns points from the arc's end at the edge of the cross street (k = 0) to its end at the edge of the main
    // road.
    const auto arc = [&](double radius, double z) {
      std::vector<Vec3d> points;
      for (int k = 0; k <= kArcSteps; ++k) {
        const double angle = kPi / 2 * k / kArcSteps;
        points.push_back({centerX - sx * radius * std::cos(angle), centerY - sy * radius * std::sin(angle), z});
      }
      points.front() = {onLine(xs_, points.front().x), centerY, z};
      points.back() = {centerX, onLine(ys_, points.back().y), z};
      return points;
    };
    const bool flip = sx * sy > 0;
    const auto triangle = [&](Ground kind, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
      flip ? shape_.triangle(surface(kind), a, b, c) : shape_.triangle(surface(kind), a, c, b);
    };
    const std::vector<Vec3d> outerLow = arc(l.cornerRadius, 0);
    const std::vector<Vec3d> outer = arc(l.cornerRadius, height);
    const std::vector<Vec3d> inner = arc(l.cornerRadius - Layout::kCurb, height);

    // Adds a fan of triangles from `apex` to the arc. Its two straight sides have vertices at the corners of the
    // adjacent cells.
    const auto fan = [&](Ground kind, const Vec3d& apex, const std::vector<Vec3d>& arcPoints) {
      const auto side = [&](const Vec3d& end) {
        std::vector<Vec3d> points{apex};
        for (const double x : between(xs_, apex.x, end.x)) points.push_back({x, apex.y, apex.z});
        for (const double y : between(ys_, apex.y, end.y)) points.push_back({apex.x, y, apex.z});
        points.push_back(end);
        return points;
      };
      const std::vector<Vec3d> first = side(arcPoints.front());
      const std::vector<Vec3d> last = side(arcPoints.back());
      const std::size_t n = arcPoints.size();
      for (std::size_t k = 0; k + 1 < first.size(); ++k) triangle(kind, first[k], first[k + 1], arcPoints[1]);
      for (std::size_t k = 1; k + 2 < n; ++k) triangle(kind, apex, arcPoints[k], arcPoints[k + 1]);
      for (std::size_t k = 0; k + 1 < last.size(); ++k) triangle(kind, last[k + 1], last[k], arcPoints[n - 2]);
    };
    fan(Ground::Sidewalk, {centerX, centerY, height}, inner);
    std::vector<Vec3d> roadSide(outerLow.rbegin(), outerLow.rend());
    fan(Ground::Road, {cornerX, cornerY, 0}, roadSide);
    for (std::size_t k = 0; k + 1 < outer.size(); ++k) {
      triangle(Ground::Curb, inner[k], outer[k], outer[k + 1]);
      triangle(Ground::Curb, inner[k], outer[k + 1], inner[k + 1]);
      triangle(Ground::Curb, outer[k], outerLow[k], outerLow[k + 1]);
      triangle(Ground::Curb, outer[k], outerLow[k + 1], outer[k + 1]);
    }
  }

  const Layout& layout_;
  Shape shape_;
  std::array<SurfaceIndex, 9> surfaces_{};  // in the order of Ground
  std::vector<double> xs_, ys_;
  std::vector<Cell> cells_;
};

}  // namespace

Model makeGround(SceneBuilder& builder, const Layout& layout) {
  return GroundMaker(builder, layout).make();
}

}  // namespace scanmill::street
