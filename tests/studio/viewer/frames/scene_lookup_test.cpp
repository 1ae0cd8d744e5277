#include "tests/studio/viewer/frames/frame_fixture.h"
#include "viewer/frames/frame_source.h"

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

  static SequenceRecord of(const std::string& sceneFile, bool moving = true) {
    return {"town-s3-drive", "town", sceneFile, 3, "drive", moving, ""};
  }

  TemporaryFolder folder;
  fs::path town;
  fs::path old;
  std::string why;
};

// A path from the folder of the pipeline file, which may be any folder above the dataset or a usual one in it.
TEST_F(SceneLookup, FromTheFoldersAboveTheDataset) {
  const fs::path yard = folder.write("project/pipelines/yard.yaml", "objects: []\n");
  const fs::path data = folder.path() / "project/runs/monday";
  for (const char* scene : {"yard.yaml", "../pipelines/yard.yaml", "pipelines/yard.yaml"}) {
    const SequenceRecord sequence = of(scene);
    EXPECT_EQ(sceneOf(&sequence, data, 0, why), (SceneChoice{yard, 3})) << scene << ": " << why;
  }
}

TEST_F(SceneLookup, AmongTheProgramsOwn) {
  const SequenceRecord sequence = of("scanmill:scenes/street.yaml");
  const auto street = sceneOf(&sequence, folder.path() / "out", 0, why);
  ASSERT_TRUE(street);
  EXPECT_TRUE(fs::equivalent(street->file, fs::path(SCANMILL_SOURCE_DIR) / "scenes/street.yaml"));
}

TEST_F(SceneLookup, SaysWhatIsMissing) {
  const SequenceRecord gone = of("gone.yaml");
  EXPECT_FALSE(sceneOf(&gone, folder.path() / "out", 0, why));
  EXPECT_THAT(why, AllOf(HasSubstr("'gone.yaml'"), HasSubstr("--scene FILE")));
  const SequenceRecord recorded = of("");
  for (const SequenceRecord* sequence : {&recorded, static_cast<const SequenceRecord*>(nullptr)}) {
    EXPECT_FALSE(sceneOf(sequence, folder.path() / "out", 0, why));
    EXPECT_THAT(why, AllOf(HasSubstr("does not say"), HasSubstr("--scene FILE")));
  }
}

// The scene and its seed that the manifest states, whatever the names of scene, trajectory and sample; or the file that
// is given in its place.
TEST_F(SceneLookup, OfFrames) {
  const fs::path data = folder.path() / "out";
  const auto write = [&](const fs::path& at, bool moving) {
    writeChangedDataset(at, {.manifest = [&](Manifest& m) {
                          m.sequences = {of("scenes/town.yaml", moving)};
                          m.sequences.front().seed = 12;
                          m.sequences.front().vehicle = "scanmill:scenes/vehicle.yaml";
                        }});
  };
  write(data, true);
  EXPECT_EQ(openFrames({.path = data})->scene(1, why), (SceneChoice{town, 12, 0.1}));
  EXPECT_EQ(openFrames({.path = data, .scene = old})->scene(1, why), (SceneChoice{old, 12, 0.1}));
  EXPECT_EQ(openFrames({.path = data, .scene = old, .seed = 5})->scene(1, why), (SceneChoice{old, 5, 0.1}));
  EXPECT_EQ(openFrames({.path = data})->vehicle(), fs::path(SCANMILL_SOURCE_DIR) / "scenes/vehicle.yaml");
  const fs::path shard = data / "train/train-000000.tar";
  EXPECT_EQ(openFrames({.path = shard})->scene(1, why), (SceneChoice{town, 12, 0.1}));
  fs::copy(shard, folder.path() / "lonely.tar");
  EXPECT_FALSE(openFrames({.path = folder.path() / "lonely.tar"})->scene(1, why));
  EXPECT_THAT(why, HasSubstr("--scene FILE"));
  write(folder.path() / "still", false);
  EXPECT_EQ(openFrames({.path = folder.path() / "still"})->scene(1, why), (SceneChoice{town, 12, 0}));
}

}  // namespace

}  // namespace scanmill
