#include "dataset/shard_writer.h"

#include <sys/resource.h>

#include <csignal>
#include <nlohmann/json.hpp>
#include <set>

#include "base/error.h"
#include "base/file.h"
#include "tests/core/dataset/fixture.h"

namespace scanmill {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

// What add() was given comes back, with the JSON member first; members of a sample follow each other and share the name
// up to the first dot; suffixes are lower-case and unique.
TEST(ShardWriter, FollowsTheLawOfWebDataset) {
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
      for (const Member& member : sample.files) {
        if (member.suffix != suffix) continue;
        EXPECT_EQ(member.bytes, bytes) << name;
      }
    }
  }
  EXPECT_EQ(next, 9u);
}

TEST(ShardWriter, PythonsTarfileReadsTheShards) {
  if (std::system("/usr/bin/python3 -c 'import tarfile' >/dev/null 2>&1") != 0) GTEST_SKIP() << "python3 is absent";
  const TemporaryFolder folder;
  PackedDataset writer(folder.path() / "data", false, 1 << 20);
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

// The size that is told is the true one, long names included.
TEST(ShardWriter, CountsBytesExactly) {
  const TemporaryFolder folder;
  ShardWriter shard(folder.path(), "train/train-000000.tar", "train");
  std::uint64_t counted = ShardFile::kEndBytes;
  for (std::size_t i = 0; i < 40; ++i) {
    const Sample sample = plainSample("k" + std::to_string(i) + std::string(i * 5, 'k'), i * 100);
    counted += bytesInShard(sample);
    shard.add(sample);
  }
  const ShardPart part = shard.finish();
  EXPECT_EQ(part.shard.bytes, counted);
  EXPECT_EQ(fs::file_size(folder.path() / "train/train-000000.tar"), counted);
  EXPECT_EQ(part.shard.samples, 40u);
  EXPECT_EQ(part.shard.sha256, sha256OfFile(folder.path() / "train/train-000000.tar"));
}

TEST(ShardWriter, RefusesNamesThatReadersWouldMisread) {
  const TemporaryFolder folder;
  ShardWriter writer(folder.path(), "train/train-000000.tar", "train");
  const auto refusal = [&](const Sample& sample) { return messageOf<Error>([&] { writer.add(sample); }); };
  for (const char* key : {"", "a.b", "a/b", "a b",
                          "stra\xC3\x9F"
                          "e",
                          "a\nb", "a\\b"}) {
    EXPECT_THAT(refusal(plainSample(key, 1)), HasSubstr("sample '" + std::string(key) + "'"));
  }
  for (const char* suffix : {"", ".pcd", "PCD", "a/b", "json", "a b"}) {
    EXPECT_THAT(refusal({{.key = "key", .split = "train"}, {{suffix, "x"}}}), HasSubstr("sample 'key'")) << suffix;
  }
  EXPECT_THAT(refusal({{.key = "key", .split = "train"}, {{"pcd", "x"}, {"pcd", "y"}}}),
              HasSubstr("'pcd' is used twice"));
  for (const char* split : {"", "../x", "Train", "a.b"}) {
    EXPECT_THAT(refusal({{.key = "key", .split = split}, {}}), HasSubstr("not a name of a split"));
  }
  EXPECT_THAT(refusal({{.key = "key", .split = "val"}, {}}), HasSubstr("the split val"));
  // None of these left a trace.
  writer.add(plainSample("good-0", 1));
  EXPECT_EQ(writer.finish().samples.size(), 1u);
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

TEST(ShardWriter, AFullDiskNamesFileAndReason) {
  for (const rlim_t limit : {rlim_t{0}, rlim_t{1000}, rlim_t{1 << 20}, rlim_t{2500000}}) {
    const TemporaryFolder folder;
    ShardWriter shard(folder.path(), "train/train-000000.tar", "train");
    {
      const FullDisk full(limit);
      const std::string message = messageOf<Error>([&] {
        for (int i = 0; i < 4; ++i) shard.add(plainSample("k-" + std::to_string(i), 700000));
        static_cast<void>(shard.finish());
      });
      EXPECT_THAT(message, HasSubstr("train-000000.tar")) << limit;
      EXPECT_THAT(message, HasSubstr("File too large")) << limit;
    }
    // With room again, the torn shard must not be closed.
    EXPECT_THROW(shard.add(plainSample("later-0", 1)), Error) << limit;
    EXPECT_THROW(shard.finish(), Error) << limit;
    EXPECT_FALSE(fs::exists(folder.path() / "train/train-000000.tar"));
  }
}

}  // namespace
}  // namespace scanmill
