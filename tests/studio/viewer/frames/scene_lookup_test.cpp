#include "viewer/frames/scene_lookup.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/studio/viewer/frames/frame_fixture.h"

namespace scanmill {

namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

class SceneLookup : public testing::Test {
 protected:
  SceneLookup() {
    town = folder.write("scenes/town.yaml", "objects: []\n");
    old = folder.write("old/Old Town.v2.yaml", "objects: []\n");
  }

  std::optional<SceneChoice> of(const std::string& key, const std::string& text) {
    why.clear();
    return sceneOfSample(text, folder.path() / "out", key, time, why);
  }

  TemporaryFolder folder;
  fs::path town;
  fs::path old;
  std::string why;
  double time = 0;
};

TEST_F(SceneLookup, BySceneAndSeed) {
  const std::string text = "scenes:\n  - {scene: ../scenes/town.yaml, seeds: [3, 12]}\n  - {scene: \"" + old.string() +
                           "\"}\n  - scene: ../scenes/town\n    seeds: 4\n";
  EXPECT_EQ(of("town-s3-drive-000001", text), (SceneChoice{town, 3}));
  EXPECT_EQ(of("town-s12-drive-000001", text), (SceneChoice{town, 12}));
  EXPECT_EQ(of("town-s4-drive-000001", text), (SceneChoice{town, 4}));
  EXPECT_EQ(of("old_town_v2-s1-t0-000001", text), (SceneChoice{old, 1}));
  for (const char* key : {"town-s1-drive-000001", "town-s-drive-000001", "town-s3", "village-s3-drive-0", "town", ""}) {
    EXPECT_FALSE(of(key, text)) << key;
    EXPECT_THAT(why, AllOf(HasSubstr("names no scene"), HasSubstr("--scene FILE"))) << key;
  }
}

TEST_F(SceneLookup, OverridesCount) {
  const std::string text =
      "# --set scenes.0.seeds=[1]\nscenes: [{scene: ../scenes/town.yaml}]\n# a note\n# --set scenes.0.seeds=[7,\n# 8]\n"
      "# --set name=x\n";
  EXPECT_EQ(of("town-s7-drive-000001", text), (SceneChoice{town, 7}));
  EXPECT_EQ(of("town-s8-drive-000001", text), (SceneChoice{town, 8}));
  EXPECT_FALSE(of("town-s1-drive-000001", text));
}

TEST_F(SceneLookup, SeedsFromOneToAnother) {
  const std::string text = "scenes:\n  - {scene: ../scenes/town.yaml, seeds: [1, ..., 200]}\n";
  EXPECT_EQ(of("town-s150-drive-000001", text), (SceneChoice{town, 150}));
  EXPECT_FALSE(of("town-s201-drive-000001", text));
}

TEST_F(SceneLookup, AtTheTimeOfTheSampleWhereObjectsMove) {
  time = 3.5;
  const std::string moving = "scenes:\n  - {scene: ../scenes/town.yaml}\n";
  EXPECT_EQ(of("town-s1-drive-000001", moving), (SceneChoice{town, 1, 3.5}));
  const std::string still = "scenes:\n  - {scene: ../scenes/town.yaml, moving: false}\n";
  EXPECT_EQ(of("town-s1-drive-000001", still), (SceneChoice{town, 1, 0}));
}

TEST_F(SceneLookup, AmongTheProgramsOwn) {
  const auto street = of("street-s2-lane-000001", "scenes: [{scene: ../scenes/street.yaml, seeds: [2]}]");
  ASSERT_TRUE(street);
  EXPECT_TRUE(fs::equivalent(street->file, fs::path(SCANMILL_SOURCE_DIR) / "scenes/street.yaml"));
  ASSERT_TRUE(of("street-s1-lane-000001", "scenes: [{scene: street}]"));
}

TEST_F(SceneLookup, TheOwnVehicle) {
  const auto vehicle = [&](const std::string& text) { return vehicleOf(text, folder.path() / "out"); };
  const fs::path own = fs::path(SCANMILL_SOURCE_DIR) / "scenes/vehicle.yaml";
  EXPECT_EQ(vehicle("vehicle: vehicle\n"), own);
  EXPECT_EQ(vehicle("vehicle: {scene: vehicle, returns: drop}\n"), own);
  EXPECT_EQ(vehicle("vehicle: ../scenes/town.yaml\n"), town);
  for (const char* none : {"vehicle: null\n", "vehicle: absent\n", "name: x\n", "vehicle: [1]\n", "{"}) {
    EXPECT_FALSE(vehicle(none)) << none;
  }
}

TEST_F(SceneLookup, InFoldersAboveTheDataset) {
  const fs::path yard = folder.write("project/pipelines/yard.yaml", "objects: []\n");
  const fs::path data = folder.path() / "project/runs/monday";
  for (const char* scene : {"yard", "../pipelines/yard.yaml", "../../pipelines/yard.yaml"}) {
    const auto found = sceneOfSample(fmt::format("scenes: [{{scene: {}}}]", scene), data, "yard-s1-t0-000000", 0, why);
    ASSERT_TRUE(found) << scene << ": " << why;
    EXPECT_EQ(found->file, yard) << scene;
  }
}

TEST_F(SceneLookup, SaysWhatIsMissing) {
  EXPECT_FALSE(of("gone-s1-t0-000000", "scenes: [{scene: gone.yaml}]"));
  EXPECT_THAT(why, AllOf(HasSubstr("'gone.yaml'"), HasSubstr("--scene FILE")));
  for (const char* text : {"", "scenes: 3", "scenes: [3, {scene: [1]}]", "scenes: [",
                           "scenes: [{scene: '${SCANMILL_NONE}'}]", "[]\n# --set scenes.0=3"}) {
    EXPECT_FALSE(of("town-s1-t0-000000", text)) << text;
    EXPECT_THAT(why, HasSubstr("--scene FILE")) << text;
  }
}

TEST_F(SceneLookup, SeedOfKey) {
  EXPECT_EQ(seedOfKey("street-s3-lane-000012"), 3u);
  EXPECT_EQ(seedOfKey("old-street-s12-s4-000012"), 12u);
  EXPECT_EQ(seedOfKey("old-shop-s0-x"), 0u);
  EXPECT_EQ(seedOfKey("scan.pcd"), 1u);
  EXPECT_EQ(seedOfKey("a-s5"), 1u);
  EXPECT_EQ(seedOfKey("a-s99999999999999999999-x"), 1u);
}

// The manifest's pipeline, or the file that is given in its place.
TEST_F(SceneLookup, OfFrames) {
  const fs::path data = folder.path() / "out";
  writeChangedDataset(data, {.manifest = [](Manifest& m) {
                        m.pipelineText = "scenes: [{scene: ../scenes/town.yaml, seeds: [3]}]\n";
                        m.pipelineSha256 = sha256(m.pipelineText);
                      }});
  EXPECT_EQ(openFrames({.path = data})->scene(1, why), (SceneChoice{town, 3, 0.1}));
  EXPECT_EQ(openFrames({.path = data, .scene = old})->scene(1, why), (SceneChoice{old, 3, 0.1}));
  const fs::path shard = data / "train/train-000000.tar";
  EXPECT_EQ(openFrames({.path = shard})->scene(1, why), (SceneChoice{town, 3, 0.1}));
  fs::copy(shard, folder.path() / "lonely.tar");
  EXPECT_FALSE(openFrames({.path = folder.path() / "lonely.tar"})->scene(1, why));
  EXPECT_THAT(why, HasSubstr("--scene FILE"));
}

}  // namespace

}  // namespace scanmill
