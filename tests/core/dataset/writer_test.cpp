#include "dataset/writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <nlohmann/json.hpp>
#include <set>

#include "base/error.h"
#include "base/file.h"
#include "dataset/verify.h"
#include "tests/core/dataset/fixture.h"

namespace scanmill {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Relative names of all files, sorted.
std::vector<std::string> filesOf(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_directory()) names.push_back(fs::relative(entry.path(), folder).generic_string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

Sample plainSample(const std::string& key, std::size_t bytes, const std::string& split = "train") {
  return {key, split, {}, {{"bin", std::string(bytes, 'x')}}};
}

TEST(DatasetWriter, WritesShardsAndTheManifest) {
  const TemporaryFolder folder;
  const Manifest manifest = writeTestDataset(folder.path() / "new" / "data");
  const Manifest read = readManifest(folder.path() / "new" / "data");
  EXPECT_EQ(toJson(read), toJson(manifest));
  EXPECT_EQ(read.samples.size(), 9u);
  EXPECT_GT(read.shards.size(), 4u);
  std::vector<std::string> expected{"manifest.json"};
  std::uint64_t samples = 0;
  for (const ShardRecord& shard : read.shards) {
    expected.push_back(shard.file);
    samples += shard.samples;
    const std::string bytes = readFile(folder.path() / "new" / "data" / shard.file);
    EXPECT_EQ(bytes.size(), shard.bytes);
    EXPECT_EQ(sha256(bytes), shard.sha256);
    EXPECT_TRUE(shard.bytes <= 30000 || shard.samples == 1) << shard.file;
  }
  EXPECT_EQ(samples, 9u);
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(filesOf(folder.path() / "new" / "data"), expected);
}

TEST(DatasetWriter, SameSamplesGiveTheSameBytes) {
  const TemporaryFolder a;
  const TemporaryFolder b;
  writeTestDataset(a.path());
  writeTestDataset(b.path());
  ASSERT_EQ(filesOf(a.path()), filesOf(b.path()));
  for (const std::string& name : filesOf(a.path())) {
    EXPECT_EQ(readFile(a.path() / name), readFile(b.path() / name)) << name;
  }
}

// What add() was given comes back, with the JSON member first; members of a sample follow each other and share the name
// up to the first dot; suffixes are lower-case and unique.
TEST(DatasetWriter, FollowsTheLawOfWebDataset) {
  const TemporaryFolder folder;
  const Manifest manifest = writeTestDataset(folder.path());
  std::set<std::string> seenKeys;
  std::size_t next = 0;
  for (const ShardRecord& shard : manifest.shards) {
    std::string current;
    std::set<std::string> suffixes;
    for (const auto& [name, bytes] : membersOf(folder.path() / shard.file)) {
      const std::string key = name.substr(0, name.find('.'));
      const std::string suffix = name.substr(name.find('.') + 1);
      if (key != current) {
        EXPECT_TRUE(seenKeys.insert(key).second) << key << " is in two places";
        EXPECT_EQ(suffix, "json");
        EXPECT_EQ(manifest.samples[next].key, key);
        ++next;
        current = key;
        suffixes.clear();
      }
      EXPECT_TRUE(suffixes.insert(suffix).second) << name;
      EXPECT_EQ(std::count_if(suffix.begin(), suffix.end(), [](char c) { return c >= 'A' && c <= 'Z'; }), 0) << name;
      const Sample sample = testSample(testManifest(), static_cast<std::uint32_t>(next - 1), key, shard.split);
      for (const Member& member : sample.members) {
        if (member.suffix != suffix) continue;
        EXPECT_EQ(member.bytes, bytes) << name;
      }
    }
  }
  EXPECT_EQ(next, 9u);
}

TEST(DatasetWriter, PythonsTarfileReadsTheShards) {
  if (std::system("/usr/bin/python3 -c 'import tarfile' >/dev/null 2>&1") != 0) GTEST_SKIP() << "python3 is absent";
  const TemporaryFolder folder;
  DatasetWriter writer(folder.path() / "data", false, 1 << 20);
  const std::string longKey(180, 'k');  // too long for ustar
  writer.add(plainSample("a-000000", 700));
  writer.add(plainSample(longKey, 0));
  writer.add(plainSample("b-000000", 512));
  Manifest manifest;
  writer.finish(manifest);
  const fs::path script = folder.write("list.py", R"(
import hashlib, sys, tarfile
with tarfile.open(sys.argv[1], 'r:') as tar:
    for m in tar:
        print(m.name, m.size, oct(m.mode), m.mtime, m.uid, m.gid, m.uname + '|' + m.gname, m.isreg(),
              hashlib.sha256(tar.extractfile(m).read()).hexdigest(), 'path' in m.pax_headers)
)");
  const fs::path out = folder.path() / "out";
  const std::string command =
      "/usr/bin/python3 '" + script.string() + "' '" + (folder.path() / "data/train/train-000000.tar").string() + "'";
  ASSERT_EQ(std::system((command + " > '" + out.string() + "'").c_str()), 0);
  std::string expected;
  for (const auto& [name, bytes] : membersOf(folder.path() / "data/train/train-000000.tar")) {
    expected += name + " " + std::to_string(bytes.size()) + " 0o644 0 0 0 | True " + sha256(bytes) + " " +
                (name.size() > 100 ? "True" : "False") + "\n";
  }
  EXPECT_EQ(readFile(out), expected);
  EXPECT_EQ(membersOf(folder.path() / "data/train/train-000000.tar").size(), 6u);
}

// The size that decides when a shard is full is the true one, long names included.
TEST(DatasetWriter, CountsBytesExactly) {
  const TemporaryFolder folder;
  DatasetWriter writer(folder.path() / "data", false, 20000);
  for (std::size_t i = 0; i < 40; ++i) {
    writer.add(plainSample("k" + std::to_string(i) + std::string(i * 5, 'k'), i * 100, i % 3 == 0 ? "val" : "train"));
  }
  const std::uint64_t counted = writer.bytesWritten();
  Manifest manifest;
  writer.finish(manifest);
  std::uint64_t bytes = 0;
  for (const ShardRecord& shard : manifest.shards) {
    bytes += shard.bytes;
    EXPECT_LE(shard.bytes, 20000u);
  }
  EXPECT_EQ(counted, bytes);
  EXPECT_EQ(writer.bytesWritten(), bytes);
  EXPECT_GT(manifest.shards.size(), 3u);
}

TEST(DatasetWriter, ASampleLargerThanAShardStandsAlone) {
  const TemporaryFolder folder;
  DatasetWriter writer(folder.path() / "data", false, 1);
  for (int i = 0; i < 3; ++i) writer.add(plainSample("k-" + std::to_string(i), 100));
  Manifest manifest;
  writer.finish(manifest);
  ASSERT_EQ(manifest.shards.size(), 3u);
  for (const ShardRecord& shard : manifest.shards) EXPECT_EQ(shard.samples, 1u);
}

TEST(DatasetWriter, RefusesNamesThatReadersWouldMisread) {
  const TemporaryFolder folder;
  DatasetWriter writer(folder.path() / "data", false, 1 << 20);
  const auto refusal = [&](const Sample& sample) { return messageOf<Error>([&] { writer.add(sample); }); };
  for (const char* key : {"", "a.b", "a/b", "a b",
                          "stra\xC3\x9F"
                          "e",
                          "a\nb", "a\\b"}) {
    EXPECT_THAT(refusal(plainSample(key, 1)), HasSubstr("sample '" + std::string(key) + "'"));
  }
  for (const char* suffix : {"", ".pcd", "PCD", "a/b", "json", "a b"}) {
    EXPECT_THAT(refusal({"key", "train", {}, {{suffix, "x"}}}), HasSubstr("sample 'key'")) << suffix;
  }
  EXPECT_THAT(refusal({"key", "train", {}, {{"pcd", "x"}, {"pcd", "y"}}}), HasSubstr("'pcd' is there twice"));
  for (const char* split : {"", "../x", "Train", "a.b"}) {
    EXPECT_THAT(refusal({"key", split, {}, {}}), HasSubstr("no name of a split"));
  }
  // None of these left a trace.
  writer.add(plainSample("good-0", 1));
  EXPECT_THAT(refusal(plainSample("good-0", 1)), HasSubstr("its key was written before"));
  Manifest manifest;
  writer.finish(manifest);
  EXPECT_EQ(manifest.samples.size(), 1u);
  EXPECT_THROW(writer.finish(manifest), Error);
  EXPECT_THAT(refusal(plainSample("late-0", 1)), HasSubstr("finished"));
}

TEST(DatasetWriter, AFolderThatIsNotEmptyIsLeftAlone) {
  const TemporaryFolder folder;
  folder.write("notes.txt", "mine");
  const std::string message = messageOf<InputError>([&] { DatasetWriter(folder.path(), false, 1 << 20); });
  EXPECT_THAT(message, HasSubstr("--overwrite"));
  EXPECT_THAT(message, HasSubstr(folder.path().string()));
  EXPECT_THAT(filesOf(folder.path()), ElementsAre("notes.txt"));
  const fs::path file = folder.path() / "notes.txt";
  EXPECT_THAT(messageOf<InputError>([&] { DatasetWriter(file, true, 1 << 20); }), HasSubstr("is a file"));
  EXPECT_THAT(messageOf<InputError>([&] { DatasetWriter(file / "x", true, 1 << 20); }), HasSubstr("Not a directory"));
}

TEST(DatasetWriter, OverwritingRemovesTheOldDatasetAndNothingElse) {
  const TemporaryFolder folder;
  const Manifest old = writeTestDataset(folder.path());
  folder.write("notes.txt", "mine");
  folder.write("train/notes.txt", "mine too");
  folder.write("train/train.tar", "mine as well");
  folder.write("train/train-000000.tar.partial-17", "of a killed run");
  folder.write("train/train-000000.tar.partial-mine", "mine");
  folder.write("manifest.json.partial-17", "of a killed run");
  {
    const DatasetWriter writer(folder.path(), true, 1 << 20);
    EXPECT_THAT(filesOf(folder.path()),
                ElementsAre("notes.txt", "train/notes.txt", "train/train-000000.tar.partial-mine", "train/train.tar"));
    EXPECT_FALSE(fs::exists(folder.path() / "val")) << "empty folders go too";
  }
  // What is left is no dataset.
  EXPECT_THAT(messageOf<InputError>([&] { DatasetWriter(folder.path(), true, 1 << 20); }),
              HasSubstr("holds no dataset"));
  for (const std::string& name : filesOf(folder.path())) fs::remove(folder.path() / name);
  writeTestDataset(folder.path(), true);
  EXPECT_EQ(toJson(readManifest(folder.path())), toJson(old));
}

TEST(DatasetWriter, OverwritingRefusesWhatItCannotTellApart) {
  const TemporaryFolder folder;
  writeTestDataset(folder.path());
  folder.write("train/train-000999.tar", "of somebody");
  const auto before = filesOf(folder.path());
  EXPECT_THAT(messageOf<InputError>([&] { DatasetWriter(folder.path(), true, 1 << 20); }),
              HasSubstr("train/train-000999.tar: is in the way"));
  EXPECT_EQ(filesOf(folder.path()), before);

  const TemporaryFolder app;
  app.write("manifest.json", "{\"name\": \"a web application\"}");
  app.write("train/train-000000.tar", "of somebody");
  EXPECT_THAT(messageOf<InputError>([&] { DatasetWriter(app.path(), true, 1 << 20); }), HasSubstr("by hand"));
  EXPECT_THAT(filesOf(app.path()), ElementsAre("manifest.json", "train/train-000000.tar"));
}

// A run that dies leaves whole shards and temporary files, but no manifest, and no shard that is cut.
TEST(DatasetWriter, AKilledRunLeavesNothingThatLooksFinished) {
  const TemporaryFolder folder;
  const fs::path data = folder.path() / "data";
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    DatasetWriter writer(data, false, 1 << 20);
    for (int i = 0; i < 5; ++i) writer.add(plainSample("k-" + std::to_string(i), 700000));
    writer.add(plainSample("v-0", 3000000, "val"));
    ::kill(::getpid(), SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_FALSE(fs::exists(data / "manifest.json"));
  int whole = 0;
  int partial = 0;
  for (const std::string& name : filesOf(data)) {
    if (name.ends_with(".tar")) {
      EXPECT_EQ(membersOf(data / name).size(), 2u) << name;
      ++whole;
    } else {
      EXPECT_THAT(name, HasSubstr(".tar.partial-" + std::to_string(child)));
      ++partial;
    }
  }
  EXPECT_EQ(whole, 4);
  EXPECT_EQ(partial, 2);
  EXPECT_THAT(messageOf<InputError>([&] { readManifest(data); }), HasSubstr("did not end"));

  // Without a manifest nobody can tell whose the folder is, if there is more in it.
  folder.write("data/notes.txt", "mine");
  EXPECT_THAT(messageOf<InputError>([&] { DatasetWriter(data, true, 1 << 20); }), HasSubstr("'notes.txt'"));
  fs::remove(data / "notes.txt");
  EXPECT_THAT(messageOf<InputError>([&] { DatasetWriter(data, false, 1 << 20); }), HasSubstr("--overwrite"));
  const DatasetWriter again(data, true, 1 << 20);
  EXPECT_THAT(filesOf(data), IsEmpty());
}

TEST(DatasetWriter, OverwritingRefusesFoldersOfOthers) {
  for (const std::string name : {"photo.jpg", "train/notes.txt", "src/deep/main.c", "My Files/x"}) {
    const TemporaryFolder folder;
    folder.write(name, "mine");
    folder.write("train/train-000000.tar", "a shard, by its name");
    EXPECT_THAT(messageOf<InputError>([&] { DatasetWriter(folder.path(), true, 1 << 20); }),
                AllOf(HasSubstr("holds no dataset"), HasSubstr(name.substr(0, name.find('/')))));
    EXPECT_TRUE(fs::exists(folder.path() / name));
    EXPECT_TRUE(fs::exists(folder.path() / "train/train-000000.tar"));
  }
}

TEST(DatasetWriter, EmptySplitFoldersAreNoDataset) {
  const TemporaryFolder folder;
  fs::create_directories(folder.path() / "train");
  EXPECT_EQ(messageOf<InputError>([&] { DatasetWriter(folder.path(), false, 1 << 20); }), "accepted");
}

TEST(DatasetWriter, AnAbandonedRunLeavesNoTemporaryFiles) {
  const TemporaryFolder folder;
  {
    DatasetWriter writer(folder.path() / "data", false, 1 << 20);
    writer.add(plainSample("k-0", 3000000));
  }
  EXPECT_THAT(filesOf(folder.path()), IsEmpty());
  EXPECT_TRUE(fs::is_empty(folder.path() / "data"));
}

// A limit on the size of files fails as a full disk does, in the middle of a write.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST(DatasetWriter, AFullDiskNamesFileAndReason) {
  for (const rlim_t limit : {rlim_t{0}, rlim_t{1000}, rlim_t{1 << 20}, rlim_t{2500000}}) {
    const TemporaryFolder folder;
    DatasetWriter writer(folder.path() / "data", false, 1 << 30);
    Manifest manifest;
    {
      const FullDisk full(limit);
      const std::string message = messageOf<Error>([&] {
        for (int i = 0; i < 4; ++i) writer.add(plainSample("k-" + std::to_string(i), 700000));
        writer.finish(manifest);
      });
      EXPECT_THAT(message, HasSubstr("train-000000.tar")) << limit;
      EXPECT_THAT(message, HasSubstr("File too large")) << limit;
    }
    // With room again, the torn shard must not be closed.
    EXPECT_THROW(writer.add(plainSample("later-0", 1)), Error) << limit;
    EXPECT_THROW(writer.finish(manifest), Error) << limit;
    EXPECT_FALSE(fs::exists(folder.path() / "data/train/train-000000.tar"));
    EXPECT_FALSE(fs::exists(folder.path() / "data/manifest.json"));
  }
}

TEST(DatasetWriter, ADatasetMayBeEmpty) {
  const TemporaryFolder folder;
  Manifest manifest = testManifest();
  DatasetWriter(folder.path() / "data", false, 1 << 20).finish(manifest);
  EXPECT_THAT(filesOf(folder.path() / "data"), ElementsAre("manifest.json"));
  EXPECT_THAT(verifyDataset(folder.path() / "data").problems, IsEmpty());
}

}  // namespace
}  // namespace scanmill
