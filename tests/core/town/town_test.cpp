#include "town/town.h"

#include <fmt/format.h>

#include <map>
#include <set>
#include <tuple>

#include "tests/support/message_of.h"
#include "tests/support/test_scene.h"
#include "tests/support/town.h"
#include "town/lanes.h"
#include "town/placer.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsSupersetOf;
using testing::Not;

constexpr const char* kSmall = "{length: 120}";

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
                             {"{district: street, length: 120}", 4},
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
    EXPECT_GE(n.z, -1e-6) << "it faces up; the rounding of corners may turn a sliver of less than a square millimetre";
    area[scene.ontology.find(ground.surfaces[ground.surfaceOf[t]].semantic)->name] += length(n) / 2;
  }
  EXPECT_GT(area["road"], 120 * 5.0);
  EXPECT_GT(area["sidewalk"], 200);
  EXPECT_GT(area["curb"], 20);
  EXPECT_GT(area["terrain"], 20000);
}

// One can drive, with many vehicles too: on the road, with nothing in the way below the height of a car.
TEST(Town, TheLaneIsFree) {
  std::vector<Place> places{{kSmall, 1},
                            {kSmall, 4},
                            {kSmall, 9},
                            {onMap("length: 120, road: Mill Road"), 1},
                            {onMap("length: 120, road: Church Lane"), 2},
                            {onMap("length: 100, road: School Street"), 1},
                            {onMap("length: 100, road: School Street"), 2},
                            {onMap("length: 100, road: School Street"), 3},
                            {onMap("length: 100, road: School Street"), 4},
                            {onMap("length: 100"), 4}};
  for (const char* kind :
       {"rural", "suburban", "dense", "boulevard", "old_town", "arterial", "commercial", "motorway", "street"}) {
    for (const std::uint64_t seed : {3, 4}) {
      places.push_back({fmt::format("{{length: 150, district: {}, vehicles: 2, people: 2, detail: 0.1}}", kind), seed});
    }
  }
  for (const Place& place : places) {
    const Scene scene = makeTown(place.yaml, place.seed);
    const std::vector<Vec3d> lane = laneOf(place.yaml, place.seed);
    ASSERT_GT(lane.size(), 8u);
    std::string blocked;
    forPoints(scene, [&](const Instance& i, const Vec3d& p) {
      for (const Vec3d& l : lane) {
        const Vec3d d = p - l;
        if (d.x * d.x + d.y * d.y < 0.9 * 0.9 && d.z > 0.1 && d.z < 1.7) blocked = i.name;
      }
    });
    EXPECT_EQ(blocked, "") << place;
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
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    all.merge(classesOf(makeTown("{length: 200, people: 3, vehicles: 3}", seed)));
  }
  std::vector<std::set<std::string>> places{all};
  for (const std::uint64_t seed : {1, 2, 3}) {
    places.push_back(classesOf(makeTown("{district: street, length: 200, detail: 0.1}", seed)));
    EXPECT_TRUE(places.back().contains("structure"));
  }
  EXPECT_THAT(all, IsSupersetOf({"wall", "truck", "bus"}));
  for (const std::set<std::string>& classes : places) {
    EXPECT_THAT(classes,
                IsSupersetOf({"road",         "road_marking", "sidewalk",   "curb",       "terrain", "building",
                              "window",       "fence",        "vegetation", "tree",       "trunk",   "pole",
                              "traffic_sign", "street_lamp",  "car",        "motorcycle", "bicycle", "pedestrian",
                              "rider",        "object",       "parking",    "driveway"}));
  }
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
    for (const town::Pothole& h : layout.potholes) {
      const auto kind = layout.kindAt(layout.besideAt(h.center), h.center);
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
        const std::string& material = scene.materials[mesh.surfaces[s].material].name;
        y.leaves += material.starts_with("leaf") && material != "leaf_conifer" ? 1 : 0;
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

TEST(Town, RefusesWhatItDoesNotKnow) {
  const auto refusal = [](const std::string& yaml) { return messageOf([&] { makeTown(yaml, 1); }); };
  EXPECT_THAT(refusal("{district: rurall}"), AllOf(HasSubstr("town.yaml:1"), HasSubstr("did you mean 'rural'")));
  EXPECT_THAT(refusal("{season: sumer}"), HasSubstr("did you mean 'summer'"));
  EXPECT_THAT(refusal("{length: 20}"), AllOf(HasSubstr("town.yaml:1"), HasSubstr("length")));
  EXPECT_THAT(refusal("{greenry: 1}"), HasSubstr("did you mean 'greenery'"));
  EXPECT_THAT(refusal("{people: -1}"), HasSubstr("people"));
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
  EXPECT_GT(across.y, 1.2) << "the other lane, to the left of the way to +x";
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
      const town::GroundKind kind = layout.kindAt(layout.besideAt({at.x, at.y}), {at.x, at.y});
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
    const town::Road& main = layout.mainRoad();
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
    const std::vector<town::Road>& roads = layout.roads();
    for (std::uint32_t r = 1; r < roads.size(); ++r) {
      const double at = town::stopLineOfSideRoad(layout) - 0.3;
      const double lane = roads[r].section.half - roads[r].section.parking;
      const auto painted = [&](double from, double to) {
        if (markings == scene.instances.end()) return false;
        const std::vector<Vec3f>& corners = scene.meshes[markings->mesh].positions;
        return std::any_of(corners.begin(), corners.end(), [&](const Vec3f& corner) {
          const Vec3d p = markings->worldFromMesh * Vec3d(corner);
          const town::Beside b = layout.besideAt({p.x, p.y});
          return b.road == r && std::abs(b.along - at) < 0.5 && b.lateral > from && b.lateral < to;
        });
      };
      const bool sign = town::signAtMouth(layout, roads[r]).has_value();
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
    const std::vector<town::Road>& roads = layout.roads();
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
        EXPECT_NEAR(layout.besideAt(p).edge, 0, 0.7) << "seed " << seed << " road " << r << " at " << along;
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
    const auto poles = std::count_if(scene.instances.begin(), scene.instances.end(),
                                     [](const Instance& i) { return i.name.starts_with("utility pole"); });
    const town::Layout layout = layoutOf(yaml, seed);
    double lowest = 100;
    int spans = 0;
    for (const Instance& wires : scene.instances) {
      if (!wires.name.starts_with("wire")) continue;
      ++spans;
      for (const Vec3f& p : scene.meshes[wires.mesh].positions) {
        const town::Beside beside = layout.besideAt({p.x, p.y});
        if (beside.nearRoad && beside.edge < 0) lowest = std::min(lowest, p.z - layout.heightAt({p.x, p.y}));
      }
    }
    if (spans == 0) continue;
    EXPECT_GE(poles, 3);
    ++wired;
    EXPECT_GT(lowest, kLorry) << "seed " << seed;
  }
  EXPECT_GE(wired, 2);
}

}  // namespace
}  // namespace scanmill
