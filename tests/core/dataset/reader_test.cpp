#include "dataset/reader.h"

#include "base/error.h"
#include "base/file.h"
#include "tests/core/dataset/fixture.h"

namespace scanmill {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

std::string refusal(const fs::path& file) {
  return messageOf<InputError>([&] { membersOf(file); });
}

// What shows names would be busy with it for minutes.
TEST(ReadTar, RefusesNamesOfThousandsOfBytes) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "x.tar";
  writeMembers(file, {{std::string(4090, 'k') + ".long", "{}"}});
  EXPECT_EQ(membersOf(file).size(), 1u);
  writeMembers(file, {{std::string(200'000, 'k') + ".long", "{}"}});
  EXPECT_THAT(refusal(file), HasSubstr("has a member whose name has 200005 bytes, but at most 4096 can be read"));
}

// Wherever a shard is cut, also between two members and within zeros, it is refused.
TEST(ReadTar, NoticesEveryTruncation) {
  const TemporaryFolder folder;
  Members members = oddMembers();
  members[5].second.resize(3000);
  writeMembers(folder.path() / "x.tar", members);
  const std::string bytes = readFile(folder.path() / "x.tar");
  std::vector<std::size_t> sizes{1, 100, 511, bytes.size() - 1};
  for (std::size_t size = 0; size < bytes.size(); size += 256) sizes.push_back(size);
  for (const std::size_t size : sizes) {
    const fs::path cut = folder.write("cut.tar", bytes.substr(0, size));
    const std::string message = refusal(cut);
    EXPECT_THAT(message, HasSubstr("cut.tar: ")) << size;
    EXPECT_THAT(message, HasSubstr("offset")) << size;
  }
  EXPECT_EQ(membersOf(folder.write("padded.tar", bytes + std::string(8192, '\0'))), members);
}

TEST(ReadTar, RefusesWhatIsNoTar) {
  const TemporaryFolder folder;
  std::string noise;
  for (std::uint32_t i = 0; i < 1000; ++i) noise += static_cast<char>(randomBlock({.beam = i})[0]);
  EXPECT_THAT(refusal(folder.write("noise.tar", noise)), HasSubstr("noise.tar: cannot be read as tar at offset 0"));
  EXPECT_THAT(refusal(folder.write("empty.tar", "")), HasSubstr("empty.tar"));
  EXPECT_THAT(refusal(folder.write("text.tar", std::string(5000, 'a'))), HasSubstr("text.tar"));
  EXPECT_THAT(refusal(folder.path() / "absent.tar"), HasSubstr("absent.tar"));
  EXPECT_THAT(refusal(folder.path()), HasSubstr(folder.path().string()));
}

TEST(ReadTar, RefusesMembersThatAreNoPlainFiles) {
  if (std::system("tar --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "tar is absent";
  const TemporaryFolder folder;
  fs::create_symlink("/etc/passwd", folder.path() / "a-0.json");
  ASSERT_EQ(std::system(("cd '" + folder.path().string() + "' && tar -cf x.tar a-0.json").c_str()), 0);
  EXPECT_THAT(refusal(folder.path() / "x.tar"), HasSubstr("'a-0.json' that is not a plain file"));
  // A hole of 1 GB takes no room in the file, and must take none in memory.
  ASSERT_EQ(std::system(("cd '" + folder.path().string() +
                         "' && truncate -s 1G b-0.bin && tar --format=gnu --sparse -cf y.tar b-0.bin")
                            .c_str()),
            0);
  EXPECT_THAT(refusal(folder.path() / "y.tar"), HasSubstr("'b-0.bin' that is not a plain file"));
}

TEST(DecodeMember, PicksTheFormatByItsSuffix) {
  const Scan scan = testScan(testBeams(4, 16), 1);
  for (const FormatEntry& format : formats()) {
    const std::string name = "key.top.ray_tracing." + std::string(format.suffix);
    const Scan decoded = decodeMember(name, encode(std::string(format.name), scan));
    EXPECT_EQ(decoded.size(), scan.size()) << name;
    EXPECT_THAT(messageOf<InputError>([&] { decodeMember(name, "garbage"); }), HasSubstr(name));
  }
  for (const char* name : {"key.top.nonsense", "key", "key.", ""}) {
    EXPECT_THAT(messageOf<InputError>([&] { decodeMember(name, "x"); }), HasSubstr("known: .pcd")) << name;
  }
}

}  // namespace
}  // namespace scanmill
