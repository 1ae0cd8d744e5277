#include "town/street/street.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "config/fields.h"
#include "config/value.h"
#include "scenefile/scene_file.h"
#include "tests/support/labels.h"
#include "tests/support/message_of.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

Scene makeStreet(const std::string& yaml, std::uint64_t seed, const Affine& worldFromStreet = {}) {
  SceneBuilder builder = labelledBuilder("street", seed);
  const Value value = parseYaml(yaml, "street.yaml");
  Fields fields(value, "street");
  addStreet(builder, fields, seed, worldFromStreet);
  return builder.finish();
}

const Mesh& meshNamed(const Scene& scene, const std::string& name) {
  return *std::find_if(scene.meshes.begin(), scene.meshes.end(), [&](const Mesh& m) { return m.name == name; });
}

Box worldBox(const Scene& scene, const Instance& instance) {
  Box box;
  for (const Vec3f& p : scene.meshes[instance.mesh].positions) box.add(instance.worldFromMesh * Vec3d(p));
  return box;
}

std::map<std::string, Affine> placesOf(const Scene& scene, std::string_view start) {
  std::map<std::string, Affine> places;
  for (const Instance& i : scene.instances) {
    if (i.name.starts_with(start)) places.emplace(i.name, i.worldFromMesh);
  }
  return places;
}

// Parameters at and near the ends of their ranges.
const std::vector<std::string> kVariants = {
    "{}",
    "{cross_street: false}",
    "{parking_width: 0, road_width: 5}",
    "{length: 60}",
    "{length: 61.7, sidewalk_width: 8, front_garden: 20, road_width: 20, parking_width: 4, terrain: 80}",
    "{road_width: 6.53, parking_width: 2.37, sidewalk_width: 1.61, curb_height: 0.3, front_garden: 2, terrain: 50}",
    "{length: 500, beyond: 20, trees: 5}",
};

TEST(Street, FollowsFromItsSeed) {
  const std::string one = hash(makeStreet("{}", 1));
  EXPECT_EQ(one, hash(makeStreet("{}", 1)));
  EXPECT_NE(one, hash(makeStreet("{}", 2)));
  EXPECT_NE(hash(makeStreet("{}", 1)), hash(makeStreet("{}", (std::uint64_t{1} << 32) + 1)));
}

TEST(Street, ShapesDependOnTheSeedToo) {
  const Scene a = makeStreet("{}", 1);
  const Scene b = makeStreet("{}", 2);
  std::set<std::string> shapes;
  for (const Mesh& mesh : a.meshes) shapes.insert(hash(mesh));
  EXPECT_EQ(shapes.size(), a.meshes.size()) << "two shapes of one street are the same";
  for (const char* name : {"car", "truck", "bus", "oak", "bush", "bicycle", "motorcycle", "pedestrian", "house",
                           "ground", "street lamp", "traffic light", "traffic sign", "rider"}) {
    EXPECT_FALSE(shapes.count(hash(meshNamed(b, name)))) << name;
  }
}

TEST(Street, HoldsEveryClassItPromises) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    EXPECT_THAT(classesOf(makeStreet("{}", seed)),
                testing::IsSupersetOf({"road",   "road_marking", "sidewalk",      "curb",        "terrain", "building",
                                       "window", "wall",         "fence",         "vegetation",  "tree",    "trunk",
                                       "pole",   "traffic_sign", "traffic_light", "street_lamp", "car",     "truck",
                                       "bus",    "motorcycle",   "bicycle",       "pedestrian",  "rider",   "structure",
                                       "ground", "parking",      "object"}))
        << "seed " << seed;
  }
}

TEST(Street, CostsWhatItShould) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Scene scene = makeStreet("{}", seed);
    EXPECT_GT(scene.triangles(), 300000u);
    EXPECT_LT(scene.triangles(), 600000u);
    EXPECT_GT(scene.placedTriangles(), 1000000u);
    EXPECT_LT(scene.placedTriangles(), 1500000u);
  }
}

TEST(Street, ThingsHaveContiguousInstanceIds) {
  const Scene scene = makeStreet("{}", 5);
  std::set<std::uint32_t> ids;
  for (const Instance& i : scene.instances) {
    const Mesh& mesh = scene.meshes[i.mesh];
    std::set<std::uint32_t> own;
    for (const Surface& s : mesh.surfaces) {
      const bool thing = scene.ontology.find(s.semantic)->thing;
      EXPECT_EQ(instanceId(i, s) != 0, thing) << i.name;
      if (thing) own.insert(instanceId(i, s));
    }
    EXPECT_LE(own.size(), 1u) << i.name << " is one thing";
    for (const std::uint32_t id : own) EXPECT_TRUE(ids.insert(id).second) << i.name << " shares its id";
  }
  ASSERT_FALSE(ids.empty());
  EXPECT_EQ(*ids.begin(), 1u);
  EXPECT_EQ(*ids.rbegin(), ids.size());
  EXPECT_EQ(scene.things(), ids.size());
}

TEST(Street, NothingIsBroken) {
  for (const std::string& yaml : kVariants) {
    for (const std::uint64_t seed : {1, 2, 3, 4}) {
      const Scene scene = makeStreet(yaml, seed);
      EXPECT_EQ(scene.dropped.total(), 0u) << yaml << ", seed " << seed;
      EXPECT_TRUE(scene.unlabeled.empty());
    }
  }
}

TEST(Street, LanesAreFreeButForTraffic) {
  constexpr double kRoadEdge = 3.5;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6, 7, 8}) {
    const Scene scene = makeStreet("{cars: 30, pedestrians: 40, signs: 20, bicycles: 20, furniture: 40}", seed);
    for (const Instance& i : scene.instances) {
      if (i.name == "ground" || i.name == "road markings") continue;
      const bool traffic = i.name.starts_with("traffic ") && !i.name.starts_with("traffic light");
      const double high = traffic || i.name.starts_with("cyclist") ? 0 : kRoadEdge;
      for (const Vec3f& v : scene.meshes[i.mesh].positions) {
        const Vec3d p = i.worldFromMesh * Vec3d(v);
        const bool inLane = p.y > -kRoadEdge && p.y < high && p.z < 2.5;
        ASSERT_FALSE(inLane) << i.name << " of seed " << seed << " reaches to " << p.x << ", " << p.y << ", " << p.z;
      }
    }
  }
}

TEST(Street, VehiclesDoNotOverlap) {
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    const Scene scene = makeStreet("{cars: 40, traffic: 8, trucks: 2, buses: 2, cyclists: 4}", seed);
    std::vector<std::pair<std::string, Box>> boxes;
    for (const Instance& i : scene.instances) {
      const bool vehicle = i.name.starts_with("car ") || i.name.starts_with("cyclist ") ||
                           (i.name.starts_with("traffic ") && !i.name.starts_with("traffic light"));
      const bool house = i.name.starts_with("house ");
      if (vehicle || house) boxes.emplace_back(i.name, worldBox(scene, i));
    }
    for (std::size_t a = 0; a < boxes.size(); ++a) {
      for (std::size_t b = a + 1; b < boxes.size(); ++b) {
        if (boxes[a].first.starts_with("house ")) continue;  // roofs of neighbours may overlap in plan
        const Box& p = boxes[a].second;
        const Box& q = boxes[b].second;
        const bool apart = p.high.x < q.low.x || q.high.x < p.low.x || p.high.y < q.low.y || q.high.y < p.low.y;
        EXPECT_TRUE(apart) << boxes[a].first << " and " << boxes[b].first << ", seed " << seed;
      }
    }
  }
}

// Every edge of the ground belongs to two triangles, but for the outer border: it has neither gaps nor T-junctions.
// Upright edges are left out: where a lowered curb ends, one long edge meets two short ones on the same line.
TEST(Street, GroundIsOneClosedSurface) {
  for (const std::string& yaml : kVariants) {
    for (const std::uint64_t seed : {1, 2, 3}) {
      const Scene scene = makeStreet(yaml, seed);
      const Mesh& ground = meshNamed(scene, "ground");
      const Box box = ground.bounds();
      using Corner = std::tuple<float, float, float>;
      std::map<std::pair<Corner, Corner>, int> edges;
      for (const Triangle& t : ground.triangles) {
        for (int k = 0; k < 3; ++k) {
          const Vec3f& a = ground.positions[t[k]];
          const Vec3f& b = ground.positions[t[(k + 1) % 3]];
          if (a.x == b.x && a.y == b.y) continue;
          const Corner p{a.x, a.y, a.z};
          const Corner q{b.x, b.y, b.z};
          ++edges[std::minmax(p, q)];
        }
      }
      int open = 0;
      for (const auto& [edge, count] : edges) {
        const auto& [a, b] = edge;
        const auto both = [&](auto get, double low, double high) {
          return get(a) == get(b) && (get(a) == static_cast<float>(low) || get(a) == static_cast<float>(high));
        };
        const bool border = both([](const Corner& c) { return std::get<0>(c); }, box.low.x, box.high.x) ||
                            both([](const Corner& c) { return std::get<1>(c); }, box.low.y, box.high.y);
        if (count != (border ? 1 : 2) && ++open == 1) {
          ADD_FAILURE() << yaml << ", seed " << seed << ": an edge at " << std::get<0>(a) << ", " << std::get<1>(a)
                        << ", " << std::get<2>(a) << " has " << count << " triangles";
        }
      }
      EXPECT_EQ(open, 0);
    }
  }
}

TEST(Street, VerticalRaysFindGroundEverywhere) {
  const Scene scene = makeStreet("{}", 3);
  const Mesh& ground = meshNamed(scene, "ground");
  const Box box = ground.bounds();
  const std::set<std::string> kinds{"road", "sidewalk", "curb", "terrain", "parking", "ground"};
  const auto side = [](const Vec3d& a, const Vec3d& b, double x, double y) {
    return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
  };
  for (double x = box.low.x + 0.013; x < box.high.x; x += 6.37) {
    for (double y = box.low.y + 0.017; y < box.high.y; y += 3.91) {
      int found = 0;
      for (std::size_t k = 0; k < ground.triangles.size(); ++k) {
        const auto [a, b, c] = cornersIn(ground, ground.triangles[k]);
        const double ab = side(a, b, x, y);
        const double bc = side(b, c, x, y);
        const double ca = side(c, a, x, y);
        if (ab > 0 && bc > 0 && ca > 0) {
          ++found;
          const Surface& s = ground.surfaces[ground.surfaceOf[k]];
          EXPECT_TRUE(kinds.count(scene.ontology.find(s.semantic)->name));
        }
        EXPECT_FALSE(ab < 0 && bc < 0 && ca < 0) << "a triangle of the ground looks down";
      }
      ASSERT_EQ(found, 1) << "at " << x << ", " << y;
    }
  }
}

TEST(Street, RoadIsFlatAtZeroAndMarkingsLieOnIt) {
  const Scene scene = makeStreet("{}", 1);
  const Mesh& ground = meshNamed(scene, "ground");
  for (std::size_t k = 0; k < ground.triangles.size(); ++k) {
    if (scene.ontology.find(ground.surfaces[ground.surfaceOf[k]].semantic)->name != "road") continue;
    for (const std::uint32_t v : ground.triangles[k]) EXPECT_EQ(ground.positions[v].z, 0);
  }
  const Box paint = meshNamed(scene, "road markings").bounds();
  EXPECT_EQ(paint.low.z, 0);
  EXPECT_FLOAT_EQ(static_cast<float>(paint.high.z), 0.003f);
}

TEST(Street, LeavesAreManyAndSmallAndDenserOutside) {
  const Scene scene = makeStreet("{}", 1);
  int trees = 0;
  for (const Mesh& mesh : scene.meshes) {
    std::vector<Vec3d> leaves;
    double area = 0;
    bool trunk = false;
    for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
      const Surface& s = mesh.surfaces[mesh.surfaceOf[k]];
      trunk |= scene.ontology.find(s.semantic)->name == "trunk";
      if (!scene.materials[s.material].name.starts_with("leaf")) continue;
      const auto [a, b, c] = cornersIn(mesh, mesh.triangles[k]);
      area += length(cross(b - a, c - a)) / 2;
      leaves.push_back((a + b + c) * (1.0 / 3));
    }
    if (!trunk) continue;
    ++trees;
    EXPECT_GT(leaves.size(), 6000u) << mesh.name;
    EXPECT_LT(area / static_cast<double>(leaves.size()), 0.03) << mesh.name;
    Box crown;
    for (const Vec3d& p : leaves) crown.add(p);
    const Vec3d half = (crown.high - crown.low) * 0.5;
    // A ball of half the crown's size holds an eighth of its volume; fewer of the leaves, as they seek the light.
    std::size_t inner = 0;
    for (const Vec3d& p : leaves) {
      const Vec3d d = p - crown.center();
      const Vec3d unit{d.x / half.x, d.y / half.y, d.z / half.z};
      inner += length(unit) < 0.5 ? 1 : 0;
    }
    EXPECT_LT(static_cast<double>(inner), 0.35 * static_cast<double>(leaves.size())) << mesh.name;
  }
  EXPECT_GE(trees, 6);
}

TEST(Street, ADensityOfZeroLeavesAClassOut) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> cases = {
      {"{cars: 0, traffic: 0}", {"car"}},
      {"{trucks: 0}", {"truck"}},
      {"{buses: 0}", {"bus"}},
      {"{trees: 0}", {"tree", "trunk"}},
      {"{bushes: 0, boundaries: 0}", {"vegetation", "fence", "wall"}},
      {"{pedestrians: 0}", {"pedestrian"}},
      {"{bicycles: 0, cyclists: 0}", {"bicycle", "rider"}},
      {"{motorcycles: 0}", {"motorcycle"}},
      {"{signs: 0}", {"traffic_sign", "traffic_light", "pole"}},
      {"{lamps: 0}", {"street_lamp"}},
      {"{furniture: 0}", {"object"}},
      {"{shelters: 0}", {"structure"}},
      {"{buildings: 0}", {"building", "window"}},
  };
  for (const auto& [yaml, absent] : cases) {
    const std::set<std::string> present = classesOf(makeStreet(yaml, 1));
    for (const std::string& name : absent) EXPECT_FALSE(present.count(name)) << yaml << " has " << name;
  }
}

TEST(Street, DensitiesAreCounts) {
  const Scene scene = makeStreet("{length: 300, lamps: 4, pedestrians: 8, trees: 10}", 2);
  EXPECT_EQ(placesOf(scene, "lamp ").size(), 12u);
  EXPECT_EQ(placesOf(scene, "pedestrian ").size(), 24u);
  EXPECT_EQ(placesOf(scene, "tree ").size(), 30u);
}

TEST(Street, MoreOfOneKindLeavesTheOthersWhereTheyAre) {
  const Scene base = makeStreet("{}", 7);
  const Scene more = makeStreet("{pedestrians: 30, bushes: 0, traffic: 5, motorcycles: 4}", 7);
  for (const char* kind : {"house ", "car ", "lamp ", "sign ", "boundary ", "tree "}) {
    EXPECT_EQ(placesOf(base, kind), placesOf(more, kind)) << kind;
  }
  const Scene fewerTrees = makeStreet("{trees: 4}", 7);
  EXPECT_EQ(placesOf(base, "car "), placesOf(fewerTrees, "car "));
  for (const auto& [name, place] : placesOf(fewerTrees, "tree ")) {
    EXPECT_EQ(placesOf(base, "tree ").at(name), place) << name;
  }
}

TEST(Street, MovesAsAWhole) {
  const Affine move{{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}, {1e6, -2e6, 100}};
  const Scene here = makeStreet("{}", 4);
  const Scene there = makeStreet("{}", 4, move);
  ASSERT_EQ(here.instances.size(), there.instances.size());
  for (std::size_t k = 0; k < here.instances.size(); ++k) {
    const Vec3d expected = move * here.instances[k].worldFromMesh.translation;
    EXPECT_LT(length(there.instances[k].worldFromMesh.translation - expected), 1e-9);
    EXPECT_EQ(here.instances[k].firstInstanceId, there.instances[k].firstInstanceId);
  }
}

TEST(Street, RefusesBadParametersWithTheirPlace) {
  const auto message = [](const std::string& yaml) { return messageOf([&] { makeStreet(yaml, 1); }); };
  EXPECT_THAT(message("{length: 10}"), AllOf(HasSubstr("street.yaml:1:"), HasSubstr("length")));
  EXPECT_THAT(message("length: 200\ntrees: -1\n"), HasSubstr("street.yaml:2:"));
  EXPECT_THAT(message("{trees: many}"), HasSubstr("trees"));
  EXPECT_THAT(message("{buildings: 1.5}"), HasSubstr("buildings"));
  EXPECT_THAT(message("{tree: 5}"), HasSubstr("trees"));
  EXPECT_THAT(message("{cross_street: perhaps}"), HasSubstr("cross_street"));
  EXPECT_THAT(message("{parking_width: 1}"), AllOf(HasSubstr("street.yaml:1:"), HasSubstr("at least 2 m")));
  EXPECT_THAT(message("{terrain: 50, front_garden: 20, sidewalk_width: 8}"),
              AllOf(HasSubstr("street.yaml:1:"), HasSubstr("terrain")));
  EXPECT_THAT(message("{length: .nan}"), HasSubstr("length"));
}

TEST(Street, SceneFileHoldsTheDefaults) {
  const std::filesystem::path file = std::filesystem::path(SCANMILL_SOURCE_DIR) / "scenes" / "street.yaml";
  SceneOptions options;
  options.seed = 11;
  EXPECT_EQ(hash(readScene(file, options)), hash(makeStreet("{}", 11)));
}

}  // namespace
}  // namespace scanmill
