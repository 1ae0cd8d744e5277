#include "town/town.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <tuple>

#include "base/path.h"
#include "config/fields.h"
#include "config/value.h"
#include "models/occupancy.h"
#include "scene/scene.h"
#include "tests/support/labels.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scene.h"
#include "tests/support/town.h"
#include "town/lanes.h"
#include "town/layout.h"
#include "town/placer.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsSupersetOf;
using testing::Not;

town::Layout layoutOf(const std::string& yaml, std::uint64_t seed) {
  const Value value = parseYaml(yaml, "town.yaml");
  Fields fields(value, "town");
  return {town::readParameters(fields), seed};
}

// All that stands on the ground of a town, by the corners of its meshes, in the world's frame.
template <class Visit>
void forPoints(const Scene& scene, const Visit& visit) {
  for (const Instance& i : scene.instances) {
    if (i.name == "ground" || i.name.starts_with("road ")) continue;
    for (const Vec3f& p : scene.meshes[i.mesh].positions) visit(i, i.worldFromMesh * Vec3d(p));
  }
}

constexpr const char* kSmall = "{length: 120}";

// Walls and trees are as high as the map says, crowns and paths as wide.
TEST(Town, SizesOfTheMapAreBuilt) {
  TemporaryFolder folder;
  std::string map = "<osm version='0.6'>";
  const auto add = [&](int id, double x, double y, const std::string& tags = "") {
    map += fmt::format("<node id='{}' lat='{:.7f}' lon='{:.7f}'>{}</node>", id, 51 + y / 111250, 0.5 + x / 70200, tags);
  };
  for (int k = 0; k < 3; ++k) add(1 + k, -150 + 150 * k, 0);
  for (int k = 0; k < 4; ++k) add(4 + k, k % 2 == 0 ? -30 : 30, k < 2 ? 40 : 50);
  add(8, 0, 30, "<tag k='natural' v='tree'/><tag k='height' v='21'/><tag k='diameter_crown' v='5'/>");
  map +=
      "<way id='1'><nd ref='1'/><nd ref='2'/><nd ref='3'/><tag k='highway' v='residential'/></way>"
      "<way id='2'><nd ref='4'/><nd ref='5'/><tag k='barrier' v='wall'/><tag k='height' v='5'/></way>"
      "<way id='3'><nd ref='6'/><nd ref='7'/><tag k='highway' v='footway'/><tag k='width' v='4'/></way></osm>";
  const std::string keys =
      fmt::format("{{map: {}, length: 200, slope: 0, greenery: 0, people: 0, vehicles: 0, traffic: 0, detail: 0.1}}",
                  folder.write("sizes.osm", map).string());
  const Scene scene = makeTown(keys, 1);
  const auto boxOf = [&](const std::string& name) {
    Box box;
    forPoints(scene, [&](const Instance& i, const Vec3d& p) {
      if (i.name.starts_with(name)) box.add(p);
    });
    return box;
  };
  const Box tree = boxOf("tree 1");
  EXPECT_NEAR(tree.high.z, 21, 0.5);
  EXPECT_NEAR((tree.high.x - tree.low.x + tree.high.y - tree.low.y) / 2, 5, 1.5);
  Box panel;
  forPoints(scene, [&](const Instance& i, const Vec3d& p) {
    if (i.name == "boundary 1") panel.add(p);
  });
  const Value value = parseYaml(keys, "town.yaml");
  Fields fields(value, "town");
  const town::Parameters parameters = town::readParameters(fields);
  const town::Layout layout{parameters, 1,
                            town::cutOut(town::readMap(parameters.map, false, {}), parameters, 1, 200, {})};
  EXPECT_NEAR(panel.high.z, layout.heightAt({panel.center().x, panel.center().y}) + 5, 0.1);
  EXPECT_TRUE(std::any_of(layout.patches().begin(), layout.patches().end(), [](const town::Patch& patch) {
    return patch.kind == town::GroundKind::Path && patch.place.halfY == 2;
  }));
}

TEST(Town, TreesAndShortWallsOfTheMapAreBuilt) {
  TemporaryFolder folder;
  std::string map = "<osm version='0.6'>";
  int nodes = 0;
  const auto add = [&](double x, double y, const std::string& tags = "") {
    map += fmt::format("<node id='{}' lat='{:.7f}' lon='{:.7f}'>{}</node>", ++nodes, 51 + y / 111250, 0.5 + x / 70200,
                       tags);
  };
  for (int k = 0; k < 3; ++k) add(-150 + 150 * k, 0);
  std::string walls;
  for (int k = 0; k < 5; ++k) {
    add(-60 + 4 * k, 12);
    add(-59.1 + 4 * k, 12);
    walls += fmt::format("<way id='{}'><nd ref='{}'/><nd ref='{}'/><tag k='barrier' v='wall'/></way>", 2 + k, nodes - 1,
                         nodes);
  }
  for (int k = 0; k < 40; ++k) {
    add(-78 + 4 * k, k % 2 == 0 ? 4.5 : -5.5, "<tag k='natural' v='tree'/><tag k='diameter_crown' v='3'/>");
  }
  map +=
      "<way id='1'><nd ref='1'/><nd ref='2'/><nd ref='3'/><tag k='highway' v='residential'/><tag k='width' v='6'/>"
      "<tag k='sidewalk' v='no'/><tag k='parking:both' v='no'/></way>" +
      walls + "</osm>";
  const Scene scene = makeTown(
      fmt::format("{{map: {}, length: 200, slope: 0, detail: 0.1}}", folder.write("trees.osm", map).string()), 1);
  std::set<std::string> built;
  for (const Instance& i : scene.instances) built.insert(i.name);
  for (int k = 1; k <= 40; ++k) EXPECT_TRUE(built.contains(fmt::format("tree {}", k))) << k;
  for (int k = 1; k <= 5; ++k) EXPECT_TRUE(built.contains(fmt::format("boundary {}", k))) << k;
}

// A street on a map to which tests add ways and relations, and nothing that the seed places on its lawns.
class StreetOnAMap {
 public:
  StreetOnAMap() { way({{-102, 0}, {0, 0}, {102, 0}}, "<tag k='highway' v='residential'/>"); }
  // Returns the id of the way. The last point of a closed way is the first.
  int way(const std::vector<town::Point2>& points, const std::string& tags) {
    std::string nodes;
    const int first = id_ + 1;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const bool closes = i > 0 && town::distance(points[i], points[0]) == 0;
      if (!closes) {
        add(fmt::format("<node id='{}' lat='{:.9f}' lon='{:.9f}'/>", ++id_, 51 + points[i].y / 111250,
                        0.5 + points[i].x / 70200));
      }
      nodes += fmt::format("<nd ref='{}'/>", closes ? first : id_);
    }
    add(fmt::format("<way id='{}'>{}{}</way>", ++id_, nodes, tags));
    return id_;
  }
  void add(const std::string& element) { text_ += element; }
  std::string yaml() const {
    return fmt::format(
        "{{map: {}, length: 200, slope: 0, greenery: 0, people: 0, vehicles: 0, traffic: 0, detail: 0.05}}",
        folder_.write("street.osm", text_ + "</osm>").string());
  }
  Scene scene() const { return makeTown(yaml(), 1); }
  town::Map map() const { return town::readMap(folder_.write("street.osm", text_ + "</osm>"), false, {}); }
  // Returns the part of the map around the town of seed 1, in the town's frame.
  town::MapPlace place() const {
    const Value value = parseYaml(yaml(), "town.yaml");
    Fields fields(value, "town");
    return town::cutOut(map(), town::readParameters(fields), 1, 150, {});
  }

 private:
  TemporaryFolder folder_;
  std::string text_ = "<osm version='0.6'>";
  int id_ = 0;
};

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
  EXPECT_EQ(pieces(true), pieces(false));
}

TEST(Town, PiecesOfBarriersThatRoadsCrossAreTold) {
  StreetOnAMap street;
  const auto told = [&] {
    testing::internal::CaptureStderr();
    (void)street.scene();
    return testing::internal::GetCapturedStderr();
  };
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

TEST(Town, FollowsFromItsSeed) {
  EXPECT_EQ(hash(makeTown(kSmall, 5)), hash(makeTown(kSmall, 5)));
  EXPECT_NE(hash(makeTown(kSmall, 5)), hash(makeTown(kSmall, 6)));
}

// No beam slips through: every edge belongs to two triangles, which go along it in opposite directions, but at the end
// of the world. Curbs are walls between the two.
TEST(Town, TheGroundIsClosed) {
  for (const Place& place : {Place{kSmall, 1},
                             {kSmall, 2},
                             {"{length: 120, season: winter}", 3},
                             {onMap("length: 120, road: Mill Road"), 1},
                             {onMap("length: 200, season: winter"), 2}}) {
    const Scene scene = makeTown(place.yaml, place.seed);
    const Mesh& ground = groundOf(scene);
    const Box box = ground.bounds();
    std::map<std::tuple<float, float, float, float, float, float>, int> edges;
    const auto key = [&](const Vec3f& a, const Vec3f& b) { return std::tuple(a.x, a.y, a.z, b.x, b.y, b.z); };
    for (const auto& t : ground.triangles) {
      for (std::size_t i = 0; i < 3; ++i) ++edges[key(ground.positions[t[i]], ground.positions[t[(i + 1) % 3]])];
    }
    std::size_t open = 0;
    for (const auto& [edge, count] : edges) {
      const auto& [ax, ay, az, bx, by, bz] = edge;
      if (edges.contains({bx, by, bz, ax, ay, az})) continue;
      const bool border = (ax == bx && (ax == float(box.low.x) || ax == float(box.high.x))) ||
                          (ay == by && (ay == float(box.low.y) || ay == float(box.high.y)));
      open += border ? 0 : 1;
    }
    EXPECT_EQ(open, 0u) << place << " of " << edges.size();
  }
}

TEST(Town, TheGroundHasRoadsCurbsAndLawns) {
  const Scene scene = makeTown("{district: suburban, length: 120}", 2);
  std::map<std::string, double> area;
  const Mesh& ground = groundOf(scene);
  for (std::size_t t = 0; t < ground.triangles.size(); ++t) {
    const Vec3d n = normalIn(ground, ground.triangles[t]);
    EXPECT_GE(n.z, -1e-9) << "it faces up";
    area[scene.ontology.find(ground.surfaces[ground.surfaceOf[t]].semantic)->name] += length(n) / 2;
  }
  EXPECT_GT(area["road"], 120 * 5.0);
  EXPECT_GT(area["sidewalk"], 200);
  EXPECT_GT(area["curb"], 20);
  EXPECT_GT(area["terrain"], 20000);
}

// One can drive: on the road, with nothing in the way below the height of a car.
TEST(Town, TheLaneIsFree) {
  for (const Place& place : {Place{kSmall, 1},
                             {kSmall, 4},
                             {kSmall, 9},
                             {onMap("length: 120, road: Mill Road"), 1},
                             {onMap("length: 120, road: Church Lane"), 2},
                             {onMap("length: 100, road: School Street"), 1},
                             {onMap("length: 100, road: School Street"), 2},
                             {onMap("length: 100, road: School Street"), 3},
                             {onMap("length: 100, road: School Street"), 4},
                             {onMap("length: 100"), 4}}) {
    const Scene scene = makeTown(place.yaml, place.seed);
    const std::vector<Vec3d> lane = laneOf(place.yaml, place.seed);
    ASSERT_GT(lane.size(), 8u);
    std::size_t blocked = 0;
    std::string what;
    forPoints(scene, [&](const Instance& i, const Vec3d& p) {
      for (const Vec3d& l : lane) {
        if (std::hypot(p.x - l.x, p.y - l.y) > 0.9 || p.z - l.z < 0.05 || p.z - l.z > 1.7) continue;
        ++blocked;
        what = i.name;
      }
    });
    EXPECT_EQ(blocked, 0u) << place << ": " << what;
  }
}

TEST(Town, StandsOnItsGround) {
  const Scene scene = makeTown(kSmall, 3);
  const Mesh& ground = groundOf(scene);
  for (const Instance& i : scene.instances) {
    if (!i.name.starts_with("pedestrian") && !i.name.starts_with("car")) continue;
    expectOnGround(ground, i.worldFromMesh.translation, i.name);
  }
}

TEST(Town, HasTheClassesOfStreets) {
  std::set<std::string> all;
  for (const std::uint64_t seed : {1, 2, 3, 4})
    all.merge(classesOf(makeTown("{length: 200, people: 3, vehicles: 3}", seed)));
  EXPECT_THAT(all, IsSupersetOf({"road",       "road_marking", "sidewalk", "curb",         "terrain",
                                 "building",   "window",       "wall",     "fence",        "vegetation",
                                 "tree",       "trunk",        "pole",     "traffic_sign", "street_lamp",
                                 "car",        "truck",        "bus",      "motorcycle",   "bicycle",
                                 "pedestrian", "rider",        "object",   "parking",      "driveway"}));
}

TEST(Town, FactorsOfZeroLeaveThingsOut) {
  const std::set<std::string> bare = classesOf(makeTown("{length: 120, greenery: 0, vehicles: 0, people: 0}", 2));
  for (const char* name : {"vegetation", "tree", "car", "truck", "bus", "pedestrian", "rider", "bicycle"}) {
    EXPECT_THAT(bare, Not(Contains(name)));
  }
  EXPECT_THAT(bare, Contains("building"));
  const Scene flat = makeTown("{length: 120, slope: 0}", 2);
  const Scene hilly = makeTown("{length: 120, slope: 3}", 2);
  const auto rise = [](const Scene& scene) {
    const Box box = groundOf(scene).bounds();
    return box.high.z - box.low.z;
  };
  EXPECT_GT(rise(hilly), rise(flat) + 2);
}

// Worn roads have holes, which lie below what is around them, and covers that lie on the road.
TEST(Town, RoadsAreWorn) {
  std::size_t holes = 0;
  std::size_t covers = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const town::Layout layout = layoutOf("{length: 120}", seed);
    for (const town::Pothole& h : layout.potholes()) {
      const auto kind = layout.kindAt(layout.roads().at(h.center.x, h.center.y), h.center);
      if (kind != town::GroundKind::Road) continue;  // another road's pavement
      ++holes;
      double around = 0;
      for (int k = 0; k < 8; ++k) {
        const double angle = kPi * k / 4;
        around += layout.heightAt(
                      {h.center.x + 1.3 * h.radius * std::cos(angle), h.center.y + 1.3 * h.radius * std::sin(angle)}) /
                  8;
      }
      EXPECT_LT(layout.heightAt(h.center), around - 0.4 * h.depth + 0.012) << seed;
    }
    const Scene scene = makeTown("{length: 120}", seed);
    for (const Instance& i : scene.instances) {
      if (i.name != "road covers") continue;
      for (const Vec3f& p : scene.meshes[i.mesh].positions) {
        ++covers;
        EXPECT_NEAR(p.z, layout.heightAt({p.x, p.y}), 0.02);
      }
    }
  }
  EXPECT_GT(holes, 10u);
  EXPECT_GT(covers, 500u);
}

// A place is the same in all seasons but for leaves and snow.
TEST(Town, HasSeasons) {
  struct Year {
    std::size_t leaves = 0, things = 0;
    std::set<std::string> ground;
    double top = 0;  // m, mean height of the ground
  };
  const auto year = [](const std::string& season) {
    const Scene scene = makeTown("{length: 120, district: suburban, season: " + season + "}", 3);
    Year y;
    for (const Instance& i : scene.instances) {
      const Mesh& mesh = scene.meshes[i.mesh];
      if (i.name.starts_with("house") || i.name.starts_with("car")) ++y.things;
      if (!i.name.starts_with("tree")) continue;
      for (const std::uint16_t s : mesh.surfaceOf) {
        y.leaves += scene.materials[mesh.surfaces[s].material].name == "leaf" ? 1 : 0;
      }
    }
    const Mesh& ground = groundOf(scene);
    for (const Surface& s : ground.surfaces) y.ground.insert(scene.materials[s.material].name);
    for (const Vec3f& p : ground.positions) y.top += double{p.z} / static_cast<double>(ground.positions.size());
    return y;
  };
  const Year summer = year("summer");
  const Year autumn = year("autumn");
  const Year winter = year("winter");
  EXPECT_GT(summer.things, 10u);
  EXPECT_EQ(summer.things, winter.things);
  EXPECT_EQ(summer.things, autumn.things);
  EXPECT_LT(autumn.leaves, 0.75 * static_cast<double>(summer.leaves));
  EXPECT_LT(winter.leaves, 0.2 * static_cast<double>(autumn.leaves));
  EXPECT_THAT(winter.ground, Contains("snow"));
  EXPECT_THAT(winter.ground, Not(Contains("grass")));
  EXPECT_THAT(autumn.ground, Contains("leaf_litter"));
  EXPECT_THAT(summer.ground, Not(Contains("snow")));
  EXPECT_GT(winter.top, summer.top + 0.03);
  EXPECT_LT(winter.top, summer.top + 0.4);
}

constexpr std::array<const char*, 8> kKinds{"rural",    "suburban", "dense",      "boulevard",
                                            "old_town", "arterial", "commercial", "motorway"};

// Sixteen successive seeds have each kind, wherever they begin.
TEST(Town, SuccessiveSeedsHaveEachKind) {
  for (const std::uint64_t first : {1, 6, 1000}) {
    std::set<std::string> kinds;
    for (std::uint64_t seed = first; seed < first + 16; ++seed) {
      const std::string about = layoutOf(kSmall, seed).about();
      kinds.insert(about.substr(0, about.find(',')));
    }
    EXPECT_THAT(kinds, testing::UnorderedElementsAreArray(kKinds));
  }
}

// In each kind of place the lane of the sensor's vehicle is as free as its width needs, with many vehicles too.
TEST(Town, EachKindHasAFreeLane) {
  for (const char* kind : kKinds) {
    const std::string yaml = fmt::format("{{length: 150, district: {}, vehicles: 2, people: 2, detail: 0.1}}", kind);
    for (const std::uint64_t seed : {3, 4}) {
      const Scene scene = makeTown(yaml, seed);
      const std::vector<Vec3d> lane = laneOf(yaml, seed);
      std::string blocked;
      forPoints(scene, [&](const Instance& i, const Vec3d& p) {
        for (const Vec3d& l : lane) {
          if (std::hypot(p.x - l.x, p.y - l.y) < 1.0 && p.z - l.z > 0.05 && p.z - l.z < 1.7) blocked = i.name;
        }
      });
      EXPECT_EQ(blocked, "") << kind << ", seed " << seed;
    }
  }
}

// Terraced streets are paved from the carriageway to the walls; elsewhere there are lawns.
TEST(Town, TerracedStreetsArePavedToTheWalls) {
  for (const char* kind : {"dense", "boulevard", "old_town", "suburban"}) {
    const town::Layout layout = layoutOf(fmt::format("{{length: 200, district: {}}}", kind), 5);
    std::size_t soft = 0;
    std::size_t feet = 0;
    for (const models::House& house : layout.houses()) {
      for (const double x : {0.2, 0.5, 0.8}) {
        const Vec3d foot = house.place * Vec3d{x * house.width, -0.25, 0};
        const town::Point2 p{foot.x, foot.y};
        ++feet;
        soft += layout.kindAt(layout.roads().at(p.x, p.y), p) == town::GroundKind::Lawn ? 1 : 0;
      }
    }
    EXPECT_GT(feet, 20u) << kind;
    if (layout.character().terraced) {
      EXPECT_EQ(soft, 0u) << kind;
    } else {
      EXPECT_GT(soft, 0u) << kind;
    }
  }
}

// Motorways have rails along both edges and a barrier in the middle, no houses, and vehicles on each lane.
TEST(Town, MotorwaysHaveRailsAndSeveralLanes) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const std::string yaml = "{length: 300, district: motorway, traffic: 3, detail: 0.1}";
    const town::Layout layout = layoutOf(yaml, seed);
    const town::Road& road = layout.roads().roads().front();
    EXPECT_TRUE(layout.houses().empty());
    EXPECT_GE(road.section.lanes, 2);
    const Scene scene = makeTown(yaml, seed);
    std::map<std::string, int> panels;
    std::set<int> lanes;
    for (const Instance& i : scene.instances) {
      for (const char* row : {"median", "left rail", "right rail"}) panels[row] += i.name.starts_with(row) ? 1 : 0;
      if (!i.name.starts_with("traffic")) continue;
      for (const double time : {0.0, 10.0, 20.0, 40.0}) {
        const Vec3d at = i.worldFromMeshAt(time) * Vec3d{};
        const town::Beside b = layout.roads().at(at.x, at.y);
        // Vehicles are hidden below the ground before they arrive and after they have left.
        const bool hidden = !b.known || b.along < 15 || b.along > road.length() - 15;
        if (hidden || at.z < layout.heightAt({at.x, at.y}) - 0.5) continue;
        const double out = (std::abs(b.lateral) - road.section.median) / road.section.laneWidth();
        EXPECT_NEAR(out - std::floor(out), 0.5, 0.25) << i.name;
        lanes.insert(static_cast<int>(std::copysign(1 + std::floor(out), b.lateral)));
      }
    }
    for (const auto& [row, count] : panels) EXPECT_GT(count, 100) << row;
    // All lanes but that of the sensor's vehicle, which is the rightmost one in the direction of the line.
    EXPECT_EQ(lanes.size(), static_cast<std::size_t>(2 * road.section.lanes - 1));
    EXPECT_FALSE(lanes.contains(-road.section.lanes));
  }
}

// Cars on the sidewalk stand there half or whole, and leave a part of it free.
TEST(Town, CarsOnTheSidewalkLeaveAPath) {
  constexpr double kPath = 0.6;  // m
  std::size_t cars = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const std::string yaml = "{length: 250, district: suburban, vehicles: 3, detail: 0.1}";
    const town::Layout layout = layoutOf(yaml, seed);
    const Scene scene = makeTown(yaml, seed);
    for (const Instance& i : scene.instances) {
      if (!i.name.starts_with("car ") || i.name.starts_with("car on")) continue;
      const Vec3d& at = i.worldFromMesh.translation;
      const town::Beside b = layout.roads().at(at.x, at.y);
      if (b.edge < 0.05 || b.edge > 1.5 || layout.outsidePatches({at.x, at.y}) < 1) continue;
      const Box box = scene.meshes[i.mesh].bounds();
      EXPECT_LT(b.edge + (box.high.y - box.low.y) / 2, b.section.paved() - kPath) << i.name;
      ++cars;
    }
  }
  EXPECT_GT(cars, 10u);
}

// What the seeds draw differs from place to place: districts, widths, greenery.
TEST(Town, NoTwoSeedsAreAlike) {
  std::set<int> widths;
  std::size_t fewest = SIZE_MAX;
  std::size_t most = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Scene scene = makeTown("{length: 100}", seed);
    const auto trees =
        static_cast<std::size_t>(std::count_if(scene.instances.begin(), scene.instances.end(), [](const Instance& i) {
          return i.name.starts_with("tree") || i.name.starts_with("wood") || i.name.starts_with("undergrowth");
        }));
    fewest = std::min(fewest, trees);
    most = std::max(most, trees);
    const std::vector<Vec3d> lane = laneOf("{length: 100}", seed);
    widths.insert(static_cast<int>(std::lround(100 * std::hypot(lane[3].x - lane[0].x, lane[3].y - lane[0].y))));
    widths.insert(static_cast<int>(std::lround(100 * lane[5].y)));
  }
  EXPECT_GT(most, 3 * fewest);
  EXPECT_GE(widths.size(), 8u);
}

TEST(Town, RefusesWhatItDoesNotKnow) {
  const auto refusal = [](const std::string& yaml) { return messageOf([&] { makeTown(yaml, 1); }); };
  EXPECT_THAT(refusal("{district: rurall}"), AllOf(HasSubstr("town.yaml:1"), HasSubstr("did you mean 'rural'")));
  EXPECT_THAT(refusal("{season: sumer}"), HasSubstr("did you mean 'summer'"));
  EXPECT_THAT(refusal("{length: 20}"), AllOf(HasSubstr("town.yaml:1"), HasSubstr("length")));
  EXPECT_THAT(refusal("{greenry: 1}"), HasSubstr("did you mean 'greenery'"));
  EXPECT_THAT(refusal("{people: -1}"), HasSubstr("people"));
}

// Roads, buildings and land are the map's, whatever the seed that dresses them.
TEST(Town, StandsWhereTheMapSays) {
  const Value value = parseYaml(onMap("road: Mill Road"), "town.yaml");
  Fields fields(value, "town");
  const town::Parameters parameters = town::readParameters(fields);
  const town::MapPlace place = town::cutOut(town::readMap(parameters.map, false, {}), parameters, 1, 280, {});
  const town::Layout one(parameters, 1, place);
  const town::Layout two(parameters, 2, place);
  EXPECT_GE(one.houses().size(), 20u);
  EXPECT_GE(one.blocks().size(), 3u);
  ASSERT_EQ(one.houses().size(), two.houses().size());
  std::size_t inside = 0;
  for (std::size_t i = 0; i < one.houses().size(); ++i) {
    const models::House& a = one.houses()[i];
    const models::House& b = two.houses()[i];
    EXPECT_NEAR(
        std::hypot(a.place.translation.x - b.place.translation.x, a.place.translation.y - b.place.translation.y), 0, 4)
        << "the same rectangle, perhaps with its front to another road";
    const Vec3d middle = a.place * Vec3d{a.width / 2, a.depth / 2, 0};
    for (const town::MapBuilding& building : place.buildings) {
      inside += town::isInside({&building.outline}, {middle.x, middle.y}) ? 1 : 0;
    }
  }
  EXPECT_EQ(inside, one.houses().size());
  EXPECT_EQ(one.areas().all().size(), two.areas().all().size());
  ASSERT_EQ(one.roads().roads().size(), two.roads().roads().size());
  for (std::size_t r = 0; r < one.roads().roads().size(); ++r) {
    EXPECT_EQ(one.roads().roads()[r].length(), two.roads().roads()[r].length());
  }
}

// What keeps to the left is the mirror image of what keeps to the right; on a map, whose places stay, of its lanes
// alone.
TEST(Town, TrafficThatKeepsLeftIsAMirrorImage) {
  const std::string keys = "length: 120, detail: 0.1";
  const Scene right = makeTown("{" + keys + "}", 4);
  const Scene left = makeTown("{" + keys + ", driving_side: left}", 4);
  ASSERT_EQ(left.instances.size(), right.instances.size());
  const auto mirrored = [](const Vec3d& p) { return Vec3d{p.x, -p.y, p.z}; };
  for (std::size_t k = 0; k < left.instances.size(); ++k) {
    for (const double time : {0.0, 3.0}) {
      const Vec3d origin = left.instances[k].worldFromMeshAt(time) * Vec3d{};
      EXPECT_LT(length(origin - mirrored(right.instances[k].worldFromMeshAt(time) * Vec3d{})), 1e-6)
          << left.instances[k].name;
    }
  }
  const std::vector<Vec3d> lane = laneOf("{" + keys + "}", 4);
  const std::vector<Vec3d> leftLane = laneOf("{" + keys + ", driving_side: left}", 4);
  ASSERT_EQ(leftLane.size(), lane.size());
  for (std::size_t k = 0; k < lane.size(); ++k) EXPECT_LT(length(leftLane[k] - mirrored(lane[k])), 1e-9);

  const auto middleOf = [](const Scene& scene, std::string_view name) {
    Box box;
    for (const Instance& i : scene.instances) {
      if (!i.name.starts_with(name)) continue;
      for (const Vec3f& p : scene.meshes[i.mesh].positions) box.add(i.worldFromMesh * Vec3d(p));
    }
    return Vec3d{box.center().x, box.center().y, 0};
  };
  const Scene village = makeTown(onMap("road: Mill Road, length: 300, detail: 0.05"), 1);
  const Scene english = makeTown(onMap("road: Mill Road, length: 300, detail: 0.05, driving_side: left"), 1);
  EXPECT_EQ(english.about, village.about);
  EXPECT_LT(length(middleOf(english, "block") - middleOf(village, "block")), 1) << "buildings stay";
  const std::vector<Vec3d> one = laneOf(onMap("road: Mill Road, length: 300"), 1);
  const std::vector<Vec3d> other = laneOf(onMap("road: Mill Road, length: 300, driving_side: left"), 1);
  const Vec3d across = other[other.size() / 2] - one[one.size() / 2];
  EXPECT_GT(across.y, 1.5) << "the other lane, to the left of the way to +x";
  EXPECT_LT(across.y, 6);
}

TEST(Town, GrassGrowsOnSoilAlone) {
  std::size_t tufts = 0;
  for (const std::uint64_t seed : {9, 11}) {
    const std::string yaml = "{district: rural, length: 120, detail: 0.05}";
    const town::Layout layout = layoutOf(yaml, seed);
    for (const Instance& i : makeTown(yaml, seed).instances) {
      if (!i.name.starts_with("tuft")) continue;
      const Vec3d& at = i.worldFromMesh.translation;
      const town::GroundKind kind = layout.kindAt(layout.roads().at(at.x, at.y), {at.x, at.y});
      EXPECT_TRUE(kind == town::GroundKind::Verge || kind == town::GroundKind::Shoulder ||
                  kind == town::GroundKind::Lawn);
      EXPECT_NEAR(at.z, layout.heightAt({at.x, at.y}), 1e-6);
      ++tufts;
    }
  }
  EXPECT_GT(tufts, 20u);
  for (const Instance& i : makeTown("{district: rural, length: 120, detail: 0.05, season: winter}", 9).instances) {
    EXPECT_FALSE(i.name.starts_with("tuft"));
  }
}

// They stand near the main road, and face those who come to it out of a side road.
TEST(Town, SignsToGiveWayFaceThoseWhoComeOutOfSideRoads) {
  int signs = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const std::string yaml = "{district: suburban, length: 200, detail: 0.05}";
    const town::Layout layout = layoutOf(yaml, seed);
    const town::Road& main = layout.roads().roads().front();
    for (const Instance& i : makeTown(yaml, seed).instances) {
      if (!i.name.starts_with("sign at a mouth")) continue;
      const auto fromMain = [&](const Vec3d& p) {
        double least = 1e9;
        for (const town::Point2& q : main.line) least = std::min(least, std::hypot(p.x - q.x, p.y - q.y));
        return least;
      };
      const Vec3d at = i.worldFromMesh.translation;
      EXPECT_LT(fromMain(at), main.section.half + main.section.outer() + 20);
      EXPECT_GT(fromMain(i.worldFromMesh * Vec3d{5, 0, 0}), fromMain(at) + 2) << "seed " << seed;
      ++signs;
    }
  }
  EXPECT_GE(signs, 5);
}

// Where a side road with a sign ends, the lane that comes to it has a line, and the other has none.
TEST(Town, SideRoadsEndAtALineOfTheirLane) {
  int lines = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const std::string yaml = "{district: suburban, length: 200, detail: 0.05}";
    const town::Layout layout = layoutOf(yaml, seed);
    const Scene scene = makeTown(yaml, seed);
    const auto markings = std::find_if(scene.instances.begin(), scene.instances.end(),
                                       [](const Instance& i) { return i.name == "road markings"; });
    const std::vector<town::Road>& roads = layout.roads().roads();
    for (std::uint32_t r = 1; r < roads.size(); ++r) {
      const double at = town::stopAtMouth(layout) - 0.3;
      const double lane = roads[r].section.half - roads[r].section.parking;
      const auto painted = [&](double from, double to) {
        if (markings == scene.instances.end()) return false;
        const std::vector<Vec3f>& corners = scene.meshes[markings->mesh].positions;
        return std::any_of(corners.begin(), corners.end(), [&](const Vec3f& corner) {
          const Vec3d p = markings->worldFromMesh * Vec3d(corner);
          const town::Beside b = layout.roads().at(p.x, p.y);
          return b.road == r && std::abs(b.along - at) < 0.5 && b.lateral > from && b.lateral < to;
        });
      };
      const bool sign = town::signAtMouth(layout, r).has_value();
      EXPECT_EQ(painted(0.5, lane), sign) << "seed " << seed << " road " << r;
      EXPECT_FALSE(painted(-lane, -0.5)) << "seed " << seed << " road " << r;
      lines += sign;
    }
  }
  EXPECT_GE(lines, 5);
}

// What meets the main road from one side leaves the other side as it is, but for what an acute angle rounds off.
TEST(Town, AcrossFromASideRoadTheEdgeIsStraight) {
  int sides = 0;
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    const town::Layout layout = layoutOf("{district: arterial, length: 200, detail: 0.05}", seed);
    const std::vector<town::Road>& roads = layout.roads().roads();
    for (std::uint32_t r = 1; r < roads.size(); ++r) {
      if (!roads[r].joins) continue;
      const double at = *roads[r].joins;
      const auto isAcross = [&](std::uint32_t other) {
        return other != r && roads[other].joins && std::abs(*roads[other].joins - at) < 60;
      };
      bool alone = true;
      for (std::uint32_t other = 1; other < roads.size(); ++other) alone = alone && !isAcross(other);
      if (!alone) continue;
      const double out = roads[0].section.half * (roads[r].joinsLeft ? -1 : 1);
      for (const double along : {-8.0, -4.0, 0.0, 4.0, 8.0}) {
        const town::Point2 p = town::besideRoad(roads[0], at + along, out).at;
        EXPECT_NEAR(layout.roads().at(p.x, p.y).edge, 0, 0.7) << "seed " << seed << " road " << r << " at " << along;
      }
      ++sides;
    }
  }
  EXPECT_GE(sides, 4);
}

// Lorries pass below the wires, and a span hangs between two poles or on a house.
TEST(Town, WiresHangClearOfTheRoads) {
  constexpr double kLorry = 4;  // m
  int wired = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const std::string yaml =
        fmt::format("{{district: {}, length: 200, detail: 0.05}}", seed % 2 == 0 ? "rural" : "suburban");
    const Scene scene = makeTown(yaml, seed);
    const auto wires = std::find_if(scene.instances.begin(), scene.instances.end(),
                                    [](const Instance& i) { return i.name == "wires"; });
    const auto poles = std::count_if(scene.instances.begin(), scene.instances.end(),
                                     [](const Instance& i) { return i.name.starts_with("utility pole"); });
    if (wires == scene.instances.end()) continue;
    EXPECT_GE(poles, 3);
    ++wired;
    const town::Layout layout = layoutOf(yaml, seed);
    double lowest = 100;
    for (const Vec3f& p : scene.meshes[wires->mesh].positions) {
      const town::Beside beside = layout.roads().at(p.x, p.y);
      if (beside.known && beside.edge < 0) lowest = std::min(lowest, p.z - layout.heightAt({p.x, p.y}));
    }
    EXPECT_GT(lowest, kLorry) << "seed " << seed;
  }
  EXPECT_GE(wired, 2);
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
