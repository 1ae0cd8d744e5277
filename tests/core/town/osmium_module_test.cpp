#include <fmt/format.h>

#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"
#include "town/map.h"

namespace scanmill::town {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// A node `x` metres east and `y` metres north of a place.
std::string node(int id, double x, double y, const std::string& more = "") {
  return fmt::format("<node id='{}' lat='{:.7f}' lon='{:.7f}' {}/>", id, 51 + y / 111250, 0.5 + x / 70200, more);
}

std::string way(int id, const std::vector<int>& nodes, const std::vector<std::pair<const char*, const char*>>& tags,
                const std::string& more = "") {
  std::string text = fmt::format("<way id='{}' {}>", id, more);
  for (const int n : nodes) text += fmt::format("<nd ref='{}'/>", n);
  for (const auto& [key, value] : tags) text += fmt::format("<tag k='{}' v='{}'/>", key, value);
  return text + "</way>";
}

const std::string kRoadNodes = node(1, -150, 0) + node(2, 0, 0) + node(3, 150, 0);
const std::string kRoad = way(10, {1, 2, 3}, {{"highway", "residential"}});
const std::string kHouseNodes = node(4, 0, 20) + node(5, 30, 20) + node(6, 30, 50) + node(7, 0, 50);
const std::string kHouse = way(11, {4, 5, 6, 7, 4}, {{"building", "yes"}});
const std::string kCourtNodes = node(20, 10, 30) + node(21, 20, 30) + node(22, 20, 40) + node(23, 10, 40);

// Returns elements in the order of a sorted file.
std::string sorted(const std::string& elements) {
  std::multimap<std::pair<int, int>, std::string> byOrder;
  for (std::size_t at = 0, end = 0; at < elements.size(); at = end) {
    const int type = elements.compare(at, 5, "<node") == 0 ? 0 : elements.compare(at, 4, "<way") == 0 ? 1 : 2;
    const std::string closing = type == 1 ? "</way>" : type == 2 ? "</relation>" : "</node>";
    const std::size_t bracket = elements.find('>', at);
    end = elements[bracket - 1] == '/' ? bracket + 1 : elements.find(closing, at) + closing.size();
    const int id = std::stoi(elements.substr(elements.find("id='", at) + 4));
    byOrder.emplace(std::pair(type, id), elements.substr(at, end - at));
  }
  std::string all;
  for (const auto& [order, element] : byOrder) all += element;
  return all;
}

class ReadOsm : public testing::Test {
 protected:
  Map read(const std::string& elements) { return readAs(sorted(elements)); }
  Map readAs(const std::string& elements, const std::string& name = "place.osm", const char* root = "osm") {
    return readMap(folder_.write(name, fmt::format("<{0} version='0.6'>{1}</{0}>", root, elements)), false, {});
  }

  TemporaryFolder folder_;
};

TEST_F(ReadOsm, FilesInAnotherFormAreRefusedWithAWayOn) {
  struct Case {
    std::string elements, words;
    const char* name = "place.osm";
    const char* root = "osm";
  };
  const std::string deleted = way(11, {1, 3}, {{"barrier", "wall"}}, "action='delete' visible='true'");
  for (const Case& c :
       {Case{kRoad + kRoadNodes, "Found a node after a way. Sort it by `osmium sort`"},
        {kRoadNodes + node(2, 1, 1) + kRoad, "Node IDs out of order: 2 Sort it"},
        {kRoadNodes + node(3, 1, 1) + kRoad, "Node ID twice in input."},
        {kRoadNodes + kRoad, "`osmium time-filter`", "place.osh"},
        {"<modify>" + kRoadNodes + kRoad + "</modify>", "osmium apply-changes", "place.osc", "osmChange"},
        {kRoadNodes + kRoad + deleted, "purge these objects"},
        {kRoadNodes + "<way id='10'><nd ref='1'/><tag k='highway' v='road'/><nd ref='2'/></way>",
         "way 10 has tags between its nodes"},
        {kRoadNodes + "<way id='10'><center lat='51' lon='0.5'/></way>", "(._;>;); out meta;"},
        {kRoad, "no road for cars, such as a way with the tag highway=residential; left out: 1 roads with missing"}}) {
    EXPECT_THAT(messageOf([&] { readAs(c.elements, c.name, c.root); }), AllOf(HasSubstr(c.name), HasSubstr(c.words)));
  }
  folder_.write("place.json", "{}");
  EXPECT_THAT(messageOf([&] { readMap(folder_.path() / "place.json", false, {}); }), HasSubstr("[out:xml]"));
}

// A building whose relation and outer way both have the key building is built once, with its court.
TEST_F(ReadOsm, ABuildingIsNotBuiltTwice) {
  const Map map = read(kRoadNodes + kHouseNodes + kCourtNodes + kRoad + kHouse + way(12, {20, 21, 22, 23, 20}, {}) +
                       "<relation id='30'><member type='way' ref='11' role='outer'/><member type='way' ref='12' "
                       "role='inner'/><tag k='type' v='multipolygon'/><tag k='building' v='yes'/></relation>");
  ASSERT_EQ(map.buildings.size(), 1u);
  EXPECT_EQ(map.buildings[0].courts.size(), 1u);
  EXPECT_EQ(map.leftOut.text(), "1 buildings that are the outlines of relations with the key building");
}

TEST_F(ReadOsm, DeletedElementsAreNotBuilt) {
  const std::string start = kRoadNodes + kHouseNodes + kRoad;
  EXPECT_EQ(read(start + kHouse).buildings.size(), 1u);
  const Map map = read(start + way(11, {4, 5, 6, 7, 4}, {{"building", "yes"}}, "visible='false'"));
  EXPECT_TRUE(map.buildings.empty());
}

// Ways are built as far as their nodes are in the file, and buildings are left out; both are counted.
TEST_F(ReadOsm, MissingNodesAreCounted) {
  const Map map =
      read(kRoadNodes + node(40, 250, 0) + kHouseNodes + way(10, {1, 2, 3, 99, 40, 4}, {{"highway", "residential"}}) +
           way(11, {4, 5, 98, 4}, {{"building", "yes"}}) + way(12, {4, 5, 6, 97, 4}, {{"landuse", "forest"}}) +
           way(13, {4, 5, 6}, {{"building", "yes"}}) +
           "<relation id='30'><member type='way' ref='96' role='outer'/><tag k='type' v='multipolygon'/>"
           "<tag k='natural' v='water'/></relation>");
  double metres = 0;
  for (const MapRoad& road : map.roads) metres += road.length();
  EXPECT_NEAR(metres, 300 + std::hypot(250, 20), 1) << "nothing leads across the missing node";
  EXPECT_TRUE(map.buildings.empty());
  EXPECT_EQ(
      map.leftOut.text(),
      "1 areas of land with missing nodes, 1 areas of land with missing ways, 1 buildings with an outline that is "
      "not closed or crosses itself, 1 buildings with missing nodes, 1 roads with missing nodes, which are built "
      "in part");
}

// What is not on the ground, or is nothing that the town builds, is counted in one text.
TEST_F(ReadOsm, WhatIsLeftOutIsCounted) {
  const std::vector<int> square{4, 5, 6, 7, 4};
  const Map map = read(
      kRoadNodes + kHouseNodes + kRoad + way(12, {1, 4}, {{"highway", "primary"}, {"tunnel", "yes"}}) +
      way(13, {1, 4}, {{"highway", "footway"}, {"layer", "-1"}}) + way(14, {1, 4}, {{"highway", "pedestrian"}}) +
      way(15, {1, 4}, {{"highway", "construction"}}) + way(16, {1, 4}, {{"highway", "boulevard"}}) +
      way(17, {1, 4}, {{"railway", "tram"}}) + way(18, {1, 4}, {{"barrier", "guard_rail"}}) +
      way(19, square, {{"building", "yes"}, {"location", "underground"}}) + way(20, square, {{"building", "carport"}}) +
      way(21, square, {{"building", "demolished"}}) + way(22, square, {{"building", "no"}}) +
      way(23, square, {{"disused:building", "yes"}}) + way(24, square, {{"natural", "sand"}}) +
      way(25, square, {{"landuse", "residential"}}) + way(26, {1, 4}, {{"natural", "tree_row"}}) +
      way(27, {1, 4}, {{"waterway", "drain"}, {"tunnel", "culvert"}}) + way(28, {63, 4}, {{"barrier", "fence"}}) +
      "<node id='63' lat='51' lon='0.5'><tag k='ele' v='120'/></node>"
      "<node id='60' lat='51' lon='0.5'><tag k='highway' v='street_lamp'/></node>"
      "<node id='61' lat='51' lon='0.5'><tag k='building' v='yes'/></node>"
      "<node id='62' lat='51' lon='0.5'><tag k='addr:street' v='Mill Road'/></node>");
  EXPECT_TRUE(map.buildings.empty());
  EXPECT_EQ(map.roads.size(), 1u);
  EXPECT_EQ(map.leftOut.text(),
            "1 barrier=guard_rail, 1 buildings on bridges, in tunnels, indoors or underground, 1 buildings that are "
            "nodes, 1 heights of nodes (ele), 1 highway=boulevard, 1 highway=pedestrian, 1 highway=street_lamp, 1 "
            "natural=sand, 1 natural=tree_row, 1 open roofs and carports, 1 paths on bridges, in tunnels, indoors or "
            "underground, 1 railway=tram, 1 roads on bridges, in tunnels, indoors or underground");
}

std::string relation(const std::vector<std::pair<int, const char*>>& ways,
                     const std::vector<std::pair<const char*, const char*>>& tags) {
  std::string text = "<relation id='30'>";
  for (const auto& [id, role] : ways) text += fmt::format("<member type='way' ref='{}' role='{}'/>", id, role);
  text += "<tag k='type' v='multipolygon'/>";
  for (const auto& [key, value] : tags) text += fmt::format("<tag k='{}' v='{}'/>", key, value);
  return text + "</relation>";
}

const std::vector<int> kRingNodes{4, 5, 6, 7, 4};

// Until 2017 the tags of a multipolygon stood on its outer ways.
TEST_F(ReadOsm, RelationsWithoutTagsOfAnAreaAreCounted) {
  const Map map = read(kRoadNodes + kHouseNodes + kCourtNodes + kRoad + way(12, {20, 21, 22, 23, 20}, {}) + kHouse +
                       relation({{11, "outer"}, {12, "inner"}}, {{"source", "Bing"}}));
  ASSERT_EQ(map.buildings.size(), 1u);
  EXPECT_TRUE(map.buildings[0].courts.empty());
  EXPECT_EQ(map.leftOut.text(), "1 multipolygons without a tag of an area, whose holes are not built");
}

TEST_F(ReadOsm, BuildingsOfRelationsHaveTheHeightOfTheirOuterWay) {
  const std::string start = kRoadNodes + kHouseNodes + kRoad;
  const auto top = [&](const std::vector<std::pair<const char*, const char*>>& outer,
                       const std::vector<std::pair<const char*, const char*>>& own) {
    return read(start + way(11, kRingNodes, outer) + relation({{11, "outer"}}, own)).buildings.at(0).top;
  };
  EXPECT_EQ(top({{"height", "20"}}, {{"building", "yes"}}), 20);
  EXPECT_EQ(top({{"height", "20"}}, {{"building", "yes"}, {"height", "8"}}), 8);
  EXPECT_EQ(top({{"height", "2"}, {"barrier", "wall"}}, {{"building", "yes"}}), std::nullopt) << "of the wall";
  const Map map =
      read(start + node(24, 100, 30) + node(25, 120, 30) + node(26, 120, 40) + way(11, kRingNodes, {{"height", "20"}}) +
           way(12, {24, 25, 26, 24}, {{"height", "30"}, {"building:levels", "9"}}) +
           relation({{11, "outer"}, {12, "outer"}}, {{"building", "yes"}}));
  EXPECT_EQ(map.buildings.size(), 2u);
  EXPECT_EQ(map.leftOut.text(), "1 heights and roofs of outer ways that differ from those of their multipolygon");
}

TEST_F(ReadOsm, LandIsBuilt) {
  const auto land = [&](const std::vector<std::pair<const char*, const char*>>& tags, bool asRelation) {
    const Map map =
        read(kRoadNodes + kHouseNodes + kRoad +
             (asRelation ? way(11, kRingNodes, {}) + relation({{11, "outer"}}, tags) : way(11, kRingNodes, tags)));
    EXPECT_EQ(map.roads.size(), 1u);
    EXPECT_TRUE(map.paths.empty());
    EXPECT_EQ(map.leftOut.text(), "");
    if (map.areas.size() != 1) return std::optional<Land>();
    return std::optional(map.areas[0].land);
  };
  for (const char* highway : {"residential", "track", "cycleway", "service", "pedestrian"}) {
    EXPECT_EQ(land({{"highway", highway}, {"area", "yes"}}, false), Land::Paved) << highway;
    EXPECT_EQ(land({{"highway", highway}}, true), Land::Paved) << highway;
  }
  EXPECT_EQ(land({{"landcover", "trees"}}, false), Land::Wood);
  EXPECT_EQ(land({{"aeroway", "apron"}}, false), Land::Paved);
  EXPECT_EQ(land({{"aeroway", "runway"}, {"area", "yes"}}, false), Land::Paved);
  EXPECT_EQ(land({{"amenity", "fuel"}}, false), Land::Paved);
  EXPECT_EQ(land({{"waterway", "riverbank"}}, false), Land::Water);
  EXPECT_EQ(land({{"waterway", "dock"}}, true), Land::Water);
  EXPECT_EQ(land({{"amenity", "parking"}, {"parking", "street_side"}}, false), Land::Lot);
}

TEST_F(ReadOsm, SizesAreRead) {
  const Map map = read(kRoadNodes + kHouseNodes + kCourtNodes +
                       way(10, {1, 2, 3}, {{"highway", "residential"}, {"est_width", "9"}}) +
                       way(11, {4, 5}, {{"barrier", "wall"}, {"height", "16 ft"}}) +
                       way(12, {5, 6}, {{"highway", "footway"}, {"width", "4"}}) + way(13, {20, 21, 22, 23, 20}, {}) +
                       relation({{13, "outer"}}, {{"barrier", "hedge"}}) +
                       "<node id='60' lat='51' lon='0.5'><tag k='natural' v='tree'/><tag k='height' v='25 m'/>"
                       "<tag k='diameter_crown' v='12'/></node>");
  EXPECT_EQ(map.roads.at(0).width, 9);
  ASSERT_EQ(map.barriers.size(), 1u);
  EXPECT_NEAR(map.barriers[0].height.value_or(0), 4.8768, 1e-9);
  ASSERT_EQ(map.paths.size(), 1u);
  EXPECT_EQ(map.paths[0].width, 4);
  ASSERT_EQ(map.trees.size(), 1u);
  EXPECT_EQ(map.trees[0].height, 25);
  EXPECT_EQ(map.trees[0].crown, 12);
  EXPECT_EQ(map.leftOut.text(), "1 barrier=hedge") << "of the relation";
}

// Whatever has a shape and is not built is counted; names and properties are not.
TEST_F(ReadOsm, EveryShapeThatIsNotBuiltIsCounted) {
  const auto counted = [&](const std::string& element) {
    return read(kRoadNodes + kHouseNodes + kRoad + element).leftOut.text();
  };
  const auto node = [](const std::string& tag) {
    const std::size_t sign = tag.find('=');
    return fmt::format("<node id='60' lat='51' lon='0.5'><tag k='{}' v='{}'/></node>", tag.substr(0, sign),
                       tag.substr(sign + 1));
  };
  for (const std::string tag :
       {"power=generator", "traffic_sign=DE:250", "tourism=artwork", "highway=traffic_signals", "natural=wood",
        "amenity=telephone", "railway=signal", "traffic_calming=bump", "emergency=fire_hydrant"}) {
    EXPECT_EQ(counted(node(tag)), "1 " + tag);
  }
  for (const std::string tag : {"railway=level_crossing", "place=square", "tourism=hotel", "natural=peak",
                                "highway=crossing", "leisure=sports_centre", "amenity=school"}) {
    EXPECT_EQ(counted(node(tag)), "") << tag;
  }
  for (const auto& [key, value] : std::vector<std::pair<const char*, const char*>>{{"landuse", "vineyard"},
                                                                                   {"landcover", "gravel"},
                                                                                   {"waterway", "dam"},
                                                                                   {"aeroway", "hangar"},
                                                                                   {"area:highway", "primary"},
                                                                                   {"place", "square"},
                                                                                   {"public_transport", "platform"},
                                                                                   {"parking", "rooftop"}}) {
    const std::string words = fmt::format("1 {}={}", key, value);
    EXPECT_EQ(counted(way(11, kRingNodes, {{key, value}})), words);
    EXPECT_EQ(counted(way(11, kRingNodes, {}) + relation({{11, "outer"}}, {{key, value}})), words) << "relation";
  }
  EXPECT_EQ(counted(way(11, kRingNodes, {}) + relation({{11, "outer"}}, {{"leisure", "park"}, {"barrier", "fence"}})),
            "1 barrier=fence")
      << "a relation that is land, too";
  EXPECT_EQ(counted(way(11, {4, 5}, {{"man_made", "pipeline"}, {"location", "underground"}})), "");
  EXPECT_EQ(counted(way(11, {4, 5}, {{"highway", "footway"}, {"footway", "sidewalk"}, {"traffic_sign", "DE:240"}})),
            "");
  EXPECT_EQ(counted(way(11, {4, 5}, {{"natural", "water"}}) + way(12, {5, 6, 7, 4}, {{"natural", "water"}}) +
                    relation({{11, "outer"}, {12, "outer"}}, {{"natural", "water"}})),
            "")
      << "pieces of the outline";
}

TEST_F(ReadOsm, WhatTheMapSaysOfLooksAndStatesIsCounted) {
  using Tags = std::vector<std::pair<const char*, const char*>>;
  const std::string surface =
      "1 surfaces of roads, paths and paved areas, such as gravel, which are built of asphalt, concrete or paving";
  const std::string looks =
      "1 buildings with materials, colours or a state, such as ruins, which the seed draws as if whole";
  const std::string sides = "1 roads with sidewalks, parking, cycleways or embankments that differ from the town's";
  const std::string hollow = "1 hedges, walls and fences that are areas, of which only the outlines are built";
  // Tags of a road, of a path and of a closed outline.
  for (const auto& [tags, words] : std::vector<std::pair<Tags, std::string>>{
           {{{"parking:lane:left", "parallel"}, {"parking:lane:right", "no_parking"}}, sides},
           {{{"sidewalk:left", "yes"}}, sides},
           {{{"parking:left", "lane"}, {"parking:right", "no"}}, sides},
           {{{"sidewalk:left", "yes"}, {"sidewalk:right", "separate"}, {"parking:both", "no"}}, ""},
           {{{"parking:lane:both", "perpendicular"}}, sides},
           {{{"parking:both", "sometimes"}, {"parking:condition:both", "free"}}, sides},
           {{{"surface", "asphalt"}}, ""},
           {{{"surface", "cobblestone"}}, surface},
           {{{"tracktype", "grade3"}}, surface},
           {{{"tracktype", "grade3"}, {"surface", "asphalt"}}, ""},
           {{{"cycleway", "separate"}, {"cycleway:both", "no"}}, ""},
           {{{"cycleway:right", "track"}}, sides},
           {{{"driving_side", "right"}}, ""},
           {{{"driving_side", "left"}}, "1 roads on which traffic keeps to the other side than in the town"},
           {{{"railway", "tram"}}, "1 railway=tram"},
           {{{"railway", "abandoned"}}, ""},
           {{{"embankment", "yes"}}, sides}}) {
    Tags all = tags;
    all.emplace_back("highway", "residential");
    EXPECT_EQ(read(kRoadNodes + way(10, {1, 2, 3}, all)).leftOut.text(), words) << tags[0].first;
  }
  EXPECT_EQ(read(kRoadNodes + kHouseNodes + kRoad + way(11, {4, 5}, {{"highway", "path"}, {"surface", "ground"}}))
                .leftOut.text(),
            surface);
  for (const auto& [tags, words] :
       std::vector<std::pair<Tags, std::string>>{{{{"amenity", "parking"}, {"surface", "gravel"}}, surface},
                                                 {{{"amenity", "parking"}, {"surface", "paving_stones"}}, ""},
                                                 {{{"leisure", "pitch"}, {"surface", "grass"}}, ""},
                                                 {{{"building", "yes"}, {"name", "x"}}, ""},
                                                 {{{"building", "yes"}, {"roof:colour", "red"}}, looks},
                                                 {{{"building", "construction"}}, looks},
                                                 {{{"building", "yes"}, {"abandoned", "yes"}}, looks},
                                                 {{{"building", "yes"}, {"wall", "no"}}, "1 open roofs and carports"},
                                                 {{{"barrier", "wall"}}, ""},
                                                 {{{"barrier", "hedge"}, {"area", "yes"}}, hollow}}) {
    EXPECT_EQ(read(kRoadNodes + kHouseNodes + kRoad + way(11, kRingNodes, tags)).leftOut.text(), words)
        << tags[0].second;
  }
}

TEST_F(ReadOsm, OuterRingsOfARelationAreOneBuilding) {
  const std::string other = node(24, 50, 20) + node(25, 60, 20) + node(26, 60, 30) + way(12, {24, 25, 26, 24}, {});
  const std::string start = kRoadNodes + kHouseNodes + other + kRoad + way(11, kRingNodes, {});
  const auto relations = [&](const std::vector<std::pair<int, const char*>>& rings) {
    std::vector<std::int64_t> ids;
    for (const MapBuilding& b : read(start + relation(rings, {{"building", "yes"}})).buildings) {
      ids.push_back(b.relation);
    }
    return ids;
  };
  EXPECT_THAT(relations({{11, "outer"}, {12, "outer"}}), testing::ElementsAre(30, 30));
  EXPECT_THAT(relations({{11, "outer"}}), testing::ElementsAre(0));
}

// A .pbf file of one header, in a blob that is compressed by LZ4: 16 bytes that are copied.
TEST_F(ReadOsm, BlobsMayBeCompressedByLz4) {
  const std::string header = std::string("\x22\x0e") + "OsmSchema-V0.6";
  const std::string blob = std::string("\x10\x10\x32\x12\xf0\x01") + header;
  const auto path =
      folder_.write("lz4.osm.pbf", std::string("\0\0\0\x0d\x0a\x09", 6) + "OSMHeader" + "\x18\x16" + blob);
  EXPECT_THAT(messageOf([&] { readMap(path, false, {}); }), HasSubstr("has no road for cars"));
}

}  // namespace
}  // namespace scanmill::town
