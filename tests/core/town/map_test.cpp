#include "town/map.h"

#include "tests/support/message_of.h"

namespace scanmill::town {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::Optional;

const std::filesystem::path kVillage = std::filesystem::path(SCANMILL_SOURCE_DIR) / "scenes/village.osm";

MapRoad road(const std::string& name, const std::vector<std::pair<std::int64_t, Point2>>& points) {
  MapRoad made;
  made.name = name;
  for (const auto& [node, at] : points) {
    made.nodes.push_back(node);
    made.line.push_back(at);
  }
  return made;
}

const MapRoad* longest(const std::vector<MapRoad>& roads, const std::string& name) {
  const MapRoad* found = nullptr;
  for (const MapRoad& r : roads) {
    if (r.name == name && (found == nullptr || r.length() > found->length())) found = &r;
  }
  return found;
}

// A thousandth of a degree along the meridian and along the parallel, by the ellipsoid's radii of curvature.
TEST(Osm, PlacesAreInMetresOnTheEllipsoid) {
  constexpr double kLatitude = 48.5;
  constexpr double kStep = 1e-3;  // degrees
  OsmExtract extract;
  for (const bool meridian : {true, false}) {
    OsmWay way;
    way.tags.pairs = {{"highway", "residential"}};
    const double north = meridian ? kStep : 0;
    const double east = meridian ? 0 : kStep;
    way.runs = {{{meridian ? 1 : 4, kLatitude - north, 9 - east},
                 {2, kLatitude, 9},
                 {meridian ? 3 : 5, kLatitude + north, 9 + east}}};
    extract.ways.push_back(way);
  }
  const Map map = makeMap(extract);
  ASSERT_EQ(map.roads.size(), 2u);
  const std::vector<Point2>& up = map.roads[0].line;
  const std::vector<Point2>& right = map.roads[1].line;
  const double s = std::sin(kLatitude * kPi / 180);
  const double square = 0.00669437999014;  // of the eccentricity, WGS 84
  const double across = 6378137 / std::sqrt(1 - square * s * s);
  const double along = across * (1 - square) / (1 - square * s * s);
  const double step = kStep * kPi / 180;
  EXPECT_NEAR(up[2].y - up[0].y, 2 * step * along, 1e-3);
  EXPECT_NEAR(right[2].x - right[0].x, 2 * step * across * std::cos(kLatitude * kPi / 180), 1e-3);
  EXPECT_NEAR(up[1].x, 0, 1e-6);
  EXPECT_NEAR(up[1].y, 0, 1e-6);
  EXPECT_NEAR(map.origin.latitude, kLatitude, 1e-9);
  const OsmNode there = degreesAt(map, right[2]);
  EXPECT_NEAR(there.latitude, kLatitude, 1e-9);
  EXPECT_NEAR(there.longitude, 9 + kStep, 1e-9);
}

TEST(JoinRoads, PiecesBecomeOneRoad) {
  const auto joined = joinRoads({road("A", {{1, {0, 0}}, {2, {50, 0}}}), road("A", {{3, {90, 30}}, {2, {50, 0}}})});
  ASSERT_EQ(joined.size(), 1u);
  EXPECT_NEAR(joined[0].length(), 100, 1e-9);
  EXPECT_EQ(joined[0].nodes.size(), 3u);
}

// At a crossing roads go straight on, and the name decides where two do.
TEST(JoinRoads, CrossingsGoStraightOn) {
  const auto joined = joinRoads({road("", {{1, {-80, 0}}, {2, {0, 0}}, {3, {80, 0}}}),
                                 road("", {{4, {5, -60}}, {2, {0, 0}}}), road("", {{2, {0, 0}}, {5, {-5, 60}}})});
  ASSERT_EQ(joined.size(), 2u);
  EXPECT_THAT((std::vector{joined[0].length(), joined[1].length()}), Each(testing::Gt(119)));
  const auto fork = joinRoads({road("A", {{1, {-80, 0}}, {2, {0, 0}}}), road("B", {{2, {0, 0}}, {3, {80, 0}}}),
                               road("A", {{2, {0, 0}}, {4, {78, 20}}})});
  ASSERT_EQ(fork.size(), 2u);
  EXPECT_EQ(longest(fork, "A")->nodes.size(), 3u);
}

TEST(JoinRoads, OneWayRoadsKeepTheirDirection) {
  MapRoad first = road("A", {{1, {0, 0}}, {2, {50, 0}}});
  MapRoad second = road("A", {{2, {50, 0}}, {3, {90, 0}}});
  MapRoad against = road("A", {{4, {140, 0}}, {3, {90, 0}}});
  first.oneWay = second.oneWay = against.oneWay = true;
  const auto joined = joinRoads({second, first, against, road("A", {{4, {140, 0}}, {5, {190, 0}}})});
  ASSERT_EQ(joined.size(), 3u);
  EXPECT_THAT(longest(joined, "A")->nodes, ElementsAre(1, 2, 3));
}

// Whatever is joined, no metre of a road is lost or doubled.
TEST(JoinRoads, KeepsEveryMetre) {
  std::vector<MapRoad> raw;
  for (std::int64_t k = 0; k < 12; ++k) {
    const double x = 60.0 * static_cast<double>(k % 4);
    const double y = 45.0 * static_cast<double>(k / 4);
    if (k % 4 < 3) raw.push_back(road(k / 4 == 1 ? "Cross" : "", {{k, {x, y}}, {k + 1, {x + 60, y}}}));
    if (k < 8) raw.push_back(road("", {{k, {x, y}}, {100 + k, {x + 9, y + 20}}, {k + 4, {x, y + 45}}}));
  }
  raw.push_back(road("There and back", {{0, {0, 0}}, {50, {-80, 0}}, {0, {0, 0}}}));
  const auto sum = [](const std::vector<MapRoad>& roads) {
    double metres = 0;
    for (const MapRoad& r : roads) metres += r.length();
    return metres;
  };
  const std::vector<MapRoad> joined = joinRoads(raw);
  EXPECT_NEAR(sum(joined), sum(raw), 1e-9);
  EXPECT_LT(joined.size(), raw.size());
  EXPECT_NEAR(sum(joinRoads(joined)), sum(raw), 1e-9);
}

TEST(ReadMap, TakesTheVillage) {
  const Map map = readMap(kVillage, false, {});
  const MapRoad* main = longest(map.roads, "Mill Road");
  ASSERT_NE(main, nullptr);
  EXPECT_GT(main->length(), 500) << "of three ways";
  EXPECT_THAT(main->sidewalk, Optional(true));
  EXPECT_EQ(std::count_if(map.roads.begin(), map.roads.end(), [](const MapRoad& r) { return r.ring; }), 1);
  EXPECT_TRUE(longest(map.roads, "School Street")->oneWay);
  EXPECT_THAT(longest(map.roads, "Back Lane")->sidewalk, Optional(false));
  EXPECT_EQ(map.paths.size(), 1u) << "pavements are their roads'";
  EXPECT_EQ(map.trees.size(), 20u);
  EXPECT_EQ(map.barriers.size(), 3u);
  EXPECT_EQ(map.areas.size(), 7u);
  const auto school =
      std::find_if(map.buildings.begin(), map.buildings.end(), [](const MapBuilding& b) { return !b.courts.empty(); });
  ASSERT_NE(school, map.buildings.end());
  EXPECT_THAT(school->floors, Optional(2));
  EXPECT_EQ(map.leftOut.text(), "");
  EXPECT_GE(map.buildings.size(), 28u);
  EXPECT_EQ(std::count_if(map.buildings.begin(), map.buildings.end(), [](const MapBuilding& b) { return b.shop; }), 3);
}

// The origin lies on the main road; side roads begin where they say that they join it, on that side.
TEST(CutOut, RoadsMeetTheMainOne) {
  const Map map = readMap(kVillage, false, {});
  Parameters parameters;
  std::size_t joined = 0;
  std::vector<std::string> names;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const MapPlace place = cutOut(map, parameters, seed, 280, {});
    const std::vector<Point2>& main = place.roads.front().line;
    names.push_back(place.roads.front().name);
    const auto nearest = [&](const Point2& p) {
      std::size_t best = 0;
      for (std::size_t i = 0; i < main.size(); ++i) {
        if (std::hypot(main[i].x - p.x, main[i].y - p.y) < std::hypot(main[best].x - p.x, main[best].y - p.y)) best = i;
      }
      return best;
    };
    const Point2& origin = main[nearest({0, 0})];
    EXPECT_LT(std::hypot(origin.x, origin.y), 2);
    EXPECT_LT(place.mainFrom, place.mainTo);
    for (const MapRoad& side : place.roads) {
      if (!side.joins) continue;
      ++joined;
      const Point2& start = side.line.front();
      const std::size_t at = nearest(start);
      EXPECT_NEAR(kRoadStep * static_cast<double>(at), *side.joins, 4);
      EXPECT_LT(std::hypot(main[at].x - start.x, main[at].y - start.y), 2.5);
      const Point2& on = side.line[5];
      const Point2& ahead = main[std::min(at + 1, main.size() - 1)];
      const Point2& behind = main[at > 0 ? at - 1 : 0];
      const double left = (ahead.x - behind.x) * (on.y - start.y) - (ahead.y - behind.y) * (on.x - start.x);
      EXPECT_EQ(left > 0, side.joinsLeft);
    }
  }
  EXPECT_GT(joined, 15u);
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  EXPECT_GE(names.size(), 3u) << "the seed draws the road";
}

}  // namespace
}  // namespace scanmill::town
