#include "pipeline/scenes/scene_shares.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenefile/scene_file.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

class SceneShares : public testing::Test {
 protected:
  std::filesystem::path town(const std::string& keys) {
    return folder_.write("place.yaml", fmt::format("{{ontology: scanmill, materials: materials, objects: [{{town: "
                                                   "{{length: 120, detail: 0.05{}}}}}]}}",
                                                   keys.empty() ? "" : ", " + keys));
  }

  TemporaryFolder folder_;
};

SceneOptions seeded(std::uint64_t seed) {
  SceneOptions options;
  options.seed = seed;
  return options;
}

Scene withShares(Scene scene, std::initializer_list<std::uint16_t> classes) {
  for (const std::uint16_t id : classes) {
    scene.shares.push_back({fmt::format("class {}", id), {id}, Supply::Vehicles});
  }
  return scene;
}

// Two walls to infinity beside the lane, each of which takes the half of all beams.
TEST_F(SceneShares, OfTwoWallsAreTheHalfEach) {
  const std::string wall =
      "{{primitive: box, class: {}, material: default, size: [2000, 1, 200], position: [0, {}, 0]}}";
  Scene scene = withShares(
      readScene(folder_.write("walls.yaml", fmt::format("{{ontology: scanmill, materials: materials, objects: [{}, "
                                                        "{}]}}",
                                                        fmt::format(fmt::runtime(wall), "car", 4),
                                                        fmt::format(fmt::runtime(wall), "fence", -4))),
                {}),
      {20, 9, 6});
  measureShares(scene, {{-50, 0, 0}, {50, 0, 0}});
  EXPECT_NEAR(scene.shares[0].found, 0.5, 0.005);
  EXPECT_NEAR(scene.shares[1].found, 0.5, 0.005);
  EXPECT_EQ(scene.shares[2].found, 0);
  measureShares(scene, {{0, 20, 0}, {50, 20, 0}});
  EXPECT_EQ(scene.shares[0].found, 1);
}

TEST_F(SceneShares, AreMetByMoreAndByLess) {
  for (const std::uint64_t seed : {1, 2}) {
    const Scene drawn =
        readSceneToShares(town("vehicles: 0.3, shares: {vehicles: [0, 1], greenery: [0, 1]}"), seeded(seed));
    const double vehicles = drawn.shares[0].found;
    const double greenery = drawn.shares[1].found;
    ASSERT_GT(vehicles, 0.0005);
    for (const auto& [least, most] : {std::pair{0.0, 0.6}, std::pair{1.4, 3.0}}) {
      const Scene scene =
          readSceneToShares(town(fmt::format("vehicles: 0.3, shares: {{vehicles: [{}, {}], greenery: [0, {}]}}",
                                             least * vehicles, std::min(1.0, most * vehicles), 0.9 * greenery)),
                            seeded(seed));
      EXPECT_TRUE(scene.shares[0].met()) << scene.about;
      EXPECT_TRUE(scene.shares[1].met()) << scene.about;
      EXPECT_THAT(shareWarnings(scene), IsEmpty());
      EXPECT_THAT(scene.about, AllOf(HasSubstr("; vehicles "), HasSubstr(", greenery ")));
    }
  }
}

TEST_F(SceneShares, ChangeNeitherTheRoadsNorThePlaceThatIsDrawn) {
  const std::filesystem::path plain = town("");
  const std::vector<Vec3d> lane = readSceneLanes(plain, 3)->lane;
  const Scene before = readSceneToShares(plain, seeded(3));
  const Scene after = readSceneToShares(town("shares: {pedestrian: [0.01, 1]}"), seeded(3));
  EXPECT_EQ(readSceneLanes(folder_.path() / "place.yaml", 3)->lane, lane);
  const auto buildings = [](const Scene& scene) {
    std::vector<Affine> places;
    for (const Instance& i : scene.instances) {
      if (i.name.starts_with("house")) places.push_back(i.worldFromMesh);
    }
    return places;
  };
  EXPECT_FALSE(buildings(before).empty());
  EXPECT_EQ(buildings(before), buildings(after));
  EXPECT_TRUE(after.about.starts_with(before.about)) << after.about;
  EXPECT_GT(after.things(), before.things());
}

TEST_F(SceneShares, ThatCannotBeMetAreTold) {
  const Scene scene = readSceneToShares(town("shares: {car: [0.9, 1], bus: [0, 1]}"), seeded(1));
  EXPECT_THAT(shareWarnings(scene), testing::ElementsAre(AllOf(HasSubstr("place seed 1: car is "), HasSubstr("90 %"),
                                                               HasSubstr("vehicles"))));
  EXPECT_GT(scene.shares[0].found, 0) << "as near as can be";
}

// Whatever the points are labelled with: it is the same town, and other classes' scenes are read as ever.
TEST_F(SceneShares, DoNotDependOnThePipelinesLabels) {
  const std::filesystem::path file = town("shares: {tree: [0, 0.02]}");
  SceneOptions kitti = seeded(2);
  kitti.ontology = SCANMILL_SOURCE_DIR "/labels/semantic_kitti.yaml";
  const Scene one = readSceneToShares(file, seeded(2));
  const Scene other = readSceneToShares(file, kitti);
  EXPECT_EQ(one.about, other.about);
  EXPECT_EQ(one.instances.size(), other.instances.size());
  EXPECT_EQ(other.ontology.name, "semantic_kitti");
  // A box of a class that the scene's own ontology, here none at all, does not have.
  const std::filesystem::path box = folder_.write(
      "box.yaml",
      "{ontology: nowhere.yaml, materials: materials, objects: [{primitive: box, size: [1, 1, 1], class: moving-car, "
      "material: wood}]}");
  EXPECT_EQ(readSceneToShares(box, kitti).instances.size(), 1u);
}

TEST_F(SceneShares, AreTheSameForASeed) {
  const std::filesystem::path file = town("shares: {car: [0.02, 0.04]}");
  const Scene one = readSceneToShares(file, seeded(5));
  const Scene other = readSceneToShares(file, seeded(5));
  EXPECT_EQ(one.about, other.about);
  EXPECT_EQ(one.shares[0].found, other.shares[0].found);
  EXPECT_EQ(one.instances.size(), other.instances.size());
}

}  // namespace
}  // namespace scanmill
