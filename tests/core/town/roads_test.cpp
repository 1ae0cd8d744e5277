#include "town/roads.h"

#include "base/random.h"

namespace scanmill::town {
namespace {

Road straight(Point2 from, Point2 to, double half) {
  Road road;
  const double length = std::hypot(to.x - from.x, to.y - from.y);
  const int steps = static_cast<int>(length / kRoadStep);
  for (int i = 0; i <= steps; ++i) {
    const double t = static_cast<double>(i) / steps;
    road.line.push_back({from.x + (to.x - from.x) * t, from.y + (to.y - from.y) * t});
  }
  road.section.half = half;
  return road;
}

TEST(RoadNetwork, TellsWhereAPointLiesBesideARoad) {
  RoadNetwork roads;
  roads.add(straight({-100, 0}, {100, 0}, 3.5));
  const Beside left = roads.at({20.3, 5});
  ASSERT_TRUE(left.nearRoad);
  EXPECT_NEAR(left.edge, 1.5, 1e-12);
  EXPECT_NEAR(left.lateral, 5, 1e-12);
  EXPECT_NEAR(left.along, 120.3, 1e-9);
  EXPECT_NEAR(roads.at({-60, -1}).lateral, -1, 1e-12);
  EXPECT_NEAR(roads.at({-60, -1}).edge, -2.5, 1e-12);
  EXPECT_FALSE(roads.at({0, RoadNetwork::kReach + 0.1}).nearRoad);
  EXPECT_TRUE(roads.at({0, RoadNetwork::kReach - 0.1}).nearRoad);
  EXPECT_NEAR(roads.at({103, 4}).edge, 1.5, 1e-12) << "round about its end";
}

// Of several roads the nearest, but for the rounded corners: there a quarter of 10 m less at most, and continuous.
TEST(RoadNetwork, RoundsTheCornersOfCrossings) {
  const Road a = straight({-100, 0}, {100, 0}, 3);
  const Road b = straight({10, -80}, {30, 80}, 4);
  RoadNetwork both;
  both.add(a);
  both.add(b);
  both.addJoint({20, 0});
  RoadNetwork onlyA;
  onlyA.add(a);
  RoadNetwork onlyB;
  onlyB.add(b);
  int rounded = 0;
  for (std::uint32_t i = 0; i < 4000; ++i) {
    const RandomBlock words = randomBlock({.seed = 3, .beam = i});
    const double x = -20 + 80 * uniform(words[0]);
    const double y = -40 + 80 * uniform(words[1]);
    const Beside beside = both.at({x, y});
    const double edgeA = onlyA.at({x, y}).edge;
    const double edgeB = onlyB.at({x, y}).edge;
    const double least = std::min(edgeA, edgeB);
    EXPECT_LE(beside.edge, least + 1e-9);
    EXPECT_GE(beside.edge, least - 2.5 - 1e-9);
    EXPECT_EQ(beside.road, edgeA <= edgeB ? 0u : 1u);
    if (std::abs(edgeA - edgeB) > 10 + 1e-9) {
      EXPECT_NEAR(beside.edge, least, 1e-9);
    } else {
      ++rounded;
    }
    if (std::abs(edgeA) < 40 && std::abs(edgeB) < 40) {
      EXPECT_LT(std::abs(both.at({x + 0.01, y}).edge - beside.edge), 0.0101 * 1.01);
    }
  }
  EXPECT_GT(rounded, 300);
}

// Roads that lie side by side stay two.
TEST(RoadNetwork, RoundsNothingWhereRoadsDoNotMeet) {
  RoadNetwork roads;
  roads.add(straight({-100, 0}, {100, 0}, 3));
  roads.add(straight({-100, 9}, {100, 9}, 3));
  roads.addJoint({-100, 4});
  EXPECT_NEAR(roads.at({0, 4.5}).edge, 1.5, 1e-3);
  EXPECT_NEAR(roads.at({-95, 4.5}).edge, -1, 1e-3);
  for (double x = -90; x < 90; x += 0.5) {
    EXPECT_LT(std::abs(roads.at({x + 0.5, 4.5}).edge - roads.at({x, 4.5}).edge), 0.2) << "continuous";
  }
}

// A winding road: the same point as a search over all of its segments finds.
TEST(RoadNetwork, FindsTheNearestPointOfALine) {
  Road winding;
  for (int i = 0; i <= 300; ++i) {
    const double turn = 0.04 * i;
    winding.line.push_back({(20 + 0.4 * i) * std::cos(turn), (20 + 0.2 * i) * std::sin(turn)});
  }
  RoadNetwork roads;
  roads.add(winding);
  const Road& road = roads.roads().front();
  int known = 0;
  for (std::uint32_t i = 0; i < 4000; ++i) {
    const RandomBlock words = randomBlock({.seed = 5, .beam = i});
    const Point2 p{-250 + 500 * uniform(words[0]), -250 + 500 * uniform(words[1])};
    double least = 1e9;
    double along = 0;
    for (std::size_t k = 0; k + 1 < road.line.size(); ++k) {
      const Point2& a = road.line[k];
      const Point2& b = road.line[k + 1];
      const double size = road.at[k + 1] - road.at[k];
      const double part = std::clamp(((p.x - a.x) * (b.x - a.x) + (p.y - a.y) * (b.y - a.y)) / (size * size), 0.0, 1.0);
      const Point2 foot = models::lerp(a, b, part);
      const double distance = std::hypot(p.x - foot.x, p.y - foot.y);
      if (distance >= least - 1e-12) continue;
      least = distance;
      along = road.at[k] + part * size;
    }
    const Beside beside = roads.at({p.x, p.y});
    ASSERT_EQ(beside.nearRoad, least <= RoadNetwork::kReach);
    if (!beside.nearRoad) continue;
    ++known;
    EXPECT_NEAR(std::abs(beside.lateral), least, 1e-9);
    EXPECT_NEAR(beside.along, along, 1e-6);
  }
  EXPECT_GT(known, 500);
}

TEST(Road, IsMeasuredAlongItsLine) {
  RoadNetwork roads;
  roads.add(straight({1, 2}, {4, 6}, 3));
  const Road& road = roads.roads().front();
  EXPECT_NEAR(road.length(), 5, 1e-12);
  EXPECT_NEAR(road.point(2.5).x, 2.5, 1e-12);
  EXPECT_NEAR(road.point(99).y, 6, 1e-12);
  EXPECT_NEAR(road.heading(1).x, 0.6, 1e-12);
  for (const double at : {-7.0, 5.0, 99.0}) EXPECT_NEAR(road.heading(at).y, 0.8, 1e-12) << at;
}

}  // namespace
}  // namespace scanmill::town
