#include <fmt/format.h>

#include <map>
#include <set>

#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scene.h"
#include "tests/support/town.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsSupersetOf;

// A street on a map to which tests add nodes, ways and relations, and nothing that the seed places on its lawns.
class StreetOnAMap {
 public:
  explicit StreetOnAMap(const std::string& tags = "") {
    way({{-102, 0}, {0, 0}, {102, 0}}, "<tag k='highway' v='residential'/>" + tags);
  }
  // Returns the id of the node.
  int node(const town::Point2& at, const std::string& tags = "") {
    nodes_ += fmt::format("<node id='{}' lat='{:.9f}' lon='{:.9f}'>{}</node>", ++id_, 51 + at.y / 111250,
                          0.5 + at.x / 70200, tags);
    return id_;
  }
  // Returns the id of the way. The last point of a closed way is the first.
  int way(const std::vector<town::Point2>& points, const std::string& tags) {
    std::string refs;
    const int first = id_ + 1;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const bool closes = i > 0 && town::distance(points[i], points[0]) == 0;
      refs += fmt::format("<nd ref='{}'/>", closes ? first : node(points[i]));
    }
    add(fmt::format("<way id='{}'>{}{}</way>", ++id_, refs, tags));
    return id_;
  }
  void add(const std::string& element) { behindNodes_ += element; }
  Scene scene(const std::string& keys = kBare) const { return makeTown(yaml(keys), 1); }
  town::Parameters parameters() const {
    const Value value = parseYaml(yaml(kBare), "town.yaml");
    Fields fields(value, "town");
    return town::readParameters(fields);
  }
  town::Map map() const { return town::readMap(write(), false, {}); }
  // Returns the part of the map around the town of seed 1, in the town's frame.
  town::MapPlace place() const { return town::cutOut(map(), parameters(), 1, 150, {}); }

 private:
  static constexpr const char* kBare = "greenery: 0, people: 0, vehicles: 0, traffic: 0, detail: 0.05";

  std::string yaml(const std::string& keys) const {
    return fmt::format("{{map: {}, length: 200, slope: 0, {}}}", write().string(), keys);
  }
  std::filesystem::path write() const {
    return folder_.write("street.osm", "<osm version='0.6'>" + nodes_ + behindNodes_ + "</osm>");
  }

  TemporaryFolder folder_;
  std::string nodes_;
  std::string behindNodes_;
  int id_ = 0;
};

// Walls and trees are as high as the map says, crowns and paths as wide.
TEST(Town, SizesOfTheMapAreBuilt) {
  StreetOnAMap street;
  street.node({0, 30}, "<tag k='natural' v='tree'/><tag k='height' v='21'/><tag k='diameter_crown' v='5'/>");
  street.way({{-30, 40}, {30, 40}}, "<tag k='barrier' v='wall'/><tag k='height' v='5'/>");
  street.way({{-30, 50}, {30, 50}}, "<tag k='highway' v='footway'/><tag k='width' v='4'/>");
  const Scene scene = street.scene();
  const auto boxOf = [&](const std::string& name) {
    Box box;
    forPoints(scene, [&](const Instance& i, const Vec3d& p) {
      if (i.name == name) box.add(p);
    });
    return box;
  };
  const Box tree = boxOf("tree 1");
  EXPECT_NEAR(tree.high.z, 21, 0.5);
  EXPECT_NEAR((tree.high.x - tree.low.x + tree.high.y - tree.low.y) / 2, 5, 1.5);
  const Box panel = boxOf("boundary 1");
  const town::Layout layout{street.parameters(), 1, street.place()};
  EXPECT_NEAR(panel.high.z, layout.heightAt({panel.center().x, panel.center().y}) + 5, 0.1);
  EXPECT_TRUE(std::any_of(layout.patches.begin(), layout.patches.end(), [](const town::Patch& patch) {
    return patch.kind == town::GroundKind::Path && patch.rectangle.halfY == 2;
  }));
}

TEST(Town, TreesAndShortWallsOfTheMapAreBuilt) {
  StreetOnAMap street("<tag k='width' v='6'/><tag k='sidewalk' v='no'/><tag k='parking:both' v='no'/>");
  for (const double west : {-60.0, -56.0, -52.0, -48.0, -44.0}) {
    street.way({{west, 12}, {west + 0.9, 12}}, "<tag k='barrier' v='wall'/>");
  }
  for (int k = 0; k < 40; ++k) {
    street.node({-78.0 + 4 * k, k % 2 == 0 ? 4.5 : -5.5}, "<tag k='natural' v='tree'/><tag k='diameter_crown' v='3'/>");
  }
  std::set<std::string> built;
  for (const Instance& i : street.scene("detail: 0.1").instances) built.insert(i.name);
  for (int k = 1; k <= 40; ++k) EXPECT_TRUE(built.contains(fmt::format("tree {}", k))) << k;
  for (int k = 1; k <= 5; ++k) EXPECT_TRUE(built.contains(fmt::format("boundary {}", k))) << k;
}

// No point of a barrier is farther from its pieces than half of their thickness, whatever its corners are.
TEST(Town, BarriersOfTheMapHaveNoGaps) {
  StreetOnAMap street;
  const auto barrier = [&](const std::vector<town::Point2>& points, const std::string& kind) {
    street.way(points, fmt::format("<tag k='barrier' v='{}'/>", kind));
  };
  double west = -95;
  for (const char* kind : {"wall", "fence", "hedge"}) {
    for (const double turn : {20.0, 60.0, 90.0, 130.0, 170.0}) {
      const double a = turn * kPi / 180;
      barrier({{west, 40}, {west, 47.3}, {west + 5.9 * std::sin(a), 47.3 + 5.9 * std::cos(a)}}, kind);
      west += 7;
    }
  }
  barrier({{-60, 60}, {-20, 60}, {-20, 70}, {-60, 70}, {-60, 60}}, "wall");
  barrier({{-55, 60}, {-55, 70}}, "wall");  // between two sides of the ring
  barrier({{0, 60}, {31.3, 60}, {7, 68.8}, {0, 60}}, "hedge");
  std::vector<town::Point2> arc;
  for (int k = 0; k <= 60; ++k) arc.push_back({50 + 4 * std::cos(k * kPi / 60), 60 + 4 * std::sin(k * kPi / 60)});
  barrier(arc, "wall");
  const Scene scene = street.scene();
  std::vector<std::pair<const Instance*, Box>> pieces;
  for (const Instance& i : scene.instances) {
    if (!i.name.starts_with("boundary")) continue;
    Box box;
    for (const Vec3f& p : scene.meshes[i.mesh].positions) box.add(Vec3d(p));
    pieces.emplace_back(&i, box);
  }
  const std::vector<town::MapBarrier> barriers = street.place().barriers;
  ASSERT_EQ(barriers.size(), 19u);
  for (const town::MapBarrier& b : barriers) {
    for (double along = 0; along < town::lengthOf(b.line); along += 0.05) {
      const town::Point2 p = town::pointAt(b.line, along);
      double outside = 1e9;  // m beyond half of the thickness of the nearest piece
      for (const auto& [piece, box] : pieces) {
        const Affine& world = piece->worldFromMesh;
        const double length = std::hypot(world.linear.x.x, world.linear.x.y);
        const double x = p.x - world.translation.x;
        const double y = p.y - world.translation.y;
        const double u = (x * world.linear.x.x + y * world.linear.x.y) / length;
        const double v = x * world.linear.y.x + y * world.linear.y.y;
        const double aside = std::max({0.0, box.low.y - v, v - box.high.y});
        const double ahead = std::max({0.0, box.low.x * length - u, u - box.high.x * length});
        outside = std::min(outside, std::hypot(ahead, aside) - (box.high.y - box.low.y) / 2);
      }
      ASSERT_LE(outside, 0) << "at " << p.x << " " << p.y;
    }
  }
}

// Two gardens share a fence: it is built once.
TEST(Town, BarriersThatTheMapHasTwiceAreBuiltOnce) {
  const auto pieces = [](bool twice) {
    StreetOnAMap street;
    street.way({{-20, 40}, {20, 40}}, "<tag k='barrier' v='wall'/>");
    if (twice) street.way({{20, 40}, {-20, 40}}, "<tag k='barrier' v='wall'/>");
    const Scene scene = street.scene();
    return std::count_if(scene.instances.begin(), scene.instances.end(), [](const Instance& i) {
      return i.name.starts_with("boundary") && std::abs(i.worldFromMesh.translation.y - 40) < 1;
    });
  };
  EXPECT_EQ(pieces(false), 20) << "40 m in pieces of 2 m";
  EXPECT_EQ(pieces(true), 20);
}

TEST(Town, PiecesOfBarriersThatRoadsCrossAreTold) {
  StreetOnAMap street;
  const auto told = [&] { return printedBy([&] { (void)street.scene(); }); };
  street.way({{20, 30}, {20, 40}}, "<tag k='barrier' v='wall'/>");
  EXPECT_EQ(told(), "");
  street.way({{40, -30}, {40, 40}}, "<tag k='barrier' v='wall'/>");
  EXPECT_THAT(told(), HasSubstr("left out: pieces of walls, fences and hedges where the town has roads"));
}

// A relation with two outer rings is one building, and one thing: as houses and as blocks.
TEST(Town, RingsOfOneBuildingAreOneThing) {
  for (const double depth : {8.0, 30.0}) {
    StreetOnAMap street;
    std::string members;
    for (const double x : {-30.0, 10.0}) {
      const int ring = street.way({{x, 20}, {x + 20, 20}, {x + 20, 20 + depth}, {x, 20 + depth}, {x, 20}}, "");
      members += fmt::format("<member type='way' ref='{}' role='outer'/>", ring);
    }
    street.way({{60, 20}, {80, 20}, {80, 50}, {60, 50}, {60, 20}}, "<tag k='building' v='yes'/>");
    street.add("<relation id='7'>" + members +
               "<tag k='type' v='multipolygon'/><tag k='building' v='school'/></relation>");
    const Scene scene = street.scene();
    std::map<std::uint32_t, int> placed;
    for (const Instance& i : scene.instances) {
      if (i.name.starts_with("block") || (i.name.starts_with("house") && !i.name.ends_with("plinth"))) {
        ++placed[i.firstInstanceId];
      }
    }
    std::vector<int> counts;
    for (const auto& [id, count] : placed) counts.push_back(count);
    std::sort(counts.begin(), counts.end());
    EXPECT_THAT(counts, testing::ElementsAre(1, 2)) << depth;
  }
}

// Roads, buildings and land are the map's, whatever the seed that dresses them.
TEST(Town, StandsWhereTheMapSays) {
  const Value value = parseYaml(onMap("road: Mill Road"), "town.yaml");
  Fields fields(value, "town");
  const town::Parameters parameters = town::readParameters(fields);
  const town::MapPlace place = town::cutOut(town::readMap(parameters.map, false, {}), parameters, 1, 280, {});
  const town::Layout one(parameters, 1, place);
  const town::Layout two(parameters, 2, place);
  EXPECT_GE(one.houses.size(), 20u);
  EXPECT_GE(one.blocks.size(), 3u);
  ASSERT_EQ(one.houses.size(), two.houses.size());
  std::size_t inside = 0;
  for (std::size_t i = 0; i < one.houses.size(); ++i) {
    const models::House& a = one.houses[i];
    const models::House& b = two.houses[i];
    EXPECT_NEAR(std::hypot(a.pose.translation.x - b.pose.translation.x, a.pose.translation.y - b.pose.translation.y), 0,
                4)
        << "the same rectangle, perhaps with its front to another road";
    const Vec3d middle = a.pose * Vec3d{a.width / 2, a.depth / 2, 0};
    for (const town::MapBuilding& building : place.buildings) {
      inside += town::isInside({&building.outline}, {middle.x, middle.y}) ? 1 : 0;
    }
  }
  EXPECT_EQ(inside, one.houses.size());
  EXPECT_EQ(one.areas.list().size(), two.areas.list().size());
  ASSERT_EQ(one.roads().size(), two.roads().size());
  for (std::size_t r = 0; r < one.roads().size(); ++r) {
    EXPECT_EQ(one.roads()[r].length(), two.roads()[r].length());
  }
}

TEST(Town, OnAMapHasWhatTheMapHas) {
  const std::string yaml = onMap("road: Mill Road, length: 300, detail: 0.1");
  const Scene one = makeTown(yaml, 1);
  EXPECT_EQ(hash(one), hash(makeTown(yaml, 1)));
  EXPECT_NE(hash(one), hash(makeTown(yaml, 2)));
  EXPECT_THAT(classesOf(one),
              IsSupersetOf({"building", "window", "road", "sidewalk", "parking", "water", "tree", "car"}));
  std::size_t parked = 0;
  for (const Instance& i : one.instances) parked += i.name.starts_with("car on a lot") ? 1 : 0;
  EXPECT_GT(parked, 3u);
  EXPECT_THAT(one.about, AllOf(HasSubstr("'Mill Road'"), testing::ContainsRegex("at (50[.]99|51[.]00)[0-9]*, 0[.]50")));
}

TEST(Town, RefusesMapsThatItCannotUse) {
  const auto refusal = [](const std::string& yaml) { return messageOf([&] { makeTown(yaml, 1); }); };
  const TemporaryFolder folder;
  const auto of = [&](std::string_view text) { return "{map: " + folder.write("place.osm", text).string() + "}"; };
  EXPECT_THAT(refusal("{map: 'http://localhost/place.osm'}"), HasSubstr("is not a file"));
  EXPECT_THAT(refusal("{map: nowhere.osm}"), AllOf(HasSubstr("town.yaml:1"), HasSubstr("nowhere.osm")));
  EXPECT_THAT(refusal(of("a text")),
              AllOf(HasSubstr("town.yaml:1"), HasSubstr("place.osm"), HasSubstr("OpenStreetMap")));
  EXPECT_THAT(refusal(of("<osm version='0.6'><node id='1' lat='1' lon='1'/></osm>")), HasSubstr("no road"));
  EXPECT_THAT(
      refusal(of("<osm version='0.6'><node id='1' lat='1' lon='1'/><node id='2' lat='1.0001' lon='1'/><way id='1'>"
                 "<nd ref='1'/><nd ref='2'/><tag k='highway' v='residential'/></way></osm>")),
      HasSubstr("100 m"));
  EXPECT_THAT(refusal(onMap("road: Mil Road")), AllOf(HasSubstr("town.yaml:1"), HasSubstr("did you mean 'Mill Road'")));
  EXPECT_THAT(refusal("{road: Mill Road}"), HasSubstr("map"));
}

}  // namespace
}  // namespace scanmill
