#include "dataset/dataset_folder.h"

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "base/error.h"
#include "base/file.h"
#include "dataset/verify.h"
#include "tests/core/dataset/fixture.h"

namespace scanmill {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr auto kBytes = DatasetFolder::Check::Bytes;
const DatasetPlan kPlan{"plan", 1, {{"train", 1}}};

// Returns the message of the error that opening the folder throws.
std::string refusal(const fs::path& folder, FolderUse use, const DatasetPlan& plan = kPlan) {
  return messageOf<InputError>([&] { DatasetFolder(folder, use, plan); });
}

void publish(DatasetFolder& folder, const std::vector<Manifest>& parts) {
  Manifest manifest = testManifest();
  for (const Manifest& part : parts) {
    manifest.shards.push_back(part.shards[0]);
    manifest.samples.push_back(part.samples[0]);
    manifest.samples.back().shard = static_cast<std::uint32_t>(manifest.shards.size() - 1);
  }
  folder.publish(manifest);
}

// But for those of the members, which are no scans.
std::vector<std::string> problemsOf(const fs::path& folder) {
  std::vector<std::string> problems = verifyDataset(folder).problems;
  std::erase_if(problems, [](const std::string& p) { return p.find("no format reads '.bin'") != std::string::npos; });
  return problems;
}

TEST(DatasetFolder, AFolderThatIsNotEmptyIsLeftAlone) {
  const TemporaryFolder folder;
  folder.write("notes.txt", "mine");
  const std::string message = refusal(folder.path(), FolderUse::New);
  EXPECT_THAT(message, HasSubstr("exists and is not empty: choose another output folder"));
  EXPECT_THAT(message, HasSubstr(folder.path().string()));
  EXPECT_THAT(filesOf(folder.path()), ElementsAre("notes.txt"));
  const fs::path file = folder.path() / "notes.txt";
  EXPECT_THAT(refusal(file, FolderUse::Replace), HasSubstr("is a file"));
  EXPECT_THAT(refusal(file / "x", FolderUse::Replace), HasSubstr("Not a directory"));
}

TEST(DatasetFolder, LiesInNoOtherDataset) {
  const TemporaryFolder folder;
  folder.write("manifest.json", "{\"name\": \"a web page\"}");
  EXPECT_NO_THROW(DatasetFolder(folder.path() / "site", FolderUse::New, kPlan));
  fs::remove(folder.path() / "manifest.json");
  writeTestDataset(folder.path());
  for (const char* const inside : {"sub", "sub/sub/", "train"}) {
    EXPECT_THAT(refusal(folder.path() / inside, FolderUse::New),
                HasSubstr("is in the dataset " + folder.path().string() + ","));
  }
  EXPECT_FALSE(fs::exists(folder.path() / "sub"));
}

// The old dataset stays until the new one is whole; what is not ours stays for ever.
TEST(DatasetFolder, ReplacesTheOldDatasetAtTheEndAndNothingElse) {
  const TemporaryFolder folder;
  const Manifest old = writeTestDataset(folder.path());
  folder.write("notes.txt", "mine");
  folder.write("train/notes.txt", "mine too");
  folder.write("train/train.tar", "mine as well");
  folder.write("train/train-000000.tar.partial-mine", "mine");
  folder.write("manifest.json.partial-17", "of a killed run");
  {
    DatasetFolder replacing(folder.path(), FolderUse::Replace, kPlan);
    addShard(replacing, 0);
    EXPECT_EQ(toJson(readManifest(folder.path())), toJson(old));
  }
  EXPECT_EQ(toJson(readManifest(folder.path())), toJson(old)) << "an interrupted run costs nothing";
  for (const std::string& problem : verifyDataset(folder.path()).problems) {
    EXPECT_THAT(problem, testing::Not(HasSubstr(".scanmill"))) << "what is not finished is hidden";
  }
  {
    DatasetFolder replacing(folder.path(), FolderUse::Replace, kPlan);
    publish(replacing, {addShard(replacing, 0)});
  }
  EXPECT_THAT(filesOf(folder.path()),
              ElementsAre("dataset_card.md", "manifest.json", "notes.txt", "train/notes.txt", "train/train-000000.tar",
                          "train/train-000000.tar.partial-mine", "train/train.tar"));
  EXPECT_FALSE(fs::exists(folder.path() / "val")) << "empty folders go too";
  EXPECT_EQ(readManifest(folder.path()).samples.size(), 1u);
}

TEST(DatasetFolder, RefusesWhatItCannotTellApart) {
  const TemporaryFolder folder;
  writeTestDataset(folder.path());
  folder.write("train/train-000999.tar", "of somebody");
  const auto before = filesOf(folder.path());
  EXPECT_THAT(refusal(folder.path(), FolderUse::Replace),
              HasSubstr("train/train-000999.tar: exists, but the manifest does not list it: move it"));
  EXPECT_EQ(filesOf(folder.path()), before);

  const TemporaryFolder app;
  app.write("manifest.json", "{\"name\": \"a web application\"}");
  app.write("train/train-000000.tar", "of somebody");
  EXPECT_THAT(refusal(app.path(), FolderUse::Replace), HasSubstr("by hand"));
  EXPECT_THAT(filesOf(app.path()), ElementsAre("manifest.json", "train/train-000000.tar"));

  // WebDataset's usual names are no proof that a shard is ours.
  const TemporaryFolder web;
  web.write("train/train-000000.tar", "of somebody");
  EXPECT_THAT(refusal(web.path(), FolderUse::Replace), HasSubstr("no manifest lists it"));
  EXPECT_THAT(filesOf(web.path()), ElementsAre("train/train-000000.tar"));
}

TEST(DatasetFolder, RefusesFoldersOfOthers) {
  for (const std::string name : {"photo.jpg", "train/notes.txt", "src/deep/main.c", "My Files/x"}) {
    const TemporaryFolder folder;
    folder.write(name, "mine");
    EXPECT_THAT(refusal(folder.path(), FolderUse::Replace),
                AllOf(HasSubstr("has no dataset"), HasSubstr(name.substr(0, name.find('/')))));
    EXPECT_THAT(filesOf(folder.path()), ElementsAre(name));
  }
}

TEST(DatasetFolder, EmptySplitFoldersAreNoDataset) {
  const TemporaryFolder folder;
  fs::create_directories(folder.path() / "train");
  EXPECT_EQ(refusal(folder.path(), FolderUse::New), "accepted");
}

TEST(DatasetFolder, AnAbandonedRunWithoutAShardLeavesNothing) {
  const TemporaryFolder folder;
  {
    const DatasetFolder opened(folder.path() / "data", FolderUse::New, kPlan);
    ShardWriter shard(opened.staging(), "train/train-000000.tar", "train");
    shard.add(plainSample("k-0", 3000000));
  }
  EXPECT_FALSE(fs::exists(folder.path() / "data"));
}

// Whole shards are found again, damaged ones are not, and another plan is refused.
TEST(DatasetFolder, AnInterruptedRunCanBeResumed) {
  const TemporaryFolder folder;
  const fs::path data = folder.path() / "data";
  {
    DatasetFolder opened(data, FolderUse::Resume, kPlan);  // the same as a new one
    for (int i = 0; i < 3; ++i) addShard(opened, i);
  }
  EXPECT_THAT(messageOf<InputError>([&] { readManifest(data); }), HasSubstr("has an unfinished dataset"));
  EXPECT_THAT(refusal(data, FolderUse::New), AllOf(HasSubstr("--resume"), HasSubstr("--overwrite")));
  EXPECT_THAT(refusal(data, FolderUse::Resume, {"other", 1, {{"train", 1}}}), HasSubstr("another pipeline"));
  const fs::path damaged = data / ".scanmill/train/train-000001.tar";
  std::string bytes = readFile(damaged);
  bytes[700] ^= 1;
  writeFile(damaged, bytes);
  fs::remove(data / ".scanmill/train/train-000002.tar");
  DatasetFolder resumed(data, FolderUse::Resume, kPlan);
  const auto first = resumed.findRecord(shardName("train", 0), kBytes);
  ASSERT_TRUE(first.has_value());
  for (int i = 1; i < 4; ++i) EXPECT_FALSE(resumed.findRecord(shardName("train", i), kBytes).has_value()) << i;
  publish(resumed, {first->manifest, addShard(resumed, 1)});
  EXPECT_THAT(problemsOf(data), IsEmpty());
}

// Killed at any moment of publish(), the dataset can be resumed, or replaced, and nothing of the old one stays.
TEST(DatasetFolder, AMoveThatWasInterruptedGoesOn) {
  for (const bool resume : {true, false}) {
    for (int moment = 0; moment < 4; ++moment) {
      SCOPED_TRACE(moment);
      const TemporaryFolder folder;
      writeTestDataset(folder.path());
      Manifest whole = testManifest();
      {
        DatasetFolder replacing(folder.path(), FolderUse::Replace, kPlan);
        addShard(replacing, 0);
        addShard(replacing, 1);
      }
      const fs::path hidden = folder.path() / ".scanmill";
      // What publish() does, one step after the other.
      fs::rename(folder.path() / "manifest.json", hidden / "replaced.json");
      if (moment >= 1) fs::remove(folder.path() / "train/train-000000.tar");
      if (moment >= 2) fs::rename(hidden / "train/train-000000.tar", folder.path() / "train/train-000000.tar");
      if (moment >= 3) fs::remove_all(folder.path() / "val");
      EXPECT_THROW(readManifest(folder.path()), InputError);
      DatasetFolder again(folder.path(), resume ? FolderUse::Resume : FolderUse::Replace, kPlan);
      EXPECT_EQ(again.findRecord(shardName("train", 0), kBytes).has_value(), resume);
      std::vector<Manifest> parts;
      for (int i = 0; i < 2; ++i) {
        parts.push_back(resume ? again.findRecord(shardName("train", i), kBytes).value().manifest : addShard(again, i));
      }
      publish(again, parts);
      EXPECT_THAT(problemsOf(folder.path()), IsEmpty());
      EXPECT_EQ(readManifest(folder.path()).shards.size(), 2u);
    }
  }
}

TEST(DatasetFolder, OneProcessAtATimeWritesIntoIt) {
  const TemporaryFolder folder;
  const fs::path data = folder.path() / "data";
  int ready[2];
  ASSERT_EQ(::pipe(ready), 0);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const DatasetFolder held(data, FolderUse::New, kPlan);
    [[maybe_unused]] const auto told = ::write(ready[1], "x", 1);
    ::pause();
  }
  char letter = 0;
  ASSERT_EQ(::read(ready[0], &letter, 1), 1);
  for (const FolderUse each : {FolderUse::New, FolderUse::Replace, FolderUse::Resume}) {
    EXPECT_THAT(messageOf<InputError>([&] { DatasetFolder::check(data, each); }),
                AllOf(HasSubstr("is being written by process " + std::to_string(child)), HasSubstr("since")));
  }
  ::kill(child, SIGKILL);
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(refusal(data, FolderUse::Resume), "accepted") << "a dead process holds nothing";
}

// Processes that share a folder see each other's shards, claim what they make, and the last one ends the dataset.
TEST(DatasetFolder, SeveralMayShareIt) {
  const TemporaryFolder folder;
  const fs::path data = folder.path() / "data";
  const DatasetPlan plan{"plan", 2, {{"train", 2}}};
  auto one = std::make_unique<DatasetFolder>(data, FolderUse::Share, plan);
  auto two = std::make_unique<DatasetFolder>(data, FolderUse::Share, plan);
  EXPECT_FALSE(one->isComplete());
  EXPECT_THAT(refusal(data, FolderUse::Resume, plan), HasSubstr("is being written by"));
  EXPECT_THAT(refusal(data, FolderUse::Share, {"other", 2, {{"train", 2}}}), HasSubstr("another pipeline"));
  auto claim = one->claim(shardName("train", 0));
  EXPECT_NE(claim, nullptr);
  EXPECT_EQ(two->claim(shardName("train", 0)), nullptr);
  EXPECT_NE(two->claim(shardName("train", 1)), nullptr);
  const Manifest first = addShard(*one, 0);
  claim.reset();
  EXPECT_NE(two->claim(shardName("train", 0)), nullptr) << "given back";
  EXPECT_TRUE(two->findRecord(shardName("train", 0), kBytes).has_value());
  const Manifest second = addShard(*two, 1);
  EXPECT_FALSE(one->makeAlone());
  EXPECT_TRUE(two->makeAlone());
  one.reset();
  publish(*two, {first, second});
  two.reset();
  EXPECT_THAT(problemsOf(data), IsEmpty());
  const DatasetFolder late(data, FolderUse::Share, plan);
  EXPECT_TRUE(late.isComplete());
}

TEST(DatasetFolder, WhoSharesItAndMakesNothingLeavesNothing) {
  const TemporaryFolder folder;
  { const DatasetFolder opened(folder.path() / "data", FolderUse::Share, kPlan); }
  EXPECT_FALSE(fs::exists(folder.path() / "data"));
  folder.write("notes.txt", "mine");
  EXPECT_THAT(refusal(folder.path(), FolderUse::Share), HasSubstr("not empty"));
  EXPECT_THAT(filesOf(folder.path()), ElementsAre("notes.txt"));
}

// Beside a large number of samples the manifest would be too large: they are described beside their shards.
TEST(DatasetFolder, DescriptionsOfManySamplesLieBesideTheShards) {
  const TemporaryFolder plain;
  const Manifest manifest = writeTestDataset(plain.path());
  const TemporaryFolder folder;
  {
    DatasetFolder opened(folder.path(), FolderUse::Resume, kPlan);
    for (const ShardRecord& shard : manifest.shards) {
      fs::create_directories((opened.staging() / shard.file).parent_path());
      fs::copy_file(plain.path() / shard.file, opened.staging() / shard.file);
    }
    opened.publish(manifest, 1000);
  }
  const std::string text = readFile(folder.path() / "manifest.json");
  EXPECT_THAT(text, AllOf(HasSubstr("\"schema_version\": 3"), testing::Not(HasSubstr("world_from_sensor\": ["))));
  EXPECT_TRUE(fs::exists(folder.path() / "train/train-000000.json"));
  Manifest read = readManifest(folder.path());
  for (ShardRecord& shard : read.shards) {
    EXPECT_EQ(std::exchange(shard.samplesSha256, "").size(), 64u);
  }
  EXPECT_EQ(toJson(read), toJson(readManifest(plain.path()))) << "read, it is the same";
  EXPECT_EQ(verifyDataset(folder.path()).problems, verifyDataset(plain.path()).problems);

  const fs::path beside = folder.path() / "val/val-000000.json";
  const std::string sound = readFile(beside);
  for (std::size_t i = 0; i < sound.size(); i += 97) {
    std::string damaged = sound;
    damaged[i] ^= 2;
    writeFile(beside, damaged);
    EXPECT_THAT(messageOf<InputError>([&] { readManifest(folder.path()); }),
                AllOf(HasSubstr("val-000000.json"), HasSubstr("was changed")));
  }
  // Also where somebody has made the digests fit.
  const std::string stated = sha256(sound);
  for (const auto& [from, to] :
       {std::pair{"\"numbers\": [6,", "\"numbers\": [9,"}, {"\"numbers\": [6,", "\"numbers\": [0,"}}) {
    std::string forged = sound;
    ASSERT_NE(forged.find(from), std::string::npos);
    forged.replace(forged.find(from), std::string(from).size(), to);
    writeFile(beside, forged);
    std::string head = text;
    head.replace(head.find(stated), stated.size(), sha256(forged));
    writeFile(folder.path() / "manifest.json", head);
    EXPECT_THAT(messageOf<InputError>([&] { readManifest(folder.path()); }), HasSubstr("val-000000.json")) << to;
  }
  writeFile(folder.path() / "manifest.json", text);
  fs::remove(beside);
  EXPECT_THAT(messageOf<InputError>([&] { readManifest(folder.path()); }),
              AllOf(HasSubstr("val-000000.json"), HasSubstr("scanmill verify")));

  // Replaced, they go with their shards.
  {
    DatasetFolder replacing(folder.path(), FolderUse::Replace, kPlan);
    publish(replacing, {addShard(replacing, 0)});
  }
  EXPECT_THAT(filesOf(folder.path()), ElementsAre("dataset_card.md", "manifest.json", "train/train-000000.tar"));
}

TEST(DatasetFolder, ADatasetMayBeEmpty) {
  const TemporaryFolder folder;
  DatasetFolder(folder.path() / "data", FolderUse::New, kPlan).publish(testManifest());
  EXPECT_THAT(filesOf(folder.path() / "data"), ElementsAre("dataset_card.md", "manifest.json"));
  EXPECT_THAT(verifyDataset(folder.path() / "data").problems, IsEmpty());
}

}  // namespace
}  // namespace scanmill
