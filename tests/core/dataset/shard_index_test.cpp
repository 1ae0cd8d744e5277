#include "base/error.h"
#include "base/file.h"
#include "dataset/reader.h"
#include "tests/core/dataset/fixture.h"

namespace scanmill {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

Members indexed(const fs::path& file) {
  const ShardIndex index(file);
  Members members;
  for (const ShardMember& m : index.members()) members.emplace_back(m.name, index.read(m));
  return members;
}

std::string refusal(const fs::path& file) {
  return messageOf<InputError>([&] { readTar(file, [](const std::string&, std::string_view) {}); });
}

TEST(ShardIndex, EqualsReadTar) {
  const TemporaryFolder folder;
  writeMembers(folder.path() / "x.tar", oddMembers());
  EXPECT_EQ(indexed(folder.path() / "x.tar"), oddMembers());
  const Manifest manifest = writeTestDataset(folder.path() / "data");
  for (const ShardRecord& shard : manifest.shards) {
    const fs::path file = folder.path() / "data" / shard.file;
    EXPECT_EQ(indexed(file), membersOf(file)) << shard.file;
  }
}

TEST(ShardIndex, EqualsReadTarOnWhatTarWrites) {
  if (std::system("tar --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "tar is absent";
  const TemporaryFolder folder;
  const std::string deep = std::string(90, 'd') + "/" + std::string(120, 'e') + ".pcd";
  folder.write("in/a-0.json", "{}");
  folder.write("in/" + deep, std::string(70000, 'p'));
  for (const std::string form : {"gnu", "pax", "ustar", "v7"}) {
    const std::string names = form == "v7" || form == "ustar" ? "a-0.json" : "a-0.json " + deep;
    const fs::path file = folder.path() / (form + ".tar");
    ASSERT_EQ(std::system(("cd '" + folder.path().string() + "/in' && tar --format=" + form + " -cf '" + file.string() +
                           "' " + names)
                              .c_str()),
              0);
    EXPECT_EQ(indexed(file), membersOf(file)) << form;
    EXPECT_FALSE(indexed(file).empty());
  }
}

TEST(ShardIndex, FindsMembersByName) {
  const TemporaryFolder folder;
  Members members = oddMembers();
  members.emplace_back("a-0.json", "a second of that name");
  writeMembers(folder.path() / "x.tar", members);
  const ShardIndex index(folder.path() / "x.tar");
  ASSERT_NE(index.find("b-0.last"), nullptr);
  EXPECT_EQ(index.read(*index.find("b-0.last")), "z");
  EXPECT_EQ(index.read(*index.find("a-0.json")), "{}");
  EXPECT_EQ(index.find("a-0"), nullptr);
  EXPECT_EQ(index.find(""), nullptr);
}

// Wherever a shard is cut: the members before that, as they were.
TEST(ShardIndex, GivesWhatIsWholeWhereThatIsAskedFor) {
  const TemporaryFolder folder;
  Members members = oddMembers();
  members[5].second.resize(3000);
  writeMembers(folder.path() / "x.tar", members);
  const std::string bytes = readFile(folder.path() / "x.tar");
  std::size_t most = 0;
  for (std::size_t size = 0; size < bytes.size(); size += 256) {
    const fs::path cut = folder.write("cut.tar", bytes.substr(0, size));
    try {
      const ShardIndex index(cut);
      EXPECT_EQ(index.damage().empty(), refusal(cut) == "accepted") << size;
      EXPECT_GE(index.members().size(), most) << size;
      most = index.members().size();
      for (std::size_t i = 0; i < most; ++i) {
        EXPECT_EQ(index.members()[i].name, members[i].first);
        EXPECT_EQ(index.read(index.members()[i]), members[i].second);
      }
    } catch (const InputError&) {
      EXPECT_NE(refusal(cut), "accepted") << size;
      EXPECT_EQ(most, 0u) << size;
    }
  }
  EXPECT_EQ(most, members.size());
  EXPECT_EQ(ShardIndex(folder.path() / "x.tar").damage(), "");
}

TEST(ShardIndex, AFileThatChangedIsNoticed) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "x.tar";
  writeMembers(file, oddMembers());
  const ShardIndex index(file);
  fs::resize_file(file, 3000);
  EXPECT_EQ(index.read(index.members().front()), "{}");
  EXPECT_THAT(messageOf<InputError>([&] { index.read(index.members().back()); }),
              testing::AllOf(HasSubstr("x.tar"), HasSubstr("truncated in 'b-0.last'")));
  fs::remove(file);
  EXPECT_THAT(messageOf<InputError>([&] { index.read(index.members().front()); }), HasSubstr("x.tar: cannot be read"));
}

}  // namespace
}  // namespace scanmill
