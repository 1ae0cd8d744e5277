#include <fmt/format.h>

#include <map>
#include <set>

#include "scene/scene.h"
#include "scenefile/object_placer.h"
#include "scenefile/scene_file.h"
#include "tests/support/labels.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// A lawn of 100 m x 100 m that rises by 0.1 m a metre in x, a road across it 0.02 m above, a house of 20 m x 10 m.
class Arrangements : public testing::Test {
 protected:
  Scene scene(const std::string& object, std::uint64_t seed = 1) const {
    const std::string yaml = sceneYaml(
        R"(  - {name: lawn, primitive: plane, size: [100.49875621, 100], class: terrain, material: grass, pitch_deg: -5.710593137}
  - {name: road, primitive: plane, size: [8, 100], class: road, material: asphalt, position: [30, 0, 3.5]}
  - {name: house, primitive: box, size: [20, 10, 8], class: building, material: plaster, position: [-20, 10, 3]}
)" + object);
    SceneOptions options;
    options.seed = seed;
    return readScene(folder_.write("s.yaml", yaml), options);
  }
  // Where the copies of the object named `post` stand.
  std::vector<Affine> posts(const std::string& keys, std::uint64_t seed = 1, const std::string& before = "") const {
    return postsOf(scene(before + kPost + keys + "}", seed));
  }
  static std::vector<Affine> postsOf(const Scene& scene) {
    std::vector<Affine> found;
    for (const Instance& i : scene.instances) {
      if (i.name.starts_with("post")) found.push_back(i.worldFromMesh);
    }
    return found;
  }
  std::string refusal(const std::string& keys) const {
    return messageOf([&] { posts(keys); });
  }

  static constexpr const char* kPost =
      "  - {name: post, primitive: box, size: [0.2, 0.4, 2], class: pole, material: wood, ";
  TemporaryFolder folder_;
};

std::string scatter(const std::string& keys) {
  return "copies: {scatter: {on: [terrain], " + keys + "}}";
}

double lawn(double x) {
  return 0.1 * x;
}

TEST_F(Arrangements, ScatteredOnesStandOnTheirSurfaceUncoveredAndApart) {
  const std::vector<Affine> posts = this->posts(scatter("count: 300, spacing: 2"));
  ASSERT_EQ(posts.size(), 300u);
  int quadrant[2][2] = {};
  for (std::size_t i = 0; i < posts.size(); ++i) {
    const Vec3d& p = posts[i].translation;
    EXPECT_NEAR(p.z, lawn(p.x), 1e-5) << i;
    EXPECT_FALSE(std::fabs(p.x + 20) < 9.99 && std::fabs(p.y - 10) < 4.99) << "not in the house";
    EXPECT_FALSE(std::fabs(p.x - 30) < 3.99) << "not on the road, which lies above";
    EXPECT_NEAR(posts[i].linear.z.z, 1, 1e-12);
    for (std::size_t k = 0; k < i; ++k) EXPECT_GE(length(posts[k].translation - p), 2);
    ++quadrant[p.x > 0][p.y > 0];
  }
  // Evenly: a quarter each, less what the house and the road take.
  for (const auto& row : quadrant) {
    for (const int n : row) EXPECT_NEAR(n, 75, 25);
  }
  // They are turned evenly too.
  double x = 0, y = 0;
  for (const Affine& a : posts) x += a.linear.x.x, y += a.linear.x.y;
  EXPECT_LT(std::hypot(x, y), 45);
}

TEST_F(Arrangements, ADensityIsThatOfTheFreeSurface) {
  // 10,000 m^2 less the house's 200 and the road's 800.
  const auto few = posts(scatter("density: 0.2"));
  EXPECT_NEAR(static_cast<double>(few.size()), 0.2 * 9000, 3 * std::sqrt(1800.0));
  const auto within = posts("copies: {scatter: {on: [terrain, road], density: 0.5, within: [[20, 0], [40, 20]]}}");
  EXPECT_NEAR(static_cast<double>(within.size()), 200, 1);
  for (const Affine& a : within) {
    EXPECT_TRUE(a.translation.x > 20 && a.translation.x < 40 && a.translation.y > 0 && a.translation.y < 20);
    EXPECT_NEAR(a.translation.z, std::fabs(a.translation.x - 30) < 4 ? 3.5 : lawn(a.translation.x), 1e-4);
  }
}

TEST_F(Arrangements, SlopesAreAvoidedAndCoveredPlacesTakenWhenAsked) {
  EXPECT_THAT(refusal(scatter("count: 5, slope_deg: 5")), HasSubstr("only 0 of 5"));
  EXPECT_EQ(posts(scatter("count: 5, slope_deg: 6")).size(), 5u);
  EXPECT_THAT(refusal(scatter("count: 5, within: [[-25, 7], [-15, 13]]")), HasSubstr("only 0 of 5"));
  EXPECT_EQ(posts(scatter("count: 5, within: [[-25, 7], [-15, 13]], covered: true")).size(), 5u);
}

// The same for the same seed, others for others: so a scene has as many variants as there are seeds.
TEST_F(Arrangements, FollowFromTheSeedAndTheObject) {
  const std::string keys = scatter("count: 20");
  EXPECT_EQ(posts(keys, 4), posts(keys, 4));
  EXPECT_NE(posts(keys, 4), posts(keys, 5));
  const Scene two = scene(
      "  - {name: a, primitive: box, size: [1, 1, 1], class: pole, material: wood, copies: {scatter: {on: [terrain], "
      "count: 1}}}\n"
      "  - {name: b, primitive: box, size: [1, 1, 1], class: pole, material: wood, copies: {scatter: {on: [terrain], "
      "count: 1}}}");
  EXPECT_NE(two.instances[3].worldFromMesh, two.instances[4].worldFromMesh);
  EXPECT_TRUE(two.procedural);
  EXPECT_FALSE(scene("").procedural);
}

// What else is in the scene, or is added before an object, does not move its copies; objects of one name differ.
TEST_F(Arrangements, DoNotFollowFromOtherObjects) {
  const auto first = [&](const std::string& before) {
    return posts("position: [9, 9, 9], vary: {position: 4, yaw_deg: [0, 90]}", 1, before).at(0);
  };
  const std::string other = ", primitive: box, size: [1, 1, 1], class: pole, material: wood, vary: {position: 4}}\n";
  EXPECT_EQ(first(""), first("  - {name: b" + other + "  - {name: c" + other));
  const Scene twins = scene("  - {name: a" + other + "  - {name: a" + other);
  EXPECT_NE(twins.instances[3].worldFromMesh, twins.instances[4].worldFromMesh);
}

// The road's edges are at x = 26 and 34, the house's walls at x = -30 and -10, y = 5 and 15.
TEST_F(Arrangements, KeepTheirDistanceFromClasses) {
  const auto posts = this->posts(scatter("count: 200, distance_from: {road: [1, 4], building: 3}"));
  ASSERT_EQ(posts.size(), 200u);
  double nearest = 9, farthest = 0;
  for (const Affine& post : posts) {
    const double away = std::fabs(post.translation.x - 30) - 4;
    nearest = std::min(nearest, away);
    farthest = std::max(farthest, away);
  }
  EXPECT_GE(nearest, 1 - 1e-4);
  EXPECT_LT(nearest, 1.1);
  EXPECT_LE(farthest, 4 + 1e-4);
  EXPECT_GT(farthest, 3.9);
  double fromHouse = 99;
  for (const Affine& post : this->posts(scatter("count: 900, distance_from: {building: 3}"))) {
    const Vec3d p = post.translation;
    fromHouse = std::min(fromHouse,
                         std::hypot(std::max(std::fabs(p.x + 20) - 10, 0.0), std::max(std::fabs(p.y - 10) - 5, 0.0)));
  }
  EXPECT_GE(fromHouse, 3 - 1e-4);
  EXPECT_LT(fromHouse, 4);
  EXPECT_EQ(this->posts(scatter("count: 9, distance_from: {tree: 5}")).size(), 9u) << "far from what there is not";
}

// Near a class there is little of a large surface, and yet there is room.
TEST_F(Arrangements, FindPlacesInNarrowStrips) {
  const std::string large =
      "  - {name: plain, primitive: plane, size: [2000, 2000], class: sidewalk, material: paving, position: "
      "[0, 0, -90]}\n  - {name: lane, primitive: plane, size: [2, 400], class: parking, material: "
      "asphalt, position: [500, 0, -89.9]}\n";
  const std::vector<Affine> found = posts(
      "copies: {scatter: {on: [sidewalk], count: 50, covered: true, distance_from: {parking: [1, 3]}}}", 1, large);
  EXPECT_EQ(found.size(), 50u);
  for (const Affine& post : found) {
    const Vec3d& p = post.translation;
    const double away = std::hypot(std::max(std::fabs(p.x - 500) - 1, 0.0), std::max(std::fabs(p.y) - 200, 0.0));
    EXPECT_TRUE(away >= 1 - 1e-3 && away <= 3 + 1e-3) << away;
  }
}

// Objects of one name of a thing are that one, copy by copy.
TEST_F(Arrangements, SeveralObjectsMayBeOneThing) {
  const std::string box =
      ", primitive: box, size: [1, 1, 1], material: wood, copies: {grid: {count: [2, 1, 1], spacing: "
      "[5, 5, 5]}}, class: ";
  const Scene s = scene("  - {name: crown, thing: oak" + box + "tree}\n  - {name: stem, thing: oak" + box +
                        "trunk}\n  - {name: other" + box + "tree}");
  ASSERT_EQ(s.instances.size(), 9u);
  const auto id = [&](std::size_t i) { return instanceId(s.instances[i], s.meshes[s.instances[i].mesh].surfaces[0]); };
  EXPECT_EQ(id(3), id(5));
  EXPECT_EQ(id(4), id(6));
  EXPECT_NE(id(3), id(4));
  EXPECT_EQ(std::set({id(2), id(3), id(4), id(7), id(8)}).size(), 5u);
  EXPECT_EQ(s.things(), 5u);
}

TEST_F(Arrangements, AlongAPathTheyFollowItBesideIt) {
  const auto found = posts("copies: {along: {waypoints: [[0, 0, 0], [0, 40, 0]], every: 10, left: 3}}");
  ASSERT_EQ(found.size(), 5u);
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_LT(length(found[i].translation - Vec3d{-3, 10.0 * static_cast<double>(i), 0}), 1e-9) << i;
    EXPECT_LT(length(found[i].linear.x - Vec3d{0, 1, 0}), 1e-9);
  }
  // Each copy of the placement at each place.
  EXPECT_EQ(
      posts("copies: {along: {waypoints: [[0, 0, 0], [0, 40, 0]], every: 10}, at: [{}, {position: [1, 0, 0]}]}").size(),
      10u);
}

TEST_F(Arrangements, StandWithTheirLowestPointOnWhatIsBelow) {
  for (const auto& [x, z] : {std::pair{10.0, 1.0}, std::pair{30.0, 3.5}}) {
    const auto found = posts(fmt::format("position: [{}, -20, 50], stand_on: ground", x));
    EXPECT_NEAR(found.at(0).translation.z, z + 1, 1e-5) << "its middle is 1 m above its foot";
  }
  EXPECT_NEAR(posts("position: [30, 0, 50], stand_on: [terrain]").at(0).translation.z, 4, 1e-5);
  EXPECT_NEAR(posts("position: [-20, 10, 50], stand_on: ground").at(0).translation.z, -2 + 1, 1e-5)
      << "a house is a thing";
  EXPECT_NEAR(posts("position: [-20, 10, 50], stand_on: [building]").at(0).translation.z, 8, 1e-5);
  // Of several those that have no ground are left out.
  testing::internal::CaptureStderr();
  EXPECT_EQ(posts("stand_on: ground, copies: {along: {waypoints: [[10, -20, 0], [510, -20, 0]], every: 250}}").size(),
            1u);
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              AllOf(HasSubstr("s.yaml:7"), HasSubstr("left out 2 of 3 copies"), HasSubstr("at [260, -20]")));
}

TEST_F(Arrangements, VaryWithinTheirBounds) {
  const auto found = posts(
      "copies: {grid: {count: [40, 50, 1], spacing: [1, 1, 0]}}, vary: {yaw_deg: [-30, 60], scale: [0.5, 2], position: "
      "0.3, presence: 0.25}");
  EXPECT_NEAR(static_cast<double>(found.size()), 500, 60);
  double least = 9, most = 0, leftmost = 9, rightmost = -9;
  for (const Affine& a : found) {
    const double scale = length(a.linear.x);
    least = std::min(least, scale);
    most = std::max(most, scale);
    const double yaw = degrees(std::atan2(a.linear.x.y, a.linear.x.x));
    leftmost = std::min(leftmost, yaw);
    rightmost = std::max(rightmost, yaw);
    const Vec3d off = a.translation - Vec3d{std::round(a.translation.x), std::round(a.translation.y), 0};
    EXPECT_LE(std::hypot(off.x, off.y), 0.3 + 1e-9);
  }
  EXPECT_NEAR(least, 0.5, 0.02);
  EXPECT_NEAR(most, 2, 0.02);
  EXPECT_NEAR(leftmost, -30, 1);
  EXPECT_NEAR(rightmost, 60, 1);
}

TEST_F(Arrangements, MistakesAreNamedWithTheirPlace) {
  const auto refused = [&](const std::string& keys) { return refusal(keys); };
  const std::string on = "s.yaml:7 | ";
  expectRefusals(
      refused, {{scatter(""), on + "either `count` or `density`"},
                {"copies: {scatter: {count: 4}}", "'on'"},
                {"copies: {scatter: {on: [lawm], count: 4}}", "no class 'lawm'"},
                {"copies: {scatter: {on: [water], count: 4}}", "no surface to scatter on"},
                {scatter("count: 9, distance_from: {tree: [0, 5]}"), on + "no earlier object"},
                {scatter("count: 9, distance_from: {roof: 5}"), "roof"},
                {scatter("count: 9, distance_from: {road: [4, 1]}"), "[least, most]"},
                {scatter("count: 9, distance_from: 4"), "class"},
                {scatter("count: 9, spacing: 90"), "seed 1"},
                {scatter("count: 4000, spacing: 5"), "of 4000 copies fit"},
                {scatter("count: 4, within: [[1, 2], [0, 3]]"), "the corner with the least coordinates"},
                {scatter("density: 1e-6"), "higher density"},
                {scatter("count: 5, spacing: 1e-9"), "spacing"},
                {scatter("count: 9") + ", vary: {position: 3}", "off their surface"},
                {"copies: {scatter: {on: [terrain], count: 4}, along: {waypoints: [[0, 0, 0], [1, 0, 0]], every: 1}}",
                 "not both"},
                {"copies: {scatter: {on: [terrain], count: 100000}, grid: {count: [1000, 100, 1], spacing: [1, 1, 0]}}",
                 on + "100000 copies each"},
                {"copies: {along: {waypoints: [[0, 0, 0]], every: 1}}", "at least two"},
                {"copies: {along: {waypoints: [[0, 0, 0], [1e8, 0, 0]], every: 1}}", on + "at most"},
                {"vary: {yaw_deg: [60, 30]}", "[least, most]"},
                {"vary: {yaw: [60, 30]}", "unknown key 'yaw'"},
                {"vary: {material: [grass]}", "objects that are files"},
                {"stand_on: [nowhere]", "no class 'nowhere'"},
                {"position: [500, 0, 0], stand_on: ground", on + "no surface to stand on at [500, 0]"},
                {"moving: {velocity: [1, 0, 0]}, stand_on: ground", "for objects that stand still"},
                {"moving: {}", on + "velocity"},
                {"moving: {velocity: [1, 0, 0], speed: 3}", on + "speed has no effect beside `velocity`"},
                {"moving: {velocity: [400, 0, 0]}", "300 m/s"},
                {"moving: {waypoints: [[0, 0, 0], [1, 0, 0]]}", "speed"},
                {"moving: {waypoints: [[0, 0, 0], [1, 0, 0]], speed: 1, start: 2}", "start"},
                {"moving: {waypoint: [[0, 0, 0], [1, 0, 0]], speed: 1}", "waypoints"}});
  EXPECT_EQ(refusal(scatter("count: 9") + ", vary: {position: 3}, stand_on: ground"), "accepted");
}

// Copies are turned about the vertical, whatever their own scale and tilt: an own scale is not sheared.
TEST_F(Arrangements, VaryTurnsWhatIsScaledAndTilted) {
  for (const Affine& a : posts("scale: [4, 1, 1], roll_deg: 90, vary: {yaw_deg: [90, 90]}")) {
    EXPECT_LT(length(a.linear.x - Vec3d{0, 4, 0}), 1e-12);
    EXPECT_LT(length(a.linear.y - Vec3d{0, 0, 1}), 1e-12);
    EXPECT_LT(length(a.linear.z - Vec3d{1, 0, 0}), 1e-12);
  }
}

// The lowest point of what is tilted is that of its vertices: a sphere's, whichever way it is turned.
TEST_F(Arrangements, WhatIsTiltedStandsOnItsLowestPoint) {
  const Scene s = scene(
      "  - {name: ball, primitive: sphere, radius: 1, segments: 64, class: vegetation, material: grass, "
      "position: [5, -20, 0], roll_deg: 45, stand_on: ground}");
  EXPECT_NEAR(s.instances.back().worldFromMesh.translation.z, lawn(5) + 1, 0.01);
}

// A marking as thin as paint does not cover the road that it lies on, whether copies keep within a box or not.
TEST_F(Arrangements, ThinLayersDoNotCover) {
  const std::string marking =
      "  - {name: marking, primitive: plane, size: [8, 100], class: road_marking, material: road_paint, "
      "position: [30, 0, 3.51]}\n";
  for (const char* within : {"", ", within: [[27, -40], [33, 40]]"}) {
    const std::string keys = fmt::format("copies: {{scatter: {{on: [road], count: 5{}}}}}", within);
    const std::vector<Affine> found = posts(keys, 1, marking);
    EXPECT_EQ(found.size(), 5u) << within;
    for (const Affine& post : found) EXPECT_NEAR(post.translation.z, 3.5, 1e-6) << within;
  }
}

// Upright surfaces and undersides are no ground, however large.
TEST_F(Arrangements, StandOnWhatFacesUp) {
  const std::string wall =
      "  - {name: sign, primitive: plane, size: [90, 90], class: terrain, material: grass, position: [0, 45, 0], "
      "pitch_deg: 90}\n";
  for (const Affine& post : posts(scatter("count: 50"), 1, wall)) {
    EXPECT_NEAR(post.translation.z, lawn(post.translation.x), 1e-5);
  }
}

// Of several files each copy is one at random, and has one of several materials.
class RandomShapes : public Arrangements {
 protected:
  RandomShapes() {
    // Two columns, of 1 m and of 3 m, whose lowest points are at 0 and at -1; and a folder with both.
    const auto column = [](double low, double high) {
      return fmt::format("o c\nv 0 0 {0}\nv 1 0 {0}\nv 0 0 {1}\nf 1 2 3\n", low, high);
    };
    for (const char* folder : {"", "both/", "both/inner/"}) {
      if (folder != std::string("both/inner/")) folder_.write(std::string(folder) + "short.obj", column(0, 1));
      if (folder != std::string("both/")) folder_.write(std::string(folder) + "tall.obj", column(-1, 2));
    }
  }
  Scene columns(const std::string& file, const std::string& more, std::uint64_t seed = 1) const {
    return scene("  - {name: post, file: " + file + ", class: pole, material: wood, " + more + "}", seed);
  }
  static std::map<std::string, int> counts(const Scene& s) {
    std::map<std::string, int> found;
    for (const Instance& i : s.instances) {
      if (i.name.starts_with("post")) ++found[s.meshes[i.mesh].name];
    }
    return found;
  }
};

constexpr const char* kMany = "copies: {grid: {count: [40, 20, 1], spacing: [1, 1, 1]}}";

TEST_F(RandomShapes, AreAsManyOfEach) {
  const auto found = counts(columns("{one_of: [short.obj, tall.obj]}", kMany));
  EXPECT_NEAR(found.at("short.obj"), 400, 60);
  EXPECT_NEAR(found.at("tall.obj"), 400, 60);
  const auto folder = counts(columns("{one_of: both}", kMany));
  EXPECT_NEAR(folder.at("both/short.obj"), 400, 60);
  EXPECT_NEAR(folder.at("both/inner/tall.obj"), 400, 60);
  const auto shapes = [&](std::uint64_t seed) {
    std::vector<std::string> names;
    const Scene s = columns("{one_of: both}", kMany, seed);
    EXPECT_TRUE(s.procedural);
    for (const Instance& i : s.instances) names.push_back(s.meshes[i.mesh].name);
    return names;
  };
  EXPECT_EQ(shapes(5), shapes(5));
  EXPECT_NE(shapes(5), shapes(6));
}

TEST_F(RandomShapes, StandEachOnItsOwnLowestPoint) {
  const Scene s = columns("{one_of: [short.obj, tall.obj]}",
                          "position: [0, 0, 20], stand_on: ground, copies: {grid: {count: [1, 40, "
                          "1], spacing: [1, 1, 1]}}");
  for (const Instance& i : s.instances) {
    if (!i.name.starts_with("post")) continue;
    EXPECT_NEAR(i.worldFromMesh.translation.z, lawn(0) + (s.meshes[i.mesh].name == "short.obj" ? 0 : 1), 1e-5);
  }
}

TEST_F(RandomShapes, HaveOneOfSeveralMaterials) {
  const Scene s = columns("short.obj", std::string(kMany) + ", vary: {material: [asphalt, brick, grass]}");
  std::map<std::string, int> found;
  for (const Instance& i : s.instances) {
    if (i.name.starts_with("post")) ++found[s.materials[s.meshes[i.mesh].surfaces.at(0).material].name];
  }
  EXPECT_EQ(found.size(), 3u);
  for (const auto& [name, count] : found) EXPECT_NEAR(count, 267, 50) << name;
  EXPECT_EQ(s.meshes.size(), 3u + 3u) << "lawn, road, house; one mesh for each material";
  EXPECT_THAT(messageOf([&] { columns("short.obj", "vary: {material: [gras]}"); }), HasSubstr("did you mean 'grass'"));
  folder_.write("none/readme.txt", "x");
  const auto refused = [&](const std::string& file) {
    return messageOf([&] { columns(file, "position: [0, 0, 0]"); });
  };
  EXPECT_THAT(refused("{one_of: none}"), HasSubstr("a folder without 3D files"));
  EXPECT_THAT(refused("both"), HasSubstr("write {one_of: both}"));
  EXPECT_THAT(refused("[short.obj, tall.obj]"), AllOf(HasSubstr("s.yaml:7"), HasSubstr("file must be one file")));
  EXPECT_THAT(refused("{one_off: both}"), HasSubstr("did you mean 'one_of'"));
}

}  // namespace
}  // namespace scanmill
