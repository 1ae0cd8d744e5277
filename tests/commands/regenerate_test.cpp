// Damaged parts of datasets, made again by the program.

#include <map>

#include "base/file.h"
#include "base/hash.h"
#include "dataset/manifest.h"
#include "dataset/names.h"
#include "tests/commands/program.h"
#include "tests/support/described_beside.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class Regenerate : public SmallWorld {
 protected:
  void SetUp() override {
    SmallWorld::SetUp();
    const Outcome made = scanmill({"generate", pipeline_, "-q", "-o", at("out"), "--set",
                                   "output={formats: [csv, pcd], shard_samples: 1}", "--set",
                                   "effects=[{range_noise: {sigma_m: 0.02}}]", "--seed", "7"});
    ASSERT_EQ(made.code, 0) << made.error;
    whole_ = contents();
    ASSERT_GE(whole_.size(), 4u);
  }

  std::map<std::string, std::string> contents() const {
    std::map<std::string, std::string> files;
    for (const auto& file : filesEndingIn("", at("out"))) {
      files[file.lexically_relative(at("out")).string()] = readFile(file);
    }
    return files;
  }

  std::string shard(std::size_t number) const { return at("out/" + readManifest(at("out")).shards[number].file); }
  // Returns the file that describes the samples of a shard in train.
  std::string beside(std::size_t number) const { return at("out/" + samplesFileOf(shardName("train", number))); }

  void damage(const std::string& file) const {
    std::string bytes = readFile(file);
    bytes[bytes.size() / 2] ^= 1;
    writeFile(file, bytes);
  }

  std::map<std::string, std::string> whole_;
};

TEST_F(Regenerate, MendsWhatIsDamagedOrMissing) {
  damage(shard(0));
  std::filesystem::remove(shard(1));
  const Outcome bad = scanmill({"verify", "-q", at("out")});
  EXPECT_EQ(bad.code, 1);
  EXPECT_THAT(bad.error, AllOf(HasSubstr(readManifest(at("out")).samples[0].key), HasSubstr("was changed since")));
  const Outcome mended = scanmill({"regenerate", "-q", at("out")});
  EXPECT_EQ(mended.code, 0) << mended.error;
  EXPECT_THAT(mended.out, HasSubstr("again, with the same bytes: 0-1"));
  EXPECT_TRUE(contents() == whole_);
  EXPECT_THAT(scanmill({"regenerate", "-q", at("out")}).out, HasSubstr("shards are undamaged"));
  EXPECT_EQ(scanmill({"regenerate", "-q", at("out"), "--shards", "1"}).code, 0);
  EXPECT_TRUE(contents() == whole_);
}

TEST_F(Regenerate, MendsDescriptionsBesideTheShards) {
  describeBesideShards(at("out"));
  whole_ = contents();
  damage(shard(0));
  damage(beside(0));
  std::filesystem::remove(beside(1));
  std::filesystem::resize_file(beside(2), 100);
  const auto names = AllOf(HasSubstr("train-000000.json: was changed"), HasSubstr("train-000001.json: cannot be read"),
                           HasSubstr("train-000002.json: was changed"));
  const Outcome bad = scanmill({"verify", "-q", at("out")});
  EXPECT_EQ(bad.code, 1);
  EXPECT_THAT(bad.error, names);
  const Outcome info = scanmill({"info", at("out")});
  EXPECT_EQ(info.code, 0);
  EXPECT_THAT(info.out, HasSubstr("dataset small: 4 samples"));
  EXPECT_THAT(info.error, AllOf(names, HasSubstr("3 of 4 shards are not counted: `scanmill regenerate")));
  const Outcome mended = scanmill({"regenerate", "-q", at("out")});
  EXPECT_EQ(mended.code, 0) << mended.error;
  EXPECT_THAT(mended.out, HasSubstr("made 3 of 4 shards again, with the same bytes: 0-2"));
  EXPECT_TRUE(contents() == whole_);
  EXPECT_EQ(scanmill({"verify", "-q", at("out")}).code, 0);

  std::string manifest = readFile(at("out/manifest.json"));
  const std::string stated = sha256(readFile(beside(3)));
  manifest.replace(manifest.find(stated), 4, stated.starts_with("0000") ? "1111" : "0000");
  writeFile(at("out/manifest.json"), manifest);
  const auto before = contents();
  const Outcome refused = scanmill({"regenerate", "-q", at("out")});
  EXPECT_EQ(refused.code, 2) << refused.out;
  EXPECT_THAT(refused.error, AllOf(HasSubstr("manifest.json: was changed since"), HasSubstr("--overwrite")));
  EXPECT_TRUE(contents() == before);
}

// Of what the scene names the manifest says nothing: the bytes tell.
TEST_F(Regenerate, AnAssetThatHasChangedIsFoundByTheBytes) {
  const auto wall = [&](const std::string& x) {
    folder_.write("wall.obj", "v " + x + " -9 0\nv " + x + " 9 0\nv " + x + " 9 5\nv " + x + " -9 5\nf 1 2 3 4\n");
  };
  std::string scene = readFile(at("scene.yaml"));
  folder_.write("scene.yaml", scene + "  - {name: own, file: wall.obj, class: wall, material: brick}\n");
  wall("15");
  ASSERT_EQ(scanmill({"generate", pipeline_, "-q", "-o", at("out"), "--overwrite"}).code, 0);
  damage(shard(0));
  const auto before = contents();
  wall("14");
  const Outcome refused = scanmill({"regenerate", "-q", at("out")});
  EXPECT_EQ(refused.code, 1) << refused.out;
  EXPECT_THAT(refused.error, AllOf(HasSubstr("made again, its bytes differ"), HasSubstr("nothing was replaced")));
  EXPECT_TRUE(contents() == before);
  wall("15");
  EXPECT_EQ(scanmill({"regenerate", "-q", at("out")}).code, 0);
  EXPECT_EQ(scanmill({"verify", "-q", at("out")}).code, 0);
}

// Where the scene has changed, nothing is replaced.
TEST_F(Regenerate, WhatWouldComeOutOtherwiseIsRefused) {
  damage(shard(0));
  const auto before = contents();
  std::string scene = readFile(at("scene.yaml"));
  scene.replace(scene.find("position: [20,"), 14, "position: [19,");
  writeFile(at("scene.yaml"), scene);
  const Outcome refused = scanmill({"regenerate", "-q", at("out")});
  EXPECT_EQ(refused.code, 2) << refused.out;
  EXPECT_THAT(refused.error, HasSubstr("its pipeline now gives other samples"));
  EXPECT_TRUE(contents() == before);
  std::filesystem::remove(at("scene.yaml"));
  const Outcome lost = scanmill({"regenerate", "-q", at("out")});
  EXPECT_EQ(lost.code, 2) << lost.out;
  EXPECT_THAT(lost.error, HasSubstr("--pipeline FILE"));
  EXPECT_TRUE(contents() == before);
}

}  // namespace
}  // namespace scanmill
