#include "scene/town/layout.h"

#include <algorithm>
#include <cmath>

#include "scene/town/relief.h"

namespace scanmill::town {
namespace {

using parts::Fencing;
using parts::Footprint;
using parts::House;
using parts::Kind;
using parts::Roof;
using parts::smooth;

constexpr double kBeyond = 130;    // m, that the main road goes on beyond its plots
constexpr double kPatchCell = 8;   // m
constexpr double kPatchReach = 4;  // m
constexpr double kDriveway = 3;    // m wide
constexpr double kWalkway = 1.4;   // m wide

std::uint64_t cellKey(double x, double y) {
  const auto cell = [](double v) { return static_cast<std::int64_t>(std::floor(v / kPatchCell)); };
  return static_cast<std::uint64_t>(cell(x)) << 32 ^ (static_cast<std::uint64_t>(cell(y)) & 0xFFFFFFFF);
}

// How far outside of a rectangle a point lies, along its axes (m).
double outside(const Footprint& f, const Point2& p) {
  const double c = std::cos(f.yaw);
  const double s = std::sin(f.yaw);
  const double dx = p.x - f.center.x;
  const double dy = p.y - f.center.y;
  return std::max(std::abs(dx * c + dy * s) - f.halfX, std::abs(dy * c - dx * s) - f.halfY);
}

District districtOf(const Parameters& p, Draw& draw) {
  const double pick = draw.next();
  if (p.district == "rural") return District::Rural;
  if (p.district == "suburban") return District::Suburban;
  if (p.district == "dense") return District::Dense;
  return pick < 0.25 ? District::Rural : pick < 0.7 ? District::Suburban : District::Dense;
}

}  // namespace

Parameters readParameters(Fields& fields) {
  Parameters p;
  p.district = fields.choice("district", {"any", "rural", "suburban", "dense"}, p.district);
  p.season = fields.choice("season", {"any", "summer", "autumn", "winter"}, p.season);
  p.length = fields.number("length", {100, 1000}, p.length);
  const Range factor{0, 5};
  p.slope = fields.number("slope", {0, 3}, p.slope);
  p.greenery = fields.number("greenery", factor, p.greenery);
  p.vehicles = fields.number("vehicles", factor, p.vehicles);
  p.people = fields.number("people", factor, p.people);
  p.detail = fields.number("detail", {0.05, 2}, p.detail);
  return p;
}

Character::Character(const Parameters& p, std::uint64_t seed) {
  Draw draw(seed, Kind::Town);
  district = districtOf(p, draw);
  const bool rural = district == District::Rural;
  const bool dense = district == District::Dense;
  const double lane = rural ? draw.in(2.4, 3.2) : draw.in(2.7, 3.6);
  main.parking = rural ? 0 : draw.chance(dense ? 0.65 : 0.3) ? draw.in(1.9, 2.4) : 0;
  main.half = lane + main.parking;
  main.sidewalk = rural ? (draw.chance(0.3) ? draw.in(1.2, 1.8) : 0) : dense ? draw.in(1.8, 4.5) : draw.in(1.2, 2.6);
  main.curb = main.sidewalk > 0 ? 0.15 : 0;
  main.step = main.sidewalk > 0 ? draw.in(0.08, 0.16) : 0;
  main.verge = rural ? draw.in(0.8, 2.5) : draw.chance(dense ? 0.25 : 0.55) ? draw.in(0.8, 4.5) : 0;
  side = main;
  side.parking = rural ? 0 : draw.chance(0.3) ? draw.in(1.9, 2.3) : 0;
  side.half = draw.in(2.2, 3.2) + side.parking;
  side.verge *= draw.in(0, 1);
  side.sidewalk *= draw.in(0.7, 1.0);
  sideRoads = rural ? draw.below(3) : 2 + draw.below(4);
  bend = dense ? draw.in(0, 0.35) : draw.in(0.15, 0.9);
  hills = p.slope * draw.in(1.5, dense ? 4.5 : 7);
  banks = p.slope * (dense ? draw.in(0.5, 2.5) : draw.in(2, 7));
  undulation = rural ? draw.in(0.3, 0.7) : dense ? draw.in(0.1, 0.25) : draw.in(0.15, 0.45);
  setback = rural ? draw.in(4, 20) : dense ? draw.in(0, 1.2) : draw.in(1, 9);
  setbackSpread = dense ? draw.in(0, 0.6) : setback * draw.in(0.1, 0.6);
  built = rural ? draw.in(0.15, 0.5) : dense ? draw.in(0.85, 1) : draw.in(0.6, 0.95);
  plotWidth = rural ? draw.in(22, 40) : dense ? draw.in(10, 15) : draw.in(13, 24);
  floorsLow = dense ? 2 + draw.below(2) : 1;
  floorsHigh = dense ? floorsLow + 1 + draw.below(2) : 2;
  const double green = p.greenery * draw.in(0.5, 1.6);
  hedges = std::min(0.9, green * (dense ? 0.05 : draw.in(0.2, 0.7)));
  fences = (1 - hedges) * draw.in(0.2, 0.6);
  avenue = std::min(1.0, green * draw.in(0, dense ? 0.6 : 0.8));
  gardenTrees = green * (dense ? 0.3 : draw.in(0.6, 2.2));
  gardenBushes = green * (dense ? 0.8 : draw.in(2, 7));
  woods = std::min(0.95, green * (rural ? draw.in(0.3, 0.8) : dense ? draw.in(0.05, 0.3) : draw.in(0.15, 0.6)));
  // Many places have next to no vehicle in sight, some are full of them.
  const double full = draw.next();
  parked = std::min(0.95, p.vehicles * full * full * (rural ? 0.15 : dense ? 0.9 : 0.6));
  traffic = p.vehicles * draw.in(0.1, rural ? 0.8 : 2.2);
  people = p.people * (rural ? draw.in(0, 1.5) : dense ? draw.in(3, 12) : draw.in(0.5, 4));
  clutter = rural ? draw.in(1, 4) : dense ? draw.in(6, 16) : draw.in(3, 9);
  // From numbers of its own, so that a place is the same in all seasons.
  Draw sky(seed, Kind::Town, 1);
  const double pick = sky.next();
  season = p.season == "any"      ? (pick < 0.5    ? Season::Summer
                                     : pick < 0.75 ? Season::Autumn
                                                   : Season::Winter)
           : p.season == "autumn" ? Season::Autumn
           : p.season == "winter" ? Season::Winter
                                  : Season::Summer;
  wear = sky.next() * sky.next();
  if (season == Season::Autumn) foliage = sky.in(0.15, 0.7);
  if (season == Season::Winter) {
    foliage = 0.03;
    snow = sky.in(0.04, 0.25);
    snowBanks = sky.in(0.2, 0.7);
  }
}

Layout::Layout(const Parameters& parameters, std::uint64_t seed)
    : parameters_(parameters), seed_(seed), character_(parameters, seed), half_(parameters.length / 2 + kBeyond + 20) {
  drawRoads();
  drawPotholes();
  drawPlots();
}

void Layout::drawPotholes() {
  for (std::uint32_t r = 0; r < roads_.roads().size(); ++r) {
    const Road& road = roads_.roads()[r];
    Draw draw(seed_, Kind::Pothole, r);
    const auto count = static_cast<int>(12 * character_.wear * road.length() / 100 + draw.next());
    for (int k = 0; k < count; ++k) {
      const double along = draw.in(0, road.length());
      const double reach = road.section.half - road.section.parking - 0.7;
      const double lateral = draw.in(-reach, reach);
      const Point2 p = road.point(along);
      const Point2 h = road.heading(along);
      potholes_.push_back({{p.x - h.y * lateral, p.y + h.x * lateral}, draw.in(0.2, 0.6), draw.in(0.02, 0.07)});
    }
  }
  for (std::uint32_t i = 0; i < potholes_.size(); ++i) {
    enter({potholes_[i].center, potholes_[i].radius, potholes_[i].radius, 0}, i, potholeCells_);
  }
}

bool Layout::nearPothole(const Point2& p, double reach) const {
  const auto cell = potholeCells_.find(cellKey(p.x, p.y));
  if (cell == potholeCells_.end()) return false;
  return std::any_of(cell->second.begin(), cell->second.end(), [&](std::uint32_t i) {
    const Pothole& hole = potholes_[i];
    return std::hypot(p.x - hole.center.x, p.y - hole.center.y) < hole.radius + reach;
  });
}

void Layout::drawRoads() {
  // The heading wanders as a smooth field does, by less than a right angle: the line never meets itself.
  const auto line = [&](std::uint64_t key, Point2 from, double heading, double bend, double length) {
    std::vector<Point2> points{from};
    const double start = relief(key, 0, 0.5, 90);
    for (double s = 0; s + kRoadStep / 2 < length; s += kRoadStep) {
      const double turned = heading + bend * 1.8 * (relief(key, s + kRoadStep / 2, 0.5, 90) - start);
      const Point2 p = points.back();
      points.push_back({p.x + kRoadStep * std::cos(turned), p.y + kRoadStep * std::sin(turned)});
    }
    return points;
  };
  const double reach = parameters_.length / 2 + kBeyond;
  std::vector<Point2> points = line(seed_ * 8 + 1, {0, 0}, kPi, character_.bend, reach);
  std::reverse(points.begin(), points.end());
  const std::vector<Point2> ahead = line(seed_ * 8 + 2, {0, 0}, 0, character_.bend, reach);
  points.insert(points.end(), ahead.begin() + 1, ahead.end());
  Road main;
  main.line = std::move(points);
  main.section = character_.main;
  main.main = true;
  roads_.add(std::move(main));
  const double middle = roads_.roads().front().length() / 2;
  mainFrom_ = middle - parameters_.length / 2;
  mainTo_ = middle + parameters_.length / 2;

  // Side roads leave to one side, or cross; two on one side are far enough apart for plots.
  constexpr double kApart = 45;  // m
  std::vector<std::pair<double, int>> taken;
  for (int i = 0; i < character_.sideRoads; ++i) {
    Draw draw(seed_, Kind::SideRoad, static_cast<std::uint32_t>(i));
    const double along = draw.in(mainFrom_ + 20, mainTo_ - 20);
    const double angle = kPi / 2 + draw.in(-0.45, 0.45);
    const bool crosses = draw.chance(0.4);
    const int first = draw.chance(0.5) ? 1 : -1;
    for (const int side : {first, -first}) {
      if (side != first && !crosses) continue;
      const bool near = std::any_of(taken.begin(), taken.end(), [&](const auto& t) {
        return std::abs(t.first - along) < (t.second == side ? kApart : 14);
      });
      if (near && side == first) break;
      if (near) continue;
      const Point2 at = roads_.roads().front().point(along);
      const Point2 heading = roads_.roads().front().heading(along);
      Road road;
      const double turn = std::atan2(heading.y, heading.x) + (side == first ? side * angle : side * (kPi - angle));
      road.line = line(seed_ * 64 + 16 + static_cast<std::uint64_t>(2 * i + (side > 0 ? 1 : 0)), at, turn,
                       0.6 * character_.bend, draw.in(60, 150));
      road.section = character_.side;
      road.joins = along;
      road.joinsLeft = side > 0;
      roads_.add(std::move(road));
      taken.emplace_back(along, side);
    }
  }
}

void Layout::drawPlots() {
  for (std::uint32_t r = 0; r < roads_.roads().size(); ++r) {
    const Road& road = roads_.roads()[r];
    for (const int side : {-1, 1}) {
      addPlots(r, side, road.main ? mainFrom_ : 12, road.main ? mainTo_ : road.length() - 4);
    }
  }
  for (std::uint32_t i = 0; i < patches_.size(); ++i) enter(patches_[i].place, i, patchCells_);
  // Houses stand on the ground at their door, which is made level about them.
  std::vector<Terrace> terraces;
  for (Plot& plot : plots_) {
    if (!plot.built) continue;
    const parts::House& house = plot.house;
    const Vec3d door = house.place * Vec3d{house.doorX(), -0.6, 0};
    plot.house.place.translation.z = heightAt({door.x, door.y});
    const double yaw = std::atan2(house.place.linear.x.y, house.place.linear.x.x);
    const auto level = [&](const Vec3d& middle, double width, double depth) {
      const Vec3d at = house.place * middle;
      terraces.push_back({{{at.x, at.y}, width / 2 + 0.5, depth / 2 + 0.5, yaw}, plot.house.place.translation.z});
    };
    level({house.width / 2, house.depth / 2, 0}, house.width, house.depth);
    if (house.garage) level(house.garageMiddle(), parts::kGarageWidth, parts::kGarageDepth);
  }
  terraces_ = std::move(terraces);
  for (std::uint32_t i = 0; i < terraces_.size(); ++i) enter(terraces_[i].place, i, terraceCells_);
}

// Into all cells that lie within kPatchReach of the rectangle.
void Layout::enter(const Footprint& f, std::uint32_t index, Cells& cells) {
  const double reach = std::hypot(f.halfX, f.halfY) + kPatchReach;
  for (const double y : parts::steps(f.center.y - reach, f.center.y + reach + kPatchCell, kPatchCell)) {
    for (const double x : parts::steps(f.center.x - reach, f.center.x + reach + kPatchCell, kPatchCell)) {
      std::vector<std::uint32_t>& cell = cells[cellKey(x, y)];
      if (std::find(cell.begin(), cell.end(), index) == cell.end()) cell.push_back(index);
    }
  }
}

// Whether the rectangle stays clear of roads and sidewalks, and of other houses.
bool Layout::fits(const Footprint& f, double gap) const {
  const double c = std::cos(f.yaw);
  const double s = std::sin(f.yaw);
  for (const double u : {-1.0, 0.0, 1.0}) {
    for (const double v : {-1.0, 0.0, 1.0}) {
      const double x = f.center.x + u * f.halfX * c - v * f.halfY * s;
      const double y = f.center.y + u * f.halfX * s + v * f.halfY * c;
      const Beside beside = roads_.at(x, y);
      if (beside.known && beside.edge < beside.section.outer() + gap) return false;
    }
  }
  return houses_.isFree(f);
}

void Layout::addPlots(std::uint32_t r, int side, double from, double to) {
  const Road& road = roads_.roads()[r];
  const Character& c = character_;
  const bool dense = c.district == District::Dense;
  double start = from;
  while (to - start > 8) {
    Plot plot;
    plot.number = static_cast<std::uint32_t>(plots_.size());
    Draw draw(seed_, Kind::Plot, plot.number + 1000);
    plot.road = r;
    plot.side = side;
    plot.from = start;
    plot.to = std::min(to, start + draw.around(c.plotWidth, 0.3));
    plot.setback = std::max(dense ? 0.02 : 1.0, c.setback + draw.in(-1, 1) * c.setbackSpread);
    const double width = plot.to - plot.from;
    const bool attached = dense && draw.chance(0.75);
    const double gap = attached ? 0 : draw.in(1.2, std::max(1.5, 0.35 * width));
    House& house = plot.house;
    house.number = plot.number;
    house.width = std::clamp(width - gap, 6.0, 18.0);
    house.depth = draw.in(7.5, 12.5);
    house.floors = c.floorsLow + draw.below(c.floorsHigh - c.floorsLow + 1);
    house.columns = std::max(2, static_cast<int>(house.width / draw.in(2.2, 3.1)));
    house.doorColumn = draw.below(house.columns);
    house.roof =
        std::array{
            Roof::Gable, Roof::Gable, Roof::CrossGable, Roof::Hip, Roof::Hip, Roof::Flat}[static_cast<std::size_t>(
            draw.below(6))];
    if (house.floors >= 4) house.roof = draw.chance(0.5) ? Roof::Flat : Roof::Gable;
    house.shop = dense && draw.chance(0.4);
    const double fencing = draw.next();
    if (fencing < c.hedges) {
      plot.fencing = Fencing::Hedge;
    } else if (fencing < c.hedges + c.fences) {
      plot.fencing =
          std::array{Fencing::Pickets, Fencing::Bars, Fencing::Brick}[static_cast<std::size_t>(draw.below(3))];
    }
    if (plot.setback < 1.5) plot.fencing = Fencing::None;
    const bool wanted = draw.chance(c.built) && width >= 6.5;
    const bool hasDriveway = !attached && draw.chance(0.6) && gap > kDriveway - 0.5;
    const double middle = (plot.from + plot.to) / 2;
    const double outer = road.section.half + road.section.outer();
    const Point2 heading = road.heading(middle);
    const double yaw = std::atan2(heading.y, heading.x) + (side > 0 ? 0 : kPi);
    const auto spot = [&](double along, double lateral) {
      const Point2 p = road.point(along);
      const Point2 h = road.heading(along);
      return Point2{p.x - h.y * side * lateral, p.y + h.x * side * lateral};
    };
    // Beside a driveway the house stands at the other end of the plot.
    const double shift = hasDriveway ? -side * (gap / 2 - 0.2) : 0;
    const Footprint body{spot(middle + shift, outer + plot.setback + house.depth / 2), house.width / 2, house.depth / 2,
                         yaw};
    const Footprint roomy{body.center, body.halfX + (attached ? -0.05 : 0.4), body.halfY + 0.4, yaw};
    if (wanted && fits({body.center, body.halfX, body.halfY, yaw}, 0.0) && houses_.isFree(roomy)) {
      houses_.add(body);
      plot.built = true;
      house.forecourt = plot.setback;
      house.ivy = draw.chance(0.2 * parameters_.greenery);
      // The house's frame: x along its front to its right as seen from inside, the front wall in y = 0 facing -y.
      const double cy = std::cos(yaw);
      const double sy = std::sin(yaw);
      const Point2 corner{body.center.x - cy * body.halfX + sy * body.halfY,
                          body.center.y - sy * body.halfX - cy * body.halfY};
      house.place = parts::at({corner.x, corner.y, 0}, yaw);
      const Vec3d door = house.place * Vec3d{house.doorX(), -0.6, 0};
      const auto strip = [&](const Point2& inner, double half, double depth, GroundKind kind) {
        const Vec3d out{sy, -cy, 0};  // towards the road
        const double way = depth + road.section.outer();
        patches_.push_back({{{inner.x + out.x * way / 2, inner.y + out.y * way / 2}, half, way / 2, yaw}, kind});
      };
      if (plot.setback > 0.6) strip({door.x, door.y}, kWalkway / 2, plot.setback - 0.6, GroundKind::Path);
      if (hasDriveway) {
        const Vec3d beside = house.place * Vec3d{house.width + kDriveway / 2 + 0.3, 6, 0};
        strip({beside.x, beside.y}, kDriveway / 2, plot.setback + 6, GroundKind::Driveway);
        const Vec3d inside = house.place * house.garageMiddle();
        const Footprint garage{{inside.x, inside.y}, parts::kGarageWidth / 2 - 0.05, parts::kGarageDepth / 2, yaw};
        house.garage = draw.chance(0.55) && fits(garage, 1);
        if (house.garage) houses_.add(garage);
      }
    }
    plots_.push_back(plot);
    start = plot.to;
  }
}

double Layout::outsidePatches(const Point2& p) const {
  double least = kPatchReach;
  const auto cell = patchCells_.find(cellKey(p.x, p.y));
  if (cell == patchCells_.end()) return least;
  for (const std::uint32_t i : cell->second) least = std::min(least, outside(patches_[i].place, p));
  return least;
}

const Patch* Layout::patchAt(const Point2& p) const {
  const auto cell = patchCells_.find(cellKey(p.x, p.y));
  if (cell == patchCells_.end()) return nullptr;
  for (const std::uint32_t i : cell->second) {
    if (outside(patches_[i].place, p) < 0) return &patches_[i];
  }
  return nullptr;
}

std::array<double, 5> Layout::borders(const Beside& b) const {
  const CrossSection& s = b.section;
  return {b.edge + s.parking, b.edge, b.edge - s.curb, b.edge - s.curb - s.verge, b.edge - s.outer()};
}

GroundKind Layout::kindAt(const Beside& b, const Point2& p) const {
  if (!b.known) return GroundKind::Lawn;
  const CrossSection& s = b.section;
  if (b.edge < 0) {
    const bool bays = s.parking > 1.5 && b.edge > -s.parking;
    return bays ? GroundKind::Parking : GroundKind::Road;
  }
  if (b.edge < s.curb) return GroundKind::Curb;
  if (const Patch* patch = patchAt(p)) {
    // The pavement goes on across driveways.
    if (b.edge < s.curb + s.verge || b.edge > s.outer()) return patch->kind;
  }
  if (b.edge < s.curb + s.verge) return s.sidewalk > 0 ? GroundKind::Verge : GroundKind::Shoulder;
  if (b.edge < s.outer()) return GroundKind::Sidewalk;
  return GroundKind::Lawn;
}

double Layout::base(const Point2& p) const {
  return character_.hills * (relief(seed_ * 4 + 1, p.x, p.y, 260) + 0.25 * relief(seed_ * 4 + 2, p.x, p.y, 110) +
                             0.11 * relief(seed_ * 4 + 4, p.x, p.y, 45));
}

// Curbs are lowered where a driveway meets the road.
double Layout::lowering(const Beside& b, const Point2& p) const {
  if (b.section.step <= 0 || b.edge > 3) return 1;
  double factor = 1;
  const auto cell = patchCells_.find(cellKey(p.x, p.y));
  if (cell == patchCells_.end()) return 1;
  for (const std::uint32_t i : cell->second) {
    if (patches_[i].kind != GroundKind::Driveway) continue;
    const Footprint& f = patches_[i].place;
    const double across = std::abs((p.x - f.center.x) * std::cos(f.yaw) + (p.y - f.center.y) * std::sin(f.yaw));
    const double beside = smooth((across - f.halfX) / 0.8);
    factor = std::min(factor, std::max(beside, smooth(b.edge / 1.5)));
  }
  return std::max(factor, 0.25);
}

double Layout::heightAt(GroundKind kind, const Beside& b, const Point2& p) const {
  const double ground = base(p);
  const double edge = b.known ? b.edge : 1e3;
  const bool low = kind == GroundKind::Road || kind == GroundKind::Parking;
  if (low) {
    // A crown, a gutter, and what years of lorries leave.
    const double crown = 0.02 * std::min(-edge, 5.0);
    const double worn = 0.012 * relief(seed_ * 4 + 3, p.x, p.y, 7) + 0.006 * relief(seed_ + 7, p.x, p.y, 1.7);
    double hole = 0;
    if (const auto cell = potholeCells_.find(cellKey(p.x, p.y)); cell != potholeCells_.end()) {
      for (const std::uint32_t i : cell->second) {
        const Pothole& h = potholes_[i];
        const double inwards = 1 - std::hypot(p.x - h.center.x, p.y - h.center.y) / h.radius;
        hole = std::max(hole, h.depth * smooth(2 * inwards));
      }
    }
    return ground + crown + worn - hole;
  }
  const double outer = b.known ? b.section.outer() : 0;
  const double step = b.known ? b.section.step * lowering(b, p) : 0.1;
  const double rise = 0.015 * std::clamp(edge, 0.0, outer);
  const double beyond = std::max(0.0, edge - outer);
  const double paved = kind == GroundKind::Driveway || kind == GroundKind::Path ? 0.3 : 1.0;
  const double wild = character_.undulation * smooth(beyond / 9);
  const double rolling = 1.6 * wild * relief(seed_ + 11, p.x, p.y, 16) + 0.6 * wild * relief(seed_ + 12, p.x, p.y, 5);
  const double bank = character_.banks * smooth((edge - b.section.curb) / 11) * relief(seed_ + 15, p.x, p.y, 45);
  // Of lawns the finest cells' corners, in some places more than in others.
  const double rough = 0.015 + 0.06 * std::max(0.0, relief(seed_ + 16, p.x, p.y, 9));
  const double grain = (0.03 * relief(seed_ + 13, p.x, p.y, 1.6) + rough * relief(seed_ + 14, p.x, p.y, 0.43)) *
                       smooth((edge - b.section.curb) / 0.3) * paved * (kind == GroundKind::Sidewalk ? 0.1 : 1);
  const double natural = ground + step + rise + rolling + bank;
  return natural + smooth(beyond / 1.5) * levelling(p, natural) + grain + snowOn(b, p);
}

// None on what is cleared, which it slopes down to: pavements, driveways and paths. Ploughs leave a bank on verges, and
// beside roads that have no pavement.
double Layout::snowOn(const Beside& b, const Point2& p) const {
  if (character_.snow <= 0) return 0;
  constexpr double kSlope = 0.3;  // m
  constexpr double kBank = 1.3;   // m wide
  const CrossSection& s = b.section;
  const double edge = b.known ? b.edge : 1e3;
  const double outer = b.known ? s.outer() : 0;
  const double verge = edge - (b.known ? s.curb : 0);  // m beyond the curb
  const double cleared = smooth(outsidePatches(p) / 0.5);
  const bool pavement = b.known && s.sidewalk > 0.3;
  double depth = character_.snow * smooth((edge - outer) / kSlope);
  if (b.known && verge > 0 && verge < s.verge) {
    depth = character_.snow * smooth(verge / kSlope) * (pavement ? smooth((s.verge - verge) / kSlope) : 1);
  }
  const double width = std::min(kBank, s.verge);
  if (b.known && width > 0.6 && verge > 0 && verge < width) {
    const double across = std::sin(kPi * verge / width);
    const double along = 0.6 + 1.2 * relief(seed_ + 17, p.x, p.y, 3) + 0.6 * relief(seed_ + 18, p.x, p.y, 0.8);
    depth += character_.snowBanks * across * across * std::max(along, 0.1);
  }
  return depth * cleared;
}

// What brings the ground to the height of the house beside it.
double Layout::levelling(const Point2& p, double natural) const {
  const auto cell = terraceCells_.find(cellKey(p.x, p.y));
  if (cell == terraceCells_.end()) return 0;
  double sum = 0;
  double weights = 0;
  double most = 0;
  for (const std::uint32_t i : cell->second) {
    const double weight = 1 - smooth(outside(terraces_[i].place, p) / kPatchReach);
    sum += weight * (terraces_[i].height - natural);
    weights += weight;
    most = std::max(most, weight);
  }
  return weights > 0 ? most * sum / weights : 0;
}

double Layout::heightAt(const Point2& p) const {
  const Beside b = roads_.at(p.x, p.y);
  return heightAt(kindAt(b, p), b, p);
}

}  // namespace scanmill::town
