// What cannot be opened says so at once; what is wrong with a part of a dataset leaves the rest to be seen.

#include "base/file.h"
#include "tests/studio/viewer/frames/frame_fixture.h"

namespace scanmill {

namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::string refusalOf(const ViewInput& input) {
  return messageOf<InputError>([&] { openFrames(input); });
}

class BadFrames : public testing::Test {
 protected:
  BadFrames() : data(folder.path() / "data"), manifest(writeTestDataset(data)) {}

  fs::path shardOf(std::size_t sample) const { return data / manifest.shards[manifest.samples[sample].shard].file; }

  // Frames of one shard have a problem that holds `words`, all others are whole.
  void expectOnlyShardIsBad(std::uint32_t shard, const std::string& words) const {
    const auto source = openFrames({.path = data});
    for (std::size_t i = 0; i < manifest.samples.size(); ++i) {
      const ViewFrame frame = source->load(i);
      if (manifest.samples[i].shard != shard) {
        EXPECT_THAT(frame.problems, IsEmpty()) << i;
        EXPECT_EQ(frame.scans.size(), 2u) << i;
      } else {
        EXPECT_THAT(frame.scans, IsEmpty()) << i;
        EXPECT_THAT(frame.problems, ElementsAre(AllOf(HasSubstr(manifest.shards[shard].file), HasSubstr(words)))) << i;
        EXPECT_EQ(frame.key, manifest.samples[i].key);
      }
    }
  }

  TemporaryFolder folder;
  fs::path data;
  Manifest manifest;
};

TEST_F(BadFrames, AMissingShard) {
  fs::remove(shardOf(0));
  expectOnlyShardIsBad(0, "is missing, although the manifest lists it");
}

TEST_F(BadFrames, ATruncatedShard) {
  const std::uint32_t shard = manifest.samples[7].shard;
  fs::resize_file(shardOf(7), fs::file_size(shardOf(7)) / 2);
  const auto source = openFrames({.path = data});
  std::size_t whole = 0;
  bool behind = false;
  for (std::size_t i = 0; i < manifest.samples.size(); ++i) {
    const ViewFrame frame = source->load(i);
    if (manifest.samples[i].shard != shard) {
      EXPECT_EQ(frame.scans.size(), 2u) << i;
      EXPECT_THAT(frame.problems, IsEmpty()) << i;
      continue;
    }
    EXPECT_FALSE(behind && !frame.scans.empty()) << "what follows an unreadable frame is unreadable, too: " << i;
    behind = frame.scans.empty();
    whole += frame.scans.size() == 2 ? 1 : 0;
    ASSERT_FALSE(frame.problems.empty()) << i;
    EXPECT_THAT(frame.problems, Each(AllOf(HasSubstr(manifest.shards[shard].file), HasSubstr("truncated")))) << i;
    for (const ViewScan& scan : frame.scans) EXPECT_GT(scan.scan.size(), 0u);
  }
  EXPECT_GT(whole, 0u) << "what lies before the cut";
  EXPECT_TRUE(behind);
}

TEST_F(BadFrames, AShardAloneGivesWhatLiesBeforeTheCut) {
  const fs::path cut = folder.path() / "cut.tar";
  fs::copy_file(shardOf(0), cut);
  const std::size_t all = openFrames({.path = cut})->keys().size();
  fs::resize_file(cut, fs::file_size(cut) / 2);
  const auto source = openFrames({.path = cut});
  EXPECT_LT(source->keys().size(), all);
  ASSERT_GT(source->keys().size(), 0u);
  const ViewFrame frame = source->load(0);
  EXPECT_FALSE(frame.scans.empty());
  EXPECT_THAT(frame.problems, ElementsAre(AllOf(HasSubstr("cut.tar"), HasSubstr("what lies before that"))));
}

TEST_F(BadFrames, AShardThatIsNoTar) {
  const std::uint32_t shard = manifest.samples[8].shard;
  writeFile(shardOf(8), std::string(4000, 'x'));
  expectOnlyShardIsBad(shard, "cannot be read as tar");
}

TEST_F(BadFrames, AMissingShardThatComesBack) {
  const fs::path aside = folder.path() / "aside.tar";
  fs::rename(shardOf(0), aside);
  const auto source = openFrames({.path = data});
  EXPECT_THAT(source->load(0).scans, IsEmpty());
  fs::rename(aside, shardOf(0));
  EXPECT_EQ(source->load(0).scans.size(), 2u);
}

TEST_F(BadFrames, ADamagedMember) {
  Members members = membersOf(shardOf(0));
  const std::string key = manifest.samples[0].key;
  for (auto& [name, bytes] : members) {
    if (name == key + ".top.ray_tracing.pcd") bytes = "broken";  // CSV is left
    if (name.starts_with(key + ".rear") && !name.ends_with("json")) bytes = "broken";
  }
  writeMembers(shardOf(0), members);
  const auto source = openFrames({.path = data});
  const ViewFrame frame = source->load(0);
  EXPECT_THAT(namesOf(frame), ElementsAre("top"));
  EXPECT_EQ(frame.scans[0].scan.size(), testScan(manifest.sensors[0].beams, 0).size());
  EXPECT_THAT(frame.problems, ElementsAre(AllOf(HasSubstr("rear.ray_tracing.pcd"), HasSubstr("rear.ray_tracing.csv"))));
  EXPECT_THAT(source->load(1).problems, IsEmpty());
}

TEST_F(BadFrames, AMemberThatIsNotThere) {
  Members members = membersOf(shardOf(0));
  std::erase_if(members, [](const auto& m) { return m.first.find(".top.") != std::string::npos; });
  writeMembers(shardOf(0), members);
  const ViewFrame frame = openFrames({.path = data})->load(0);
  EXPECT_THAT(namesOf(frame), ElementsAre("Rear"));
  EXPECT_THAT(frame.problems, ElementsAre(AllOf(HasSubstr("has no member"), HasSubstr(".top.ray_tracing.pcd"))));
}

TEST_F(BadFrames, WhatCannotBeOpened) {
  const fs::path none = folder.path() / "none", noneYaml = folder.path() / "none.yaml";
  const fs::path one = folder.write("one.pcd", encode("pcd", testScan(manifest.sensors[0].beams, 4)));
  const fs::path recording = folder.write("recorded/recording.json", "{\"kind\": \"hits\"}").parent_path();
  const fs::path cut = folder.write("cut/manifest.json", "{\"schema").parent_path();
  writeMembers(folder.path() / "notes.tar", {{"a.txt", "x"}});
  const std::pair<ViewInput, std::vector<const char*>> cases[]{
      {{.path = none}, {"none", "does not exist"}},
      {{.path = noneYaml}, {"does not exist"}},
      {{.path = folder.write("scan.txt", "1 2 3")}, {".tar, .pcd", ".yaml"}},
      {{.path = folder.write("scan", "1 2 3")}, {".tar, .pcd"}},
      {{.path = folder.write("scan.pcd", "broken")}, {"scan.pcd"}},
      {{.path = folder.write("scan.tar", "broken")}, {"scan.tar"}},
      {{.path = folder.write("a.exr", "v")}, {"a.exr", "viewed by itself"}},
      {{.path = data, .over = {none}}, {"does not exist"}},
      {{.path = data, .reference = none}, {"does not exist"}},
      {{.path = data, .ontology = noneYaml}, {"none.yaml"}},
      {{.path = data, .scene = noneYaml}, {"none.yaml"}},
      {{.path = folder.write("empty/notes.txt", "x").parent_path()}, {"is not a dataset", "manifest.json"}},
      {{.path = recording}, {"is a recording"}},
      {{.path = cut}, {"manifest.json"}},
      {{.path = folder.path() / "notes.tar"}, {"holds no sample"}},
      {{.path = folder.write("p.yaml", "scenes: []\nsensors: []\n")}, {"is a pipeline", "scanmill generate", "p.yaml"}},
      {{.path = folder.write("o.yaml", "classes: []\n")}, {"is an ontology"}},
      {{.path = folder.write("x.yaml", "a: 1\n")}, {"is no scene"}},
      {{.path = folder.write("y.yaml", "a: [1\n")}, {"y.yaml:"}},
      {{.path = one, .over = {data}}, {"is a single scan", "--over"}},
      {{.path = one, .reference = data}, {"is a single scan"}},
      {{.path = one, .sensor = "top"}, {"is a single scan"}}};
  for (const auto& [input, words] : cases) {
    const std::string says = refusalOf(input);
    for (const char* word : words) EXPECT_THAT(says, HasSubstr(word)) << input.path;
  }
  EXPECT_EQ(refusalOf({.path = one, .over = {one}, .reference = one}), "accepted");
}

TEST_F(BadFrames, ASampleWithoutScans) {
  writeMembers(folder.path() / "x.tar",
               {{"a-0.json", "{}"}, {"b-0.top.pcd", encode("pcd", testScan(testBeams(2, 4), 1))}});
  const auto source = openFrames({.path = folder.path() / "x.tar"});
  EXPECT_THAT(source->keys(), ElementsAre("b-0"));
  EXPECT_THAT(source->load(0).problems, IsEmpty());
}

}  // namespace

}  // namespace scanmill
