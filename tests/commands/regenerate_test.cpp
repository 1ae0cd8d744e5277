// Damaged parts of datasets, made again by the program.

#include <map>

#include "base/file.h"
#include "dataset/manifest.h"
#include "tests/commands/program.h"

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

TEST_F(Regenerate, ASampleAloneIsTheOneInItsShard) {
  const SampleRecord sample = readManifest(at("out")).samples[1];
  const Outcome made = scanmill({"regenerate", "-q", at("out"), "--sample", sample.key, "-o", at("one")});
  EXPECT_EQ(made.code, 0) << made.error;
  const std::string tar = readFile(shard(sample.shard));
  for (const std::string& member : sample.members) {
    EXPECT_NE(tar.find(readFile(std::filesystem::path(at("one")) / member)), std::string::npos) << member;
  }
  EXPECT_EQ(filesEndingIn("", at("one")).size(), sample.members.size());
  EXPECT_TRUE(contents() == whole_);
  const Outcome none = scanmill({"regenerate", at("out"), "--sample", sample.key + "0", "-o", at("none")});
  EXPECT_EQ(none.code, 2);
  EXPECT_THAT(none.error, HasSubstr("did you mean '" + sample.key));
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
