#include "tests/support/labels.h"
#include "tests/support/message_of.h"
#include "town/layout.h"
#include "town/map.h"

namespace scanmill::town {
namespace {

using testing::DoubleNear;
using testing::HasSubstr;
using testing::Optional;

using Pairs = std::vector<std::pair<std::string, std::string>>;

// The place of a point that is `x` metres east and `y` metres north of the middle of road().
OsmNode at(double x, double y) {
  static std::int64_t id = 100;
  return {++id, 51 + y / 111250, 0.5 + x / 70200};
}

OsmArea area(const std::string& element, Pairs tags, const std::vector<Point2>& corners, std::int64_t building = 0) {
  OsmArea made;
  made.tags = {element, std::move(tags)};
  for (const Point2& p : corners) made.outer.push_back(at(p.x, p.y));
  made.building = building;
  return made;
}

std::vector<Point2> rectangle(double west, double south, double east, double north) {
  return {{west, south}, {east, south}, {east, north}, {west, north}};
}

// A road 300 m along x.
OsmExtract road() {
  OsmExtract extract;
  extract.ways.push_back({{"way 1", {{"highway", "residential"}}}, {{at(-150, 0), at(0, 0), at(150, 0)}}});
  return extract;
}

OsmExtract withAreas(std::vector<OsmArea> areas) {
  OsmExtract extract = road();
  extract.areas = std::move(areas);
  return extract;
}

Layout layOut(const Map& map) {
  Parameters parameters;
  parameters.length = 200;
  return {parameters, 1, cutOut(map, parameters, 1, 200, {})};
}

const Pairs kTower = {{"building:part", "yes"}, {"height", "100"}, {"min_height", "10"}};

// A podium of 10 m and a tower of 100 m, not a block of 100 m.
TEST(MapBuildings, PartsStandInPlaceOfTheirOutline) {
  const Map map =
      makeMap(withAreas({area("way 2", {{"building", "yes"}, {"height", "100"}}, rectangle(-20, 20, 20, 60)),
                         area("way 3", {{"building:part", "yes"}, {"height", "10"}}, rectangle(-20, 20, 20, 60)),
                         area("way 4", kTower, rectangle(-8, 32, 8, 48))}));
  EXPECT_TRUE(map.leftOut.empty()) << map.leftOut.text();
  ASSERT_EQ(map.buildings.size(), 1u);
  ASSERT_EQ(map.buildings[0].parts.size(), 2u);
  const Layout layout = layOut(map);
  ASSERT_EQ(layout.blocks.size(), 1u);
  const std::vector<models::Block>& parts = layout.blocks[0].block.parts;
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_DOUBLE_EQ(parts[0].height, 10);
  EXPECT_DOUBLE_EQ(parts[0].base, 0);
  EXPECT_EQ(parts[0].floors, 3);
  EXPECT_TRUE(parts[0].door);
  EXPECT_NEAR(areaOf(parts[0].outline), 1600, 2);
  EXPECT_DOUBLE_EQ(parts[1].height, 100);
  EXPECT_DOUBLE_EQ(parts[1].base, 10);
  EXPECT_FALSE(parts[1].door);
  EXPECT_NEAR(areaOf(parts[1].outline), 256, 1);
}

// A relation joins a part to its building wherever it is; a part outside of all buildings is a building.
TEST(MapBuildings, RelationsJoinParts) {
  const Map map = makeMap(
      withAreas({area("way 2", {{"building", "yes"}}, rectangle(0, 20, 20, 40), 7),
                 area("way 3", {{"building", "yes"}}, rectangle(30, 20, 50, 40)),
                 area("way 4", {{"building:part", "yes"}, {"height", "12"}}, rectangle(0, 20, 20, 40), 7),
                 area("way 5", {{"building:part", "yes"}, {"height", "12"}}, rectangle(32, 22, 40, 30), 7),
                 area("way 6", {{"building:part", "yes"}, {"building:levels", "3"}, {"building:min_level", "1"}},
                      rectangle(60, 20, 70, 30))}));
  ASSERT_EQ(map.buildings.size(), 3u);
  EXPECT_EQ(map.buildings[0].parts.size(), 2u);
  EXPECT_TRUE(map.buildings[1].parts.empty());
  EXPECT_NEAR(map.buildings[2].base, 2.9, 1e-9);
  EXPECT_THAT(map.buildings[2].top, Optional(DoubleNear(8.7, 1e-9)));
}

// Parts that cover half of an outline leave the other half as high as the building.
TEST(MapBuildings, TheRestOfAnOutlineIsBuiltBesideItsParts) {
  const Map map =
      makeMap(withAreas({area("way 2", {{"building", "yes"}, {"height", "9"}}, rectangle(0, 20, 40, 40)),
                         area("way 3", {{"building:part", "yes"}, {"height", "30"}}, rectangle(0, 20, 20, 40)),
                         area("way 4", {{"building:part", "yes"}}, rectangle(25, 25, 30, 30))}));
  ASSERT_EQ(map.buildings.size(), 1u);
  const std::vector<MapBuilding>& parts = map.buildings[0].parts;
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_THAT(parts[1].top, Optional(9)) << "as high as the building";
  EXPECT_THAT(parts[2].top, Optional(9));
  EXPECT_NEAR(areaOf(parts[2].outline), 400, 2);
  ASSERT_EQ(parts[2].courts.size(), 1u);
  EXPECT_NEAR(areaOf(parts[2].courts[0]), -25, 0.5) << "clockwise";
  EXPECT_THAT(map.leftOut.text(), HasSubstr("1 building outlines that their parts cover in part"));
}

// Points of a map are rounded to about a centimetre, so that a part at a wall of a turned outline leaves slivers.
TEST(MapBuildings, PartsAtTheEdgeOfATurnedOutlineLeaveItsRest) {
  // West, south, east and north sides of the parts, as shares of the outline.
  const std::vector<std::vector<std::array<double, 4>>> kinds = {{{-0.5, -0.5, -0.1, -0.1}},
                                                                 {{-0.2, -0.5, 0.2, -0.1}},
                                                                 {{-0.2, -0.5, 0.2, 0.5}},
                                                                 {{-0.5, -0.5, 0, 0.5}, {0, -0.25, 0.5, 0.25}}};
  Draw draw(1, models::Kind::House, 1);
  for (int i = 0; i < 80; ++i) {
    const double yaw = draw.in(-0.4, 0.4);
    const double width = draw.in(16, 26);
    const double depth = draw.in(12, 18);
    const auto turned = [&](std::vector<Point2> ring) {
      for (Point2& p : ring) {
        p = {p.x * width * std::cos(yaw) - p.y * depth * std::sin(yaw),
             35 + p.x * width * std::sin(yaw) + p.y * depth * std::cos(yaw)};
      }
      return ring;
    };
    const auto rounded = [](OsmArea a) {
      for (OsmNode& n : a.outer) n = {n.id, std::round(n.latitude * 1e7) / 1e7, std::round(n.longitude * 1e7) / 1e7};
      return a;
    };
    std::vector<OsmArea> areas{
        rounded(area("way 2", {{"building", "yes"}, {"height", "10"}}, turned(rectangle(-0.5, -0.5, 0.5, 0.5))))};
    for (const auto& [west, south, east, north] : kinds[static_cast<std::size_t>(i) % kinds.size()]) {
      areas.push_back(rounded(area("way 3", {{"building:part", "yes"}, {"height", "20"}, {"roof:shape", "flat"}},
                                   turned(rectangle(west, south, east, north)))));
    }
    const Map map = makeMap(withAreas(areas));
    ASSERT_EQ(map.buildings.size(), 1u);
    const MapBuilding& b = map.buildings[0];
    double built = 0;
    for (const MapBuilding& part : b.parts) {
      built += areaOf(part.outline);
      for (const Polygon& court : part.courts) built += areaOf(court);
    }
    EXPECT_NEAR(built, areaOf(b.outline), 0.02 * areaOf(b.outline)) << i;
    const Layout layout = layOut(map);
    ASSERT_EQ(layout.blocks.size(), 1u);
    SceneBuilder builder = labelledBuilder();
    const models::Block& block = layout.blocks[0].block;
    const auto [west, east] = std::minmax_element(block.outline.begin(), block.outline.end(),
                                                  [](const Point2& p, const Point2& q) { return p.x < q.x; });
    const auto [south, north] = std::minmax_element(block.outline.begin(), block.outline.end(),
                                                    [](const Point2& p, const Point2& q) { return p.y < q.y; });
    const Box bounds = models::makeBlock(builder, 1, block).bounds;
    EXPECT_GT(bounds.low.x, west->x - 1) << i;
    EXPECT_GT(bounds.low.y, south->y - 1) << i;
    EXPECT_LT(bounds.high.x, east->x + 1) << i;
    EXPECT_LT(bounds.high.y, north->y + 1) << i;
  }
}

TEST(MapBuildings, WhatHasNoHeightIsCounted) {
  const Map map = makeMap(withAreas(
      {area("way 2", {{"building", "yes"}, {"height", "5"}, {"min_height", "8"}}, rectangle(0, 20, 20, 40)),
       area("way 3", {{"building", "yes"}, {"height", "30 stories"}, {"width", "x"}}, rectangle(30, 20, 50, 40))}));
  EXPECT_EQ(map.buildings.size(), 1u);
  EXPECT_EQ(
      map.leftOut.text(),
      "1 buildings and building parts that are no higher than their min_height, 1 values of height that cannot be "
      "used, such as '30 stories' of way 3");
}

TEST(MapBuildings, RoofsThatTheirBuildingsDoNotAllowAreCounted) {
  const auto counted = [](Pairs tags) {
    tags.insert(tags.end(), {{"building", "yes"}, {"height", "10"}});
    return makeMap(withAreas({area("way 2", tags, rectangle(0, 20, 18, 30))})).leftOut.text();
  };
  const Pairs across{{"roof:shape", "hipped"}, {"roof:orientation", "across"}};
  EXPECT_THAT(counted(across), HasSubstr("1 hipped roofs with a ridge across"));
  EXPECT_EQ(counted({{"roof:shape", "hipped"}, {"roof:orientation", "along"}}), "");
  const char* const high = "1 roofs higher than their buildings";
  EXPECT_THAT(counted({{"roof:shape", "gabled"}, {"roof:height", "12"}}), HasSubstr(high));
  EXPECT_THAT(counted({{"roof:shape", "gabled"}, {"roof:angle", "80"}}), HasSubstr(high));
  EXPECT_EQ(counted({{"roof:shape", "gabled"}, {"roof:height", "10"}}), "");
}

TEST(MapBuildings, WoodsWithoutTreesAreTold) {
  const auto told = [](double north) {
    return printedBy([&] {
      (void)layOut(makeMap(withAreas({area("way 2", {{"landuse", "forest"}}, rectangle(-20, 10, 20, north))})));
    });
  };
  EXPECT_EQ(told(40), "");
  EXPECT_THAT(told(90), HasSubstr("woods farther than 48 m from every road have no trees"));
}

TEST(MapBuildings, AMainRoadThatABridgeInterruptsIsTold) {
  OsmExtract extract;
  for (const double from : {-200.0, 60.0}) {
    extract.ways.push_back(
        {{"way 1", {{"highway", "residential"}, {"name", "A"}}}, {{at(from, 0), at(from + 140, 0)}}});
  }
  EXPECT_THAT(printedBy([&] { (void)layOut(makeMap(extract)); }),
              HasSubstr("'A' is a main road of 140 m, less than `length: 200`"));
}

TEST(MapBuildings, MarkedCrossingsAreCounted) {
  OsmExtract extract = road();
  extract.points.push_back({at(5, 0), {"node 1", {{"highway", "crossing"}, {"crossing", "marked"}}}});
  extract.points.push_back({at(9, 0), {"node 2", {{"highway", "crossing"}, {"crossing", "unmarked"}}}});
  EXPECT_EQ(makeMap(extract).leftOut.text(), "1 marked crossings, which the seed draws");
}

// The ridge is along the longer side unless the map says otherwise; a skillion roof falls in its direction.
TEST(MapBuildings, RoofsHaveTheirShape) {
  const auto built = [](Pairs tags) {
    tags.insert(tags.end(), {{"building", "yes"}, {"height", "20"}, {"roof:height", "6"}});
    return makeMap(withAreas({area("way 2", tags, rectangle(-30, 20, 30, 60))})).buildings.at(0);
  };
  const auto reach = [](const MapBuilding& b) {
    return Point2{std::abs(b.ridge->at(1).x - b.ridge->at(0).x), std::abs(b.ridge->at(1).y - b.ridge->at(0).y)};
  };
  const MapBuilding gabled = built({{"roof:shape", "gabled"}});
  ASSERT_TRUE(gabled.ridge);
  EXPECT_NEAR(reach(gabled).x, 60, 0.1);
  EXPECT_NEAR(reach(gabled).y, 0, 0.1);
  EXPECT_THAT(gabled.eaves(), Optional(14));
  EXPECT_NEAR(reach(built({{"roof:shape", "gabled"}, {"roof:orientation", "across"}})).y, 40, 0.1);
  EXPECT_NEAR(reach(built({{"roof:shape", "hipped"}})).x, 20, 0.1);
  EXPECT_NEAR(reach(built({{"roof:shape", "pyramidal"}})).x, 0, 0.1);
  const MapBuilding skillion = built({{"roof:shape", "skillion"}, {"roof:direction", "W"}});
  EXPECT_NEAR(reach(skillion).y, 40, 0.1);
  EXPECT_NEAR(skillion.ridge->at(0).x, 30, 0.2) << "high in the east";
  EXPECT_EQ(skillion.roof, std::nullopt) << "houses have no such roof";
  EXPECT_FALSE(built({{"roof:shape", "flat"}}).ridge);
  // A block of the town has that roof.
  const Layout layout = layOut(makeMap(
      withAreas({area("way 2", {{"building", "yes"}, {"height", "20"}, {"roof:height", "6"}, {"roof:shape", "gabled"}},
                      rectangle(-30, 20, 30, 60))})));
  ASSERT_EQ(layout.blocks.size(), 1u);
  EXPECT_DOUBLE_EQ(layout.blocks[0].block.height, 14);
  EXPECT_DOUBLE_EQ(layout.blocks[0].block.rise, 6);
}

TEST(MapBuildings, AnglesOfRoofsGiveTheirHeight) {
  const auto built = [](Pairs tags) {
    tags.insert(tags.end(), {{"building", "yes"}, {"height", "20"}});
    return makeMap(withAreas({area("way 2", tags, rectangle(-30, 20, 30, 40))})).buildings.at(0);
  };
  EXPECT_NEAR(built({{"roof:shape", "gabled"}, {"roof:angle", "45"}}).rise, 10, 0.05);
  EXPECT_NEAR(built({{"roof:shape", "skillion"}, {"roof:angle", "30"}}).rise, 20 * std::tan(radians(30.0)), 0.05);
  EXPECT_NEAR(built({{"roof:shape", "gabled"}, {"roof:angle", "80"}}).rise, 20, 1e-9) << "no higher than the building";
  EXPECT_EQ(built({{"roof:shape", "gabled"}, {"roof:angle", "45"}, {"roof:height", "3"}}).rise, 3);
  EXPECT_EQ(built({{"roof:shape", "flat"}, {"roof:angle", "45"}}).rise, 0);
}

TEST(MapBuildings, HeightsHaveSeveralKeys) {
  const auto top = [](Pairs tags) {
    tags.emplace_back("building", "yes");
    return makeMap(withAreas({area("way 2", tags, rectangle(-30, 20, 30, 40))})).buildings.at(0).top;
  };
  EXPECT_EQ(top({{"est_height", "30"}}), 30);
  EXPECT_EQ(top({{"building:height", "25"}}), 25);
  EXPECT_EQ(top({{"est_height", "30"}, {"building:height", "25"}, {"height", "20"}}), 20);
}

// A corner that is cut out of a building stays open.
TEST(MapBuildings, NotchesAreNotFilled) {
  const Layout layout =
      layOut(makeMap(withAreas({area("way 2", {{"building", "house"}, {"height", "8"}},
                                     {{0, 12}, {10, 12}, {10, 20}, {2.5, 20}, {2.5, 17}, {0, 17}})})));
  EXPECT_TRUE(layout.houses.empty());
  ASSERT_EQ(layout.blocks.size(), 1u);
  EXPECT_EQ(layout.blocks[0].block.outline.size(), 6u);
}

TEST(MapBuildings, RoofsThatAreBuiltOtherwiseAreCounted) {
  const Map map =
      makeMap(withAreas({area("way 2", {{"building", "yes"}, {"roof:shape", "onion"}}, rectangle(0, 20, 10, 30)),
                         area("way 3", {{"building", "yes"}, {"roof:shape", "wavy"}}, rectangle(20, 20, 30, 30)),
                         area("way 4", {{"building", "yes"}, {"roof:shape", "gabled"}},
                              {{40, 20}, {60, 20}, {60, 30}, {50, 30}, {50, 40}, {40, 40}})}));
  EXPECT_EQ(map.leftOut.text(),
            "1 pitched roofs over outlines that are no rectangles, which are built flat, 1 roofs with an unknown "
            "roof:shape, which the seed draws, 1 roofs with roof:shape=onion, which are built pyramidal");
  EXPECT_THAT(map.buildings[2].roof, Optional(models::Roof::Flat));
}

// A gable roof of a house has its ridge along the longer side too, whichever side faces the road.
TEST(MapBuildings, TheRidgeOfAHouseIsAlongItsLongerSide) {
  const auto roofOf = [](const std::vector<Point2>& corners) {
    const Layout layout = layOut(makeMap(
        withAreas({area("way 2", {{"building", "house"}, {"height", "8"}, {"roof:shape", "gabled"}}, corners)})));
    return layout.houses.at(0).roof;
  };
  EXPECT_EQ(roofOf(rectangle(0, 12, 14, 20)), models::Roof::Gable);
  EXPECT_EQ(roofOf(rectangle(0, 12, 8, 26)), models::Roof::CrossGable);
}

// Roads may pass under a building that hangs; one that stands on a road is left out, which the town tells.
TEST(MapBuildings, MayHangOverRoads) {
  const auto layout = [](const Pairs& more) {
    Pairs tags{{"building", "yes"}, {"height", "12"}};
    tags.insert(tags.end(), more.begin(), more.end());
    return layOut(makeMap(withAreas({area("way 2", tags, rectangle(-5, -15, 5, 15))})));
  };
  const Layout bridge = layout({{"min_height", "6"}});
  ASSERT_EQ(bridge.blocks.size(), 1u);
  EXPECT_DOUBLE_EQ(bridge.blocks[0].block.base, 6);
  std::optional<Layout> blocked;
  EXPECT_THAT(printedBy([&] { blocked = layout({}); }), HasSubstr("left out: 1 buildings that stand on a road"));
  EXPECT_TRUE(blocked->blocks.empty());
  EXPECT_THAT(blocked->about, HasSubstr("1 buildings that stand on a road are left out"));
}

}  // namespace
}  // namespace scanmill::town
