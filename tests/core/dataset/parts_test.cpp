#include "dataset/parts.h"

#include "base/error.h"
#include "tests/core/dataset/fixture.h"

namespace scanmill {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const DatasetPlan kPartsPlan{"abc", 5, {{"train", 2}, {"val", 1}}};

// The test dataset's shards as parts; sample n of the plan is the nth that is added.
DatasetPart part(const std::string& file, const std::vector<std::uint64_t>& numbers) {
  DatasetPart made{"abc", numbers, testManifest()};
  made.manifest.shards = {{file, file.substr(0, file.find('/')), sha256(file), 1024, numbers.size()}};
  for (const std::uint64_t number : numbers) {
    made.manifest.samples.push_back({"k-" + std::to_string(number),
                                     made.manifest.shards[0].split,
                                     0,
                                     {},
                                     {"k-" + std::to_string(number) + ".json"},
                                     {xxh3(std::to_string(number))}});
  }
  made.manifest.modelled = {{"in", file, false, "", "", {file}}, {"of", "all scenes", false, "", "", {file}}};
  return made;
}

std::vector<DatasetPart> allParts() {
  return {part("train/train-000000.tar", {0, 4}), part("train/train-000001.tar", {3}),
          part("val/val-000000.tar", {2, 1})};
}

TEST(DatasetParts, ReadBackAsWritten) {
  EXPECT_EQ(parsePlan(toJson(kPartsPlan), "plan"), kPartsPlan);
  EXPECT_THAT(kPartsPlan.shards(),
              ElementsAre("train/train-000000.tar", "train/train-000001.tar", "val/val-000000.tar"));
  for (const DatasetPart& own : allParts()) {
    const DatasetPart read = parsePart(toJson(own), "part");
    EXPECT_EQ(read.plan, own.plan);
    EXPECT_EQ(read.numbers, own.numbers);
    EXPECT_EQ(toJson(read.manifest), toJson(own.manifest));
  }
}

TEST(DatasetParts, DamagedOnesAreRefused) {
  const std::string text = toJson(part("train/train-000000.tar", {0, 4}));
  int accepted = 0;
  for (std::size_t i = 0; i < text.size(); i += 7) {
    std::string damaged = text;
    damaged[i] ^= 1;
    try {
      const DatasetPart read = parsePart(damaged, "part");
      // The first line is covered by the checks of the plan and of the samples' numbers.
      accepted += i > text.find('\n') ? 1 : 0;
    } catch (const InputError&) {
    }
    EXPECT_THROW(parsePart(text.substr(0, i), "part"), InputError) << i;
  }
  EXPECT_EQ(accepted, 0);
  EXPECT_THROW(parsePlan("{}", "plan"), InputError);
}

// Samples come in the order of the plan, with the shards that hold them.
TEST(DatasetParts, AreJoinedInTheOrderOfThePlan) {
  const Manifest whole = joinParts(kPartsPlan, allParts());
  std::vector<std::string> keys;
  std::vector<std::uint32_t> shards;
  for (const SampleRecord& sample : whole.samples) {
    keys.push_back(sample.key);
    shards.push_back(sample.shard);
  }
  EXPECT_THAT(keys, ElementsAre("k-0", "k-1", "k-2", "k-3", "k-4"));
  EXPECT_THAT(shards, ElementsAre(0, 2, 2, 1, 0));
  ASSERT_EQ(whole.shards.size(), 3u);
  std::vector<std::vector<std::string>> scenes;
  for (const ModelledItem& item : whole.modelled) scenes.push_back(item.scenes);
  EXPECT_THAT(scenes, ElementsAre(ElementsAre("train/train-000000.tar"), testing::IsEmpty(),
                                  ElementsAre("train/train-000001.tar"), ElementsAre("val/val-000000.tar")));
}

// Parts that were made of different bytes of a file are no dataset, unless this is asked for.
TEST(DatasetParts, OtherVersionsOfAFileAreRefused) {
  std::vector<DatasetPart> parts = allParts();
  parts[1].manifest.files[1].xxh3 = xxh3("v 1 0 0");
  EXPECT_THAT(messageOf<Error>([&] { return joinParts(kPartsPlan, parts); }),
              testing::AllOf(HasSubstr("scenes/wall.obj changed"), HasSubstr("--resume=anyway")));
  EXPECT_EQ(joinParts(kPartsPlan, parts, true).files.size(), testManifest().files.size() + 1);
}

TEST(DatasetParts, GapsAndDoublesAreRefused) {
  std::vector<DatasetPart> twice = allParts();
  twice[1].numbers = {4};
  EXPECT_THAT(messageOf<Error>([&] { return joinParts(kPartsPlan, twice); }),
              HasSubstr("k-4 is in two shards, train/train-000000.tar and train/train-000001.tar"));
  std::vector<DatasetPart> inOne = allParts();
  inOne[2].numbers = {1, 1};
  EXPECT_THAT(messageOf<Error>([&] { return joinParts(kPartsPlan, inOne); }), HasSubstr("is in two shards"));
  std::vector<DatasetPart> fewer = allParts();
  fewer.pop_back();
  EXPECT_THAT(messageOf<Error>([&] { return joinParts(kPartsPlan, fewer); }),
              HasSubstr("sample 1 of 5 is in no shard"));
  std::vector<DatasetPart> beyond = allParts();
  beyond[1].numbers = {5};
  EXPECT_THAT(messageOf<Error>([&] { return joinParts(kPartsPlan, beyond); }), HasSubstr("the plan has 5 samples"));
}

}  // namespace
}  // namespace scanmill
