#include "dataset/names.h"

#include <random>
#include <set>

#include "base/file.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

void expectParts(const std::string& member, const MemberName& expected) {
  const MemberName parts = partsOfMember(member);
  EXPECT_EQ(parts.key, expected.key) << member;
  EXPECT_EQ(parts.sensor, expected.sensor) << member;
  EXPECT_EQ(parts.revolution, expected.revolution) << member;
  EXPECT_EQ(parts.method, expected.method) << member;
  EXPECT_EQ(parts.suffix, expected.suffix) << member;
}

TEST(PartsOfMember, ByDots) {
  expectParts("street-s1-lane-000012.top.ray_tracing.pcd", {"street-s1-lane-000012", "top", 0, "ray_tracing", "pcd"});
  expectParts("street-s1-lane-000012.top.1.ray_tracing.pcd", {"street-s1-lane-000012", "top", 1, "ray_tracing", "pcd"});
  expectParts("a.top.pcd", {"a", "top", 0, "", "pcd"});
  expectParts("a.pcd", {"a", "", 0, "", "pcd"});
  expectParts("a", {"a", "", 0, "", ""});
  expectParts("v1.2/a.top.x.y.drc", {"v1.2/a", "top", 0, "x.y", "drc"});
  expectParts("a.top.1.drc", {"a", "top", 0, "1", "drc"});
  expectParts("a..pcd", {"a", "", 0, "", "pcd"});
  expectParts("", {"", "", 0, "", ""});
}

const std::vector<std::string> kKeys{"town-s1-lane-000000", "town-s1-lane-000001", "town-s2-lane-000000"};

std::string complaintOf(const std::string& wanted) {
  return messageOf<InputError>([&] { findKey(kKeys, wanted, "data"); });
}

TEST(FindKey, ByKeyIndexPartOrTheMiddle) {
  EXPECT_EQ(findKey(kKeys, "", "data"), 1u);
  for (std::size_t i = 0; i < kKeys.size(); ++i) {
    EXPECT_EQ(findKey(kKeys, kKeys[i], "data"), i);
    EXPECT_EQ(findKey(kKeys, std::to_string(i), "data"), i);
  }
  EXPECT_EQ(findKey(kKeys, "s2", "data"), 2u);
  EXPECT_EQ(findKey(kKeys, "lane-000001", "data"), 1u);
}

TEST(FindKey, SaysWhatThereIs) {
  EXPECT_THAT(complaintOf("3"), AllOf(HasSubstr("data"), HasSubstr("0 to 2")));
  EXPECT_THAT(complaintOf("99999999999999999999"), HasSubstr("0 to 2"));
  EXPECT_THAT(complaintOf("s1"),
              AllOf(HasSubstr("part of 2 keys"), HasSubstr("town-s1-lane-000000, town-s1-lane-000001")));
  EXPECT_THAT(complaintOf("town-s2-lane-000001"), HasSubstr("did you mean 'town-s1-lane-000001'"));
  EXPECT_THAT(messageOf<InputError>([] { findKey({}, "", "data"); }), HasSubstr("has no samples"));
}

TEST(ShardRanges, AreReadAsPeopleWriteThem) {
  EXPECT_THAT(parseShardRanges("0-3,7,2-4", 8), ElementsAre(0, 1, 2, 3, 4, 7));
  EXPECT_THAT(parseShardRanges("5", 6), ElementsAre(5));
}

TEST(ShardRanges, WrittenAndReadTheyAreTheSame) {
  std::minstd_rand random(5);
  for (int i = 0; i < 200; ++i) {
    std::set<std::uint64_t> some;
    for (std::uint64_t n = 0; n < random() % 40 + 1; ++n) some.insert(random() % 50);
    const std::vector<std::uint64_t> numbers(some.begin(), some.end());
    EXPECT_EQ(parseShardRanges(shardRanges(numbers), 50), numbers) << shardRanges(numbers);
  }
  EXPECT_EQ(shardRanges({0, 1, 2, 5, 7, 8}), "0-2,5,7-8");
}

TEST(ShardRanges, WhatIsNoneIsRefused) {
  for (const char* text :
       {"", ",", "1,", "a", "-1", "1-", "3-1", "1-2-3", "0x1", "99999999999999999999", " 1", "1.5"}) {
    EXPECT_THAT(messageOf<InputError>([&] { parseShardRanges(text, 10); }), HasSubstr("such as 0-9,12")) << text;
  }
  EXPECT_THAT(messageOf<InputError>([&] { parseShardRanges("0-10", 10); }), HasSubstr("has the shards 0 to 9"));
  EXPECT_THAT(messageOf<InputError>([&] { parseShardRanges("1", 1); }), HasSubstr("has only the shard 0"));
}

// The program recognises files that a killed run leaves behind by their names, and no other files.
TEST(ShardNames, TemporaryNamesOfWritersAreLeftovers) {
  const TemporaryFolder folder;
  const AtomicFile file(folder.path() / "manifest.json");
  const std::string name = std::filesystem::directory_iterator(folder.path())->path().filename();
  EXPECT_EQ(finalName(name), "manifest.json") << name;
  EXPECT_TRUE(isLeftover(name)) << name;
  EXPECT_TRUE(isLeftover("train/train-000000.tar.partial-17")) << "of earlier versions";
  for (const char* other : {"notes.partial-final", "manifest.json.partial-", "manifest.json", "a.txt.partial-17"}) {
    EXPECT_FALSE(isLeftover(other)) << other;
  }
}

}  // namespace

}  // namespace scanmill
