// Adds random roads and their wear.

#include <algorithm>
#include <cmath>

#include "town/layout.h"

namespace scanmill::town {

using models::Kind;

void Layout::drawRoads() {
  // The heading is a smooth random field that varies by less than a right angle, so that the line never crosses itself.
  const auto line = [&](const FieldAddress& field, Point2 from, double heading, double bend, double length) {
    std::vector<Point2> points{from};
    const double start = relief(field, 0, 0.5, 90);
    for (double s = 0; s + kRoadStep / 2 < length; s += kRoadStep) {
      const double turned = heading + bend * 1.8 * (relief(field, s + kRoadStep / 2, 0.5, 90) - start);
      const Point2 p = points.back();
      points.push_back({p.x + kRoadStep * std::cos(turned), p.y + kRoadStep * std::sin(turned)});
    }
    return points;
  };
  const double reach = parameters_.length / 2 + kBeyond;
  std::vector<Point2> points = line({seed_, Field::MainRoadBehind}, {0, 0}, kPi, character_.bend, reach);
  std::reverse(points.begin(), points.end());
  const std::vector<Point2> ahead = line({seed_, Field::MainRoadAhead}, {0, 0}, 0, character_.bend, reach);
  points.insert(points.end(), ahead.begin() + 1, ahead.end());
  Road main;
  main.line = std::move(points);
  main.section = character_.main;
  main.main = true;
  roads_.add(std::move(main));
  const double middle = roads_.roads().front().length() / 2;
  mainFrom_ = middle - parameters_.length / 2;
  mainTo_ = middle + parameters_.length / 2;

  // Side roads begin at the main road, and some continue on its other side. Two side roads at the same side are far
  // enough apart for plots.
  constexpr double kApart = 45;  // m, least distance between two side roads at the same side
  std::vector<std::pair<double, int>> taken;
  for (int i = 0; i < character_.sideRoads; ++i) {
    Draw draw(seed_, Kind::SideRoad, static_cast<std::uint32_t>(i));
    const double along = draw.in(mainFrom_ + 20, mainTo_ - 20);
    const double angle = kPi / 2 + draw.in(-0.45, 0.45);
    const bool crosses = draw.chance(0.5);
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
      road.line = line({seed_, Field::SideRoad, static_cast<std::uint32_t>(2 * i + (side > 0 ? 1 : 0))}, at, turn,
                       0.6 * character_.bend, draw.in(60, 150));
      road.section = character_.side;
      road.joins = along;
      road.joinsLeft = side > 0;
      roads_.add(std::move(road));
      roads_.addJoint(at);
      taken.emplace_back(along, side);
    }
  }
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
      potholes_.push_back({besideRoad(road, along, lateral).at, draw.in(0.2, 0.6), draw.in(0.02, 0.07)});
    }
  }
  for (std::uint32_t i = 0; i < potholes_.size(); ++i) {
    enter({potholes_[i].center, potholes_[i].radius, potholes_[i].radius, 0}, i, potholeCells_);
  }
}

}  // namespace scanmill::town
