#include "base/error.h"
#include "base/file.h"
#include "dataset/parts.h"
#include "tests/core/dataset/fixture.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

const DatasetPlan kMergePlan{"plan", 4, {{"train", 4}}};

// Shards of one sample each, as processes that share the folder leave them.
void make(const std::filesystem::path& folder, const std::vector<std::uint64_t>& shards) {
  DatasetFolder opened(folder, FolderUse::Share, kMergePlan);
  for (const std::uint64_t number : shards) addShard(opened, number);
}

class Merge : public testing::Test {
 protected:
  std::string message() const {
    return messageOf<InputError>([&] { mergeDataset(data_); });
  }

  TemporaryFolder folder_;
  std::filesystem::path data_ = folder_.path() / "data";
};

TEST_F(Merge, EndsADatasetWhoeverMadeItsShards) {
  make(data_, {3, 1});
  make(data_, {0, 2});
  const Manifest manifest = mergeDataset(data_);
  EXPECT_THAT(filesOf(data_),
              ElementsAre("dataset_card.md", "manifest.json", "train/train-000000.tar", "train/train-000001.tar",
                          "train/train-000002.tar", "train/train-000003.tar"));
  EXPECT_EQ(toJson(readManifest(data_)), toJson(manifest));
  ASSERT_EQ(manifest.samples.size(), 4u);
  EXPECT_EQ(manifest.samples[2].key, "k-2");
  EXPECT_EQ(toJson(mergeDataset(data_)), toJson(manifest)) << "and once more";
}

TEST_F(Merge, NamesTheShardsThatAreMissing) {
  make(data_, {1});
  EXPECT_THAT(message(), AllOf(HasSubstr("3 of 4 shards are missing"), HasSubstr("--shards 0,2-3")));
  make(data_, {0, 2, 3});
  const auto shard = data_ / ".scanmill/train/train-000002.tar";
  std::filesystem::resize_file(shard, 700);
  EXPECT_THAT(message(), HasSubstr("--shards 2"));
  make(data_, {2});
  std::string record = readFile(data_ / ".scanmill/train/train-000000.tar.json");
  record[record.size() / 2] ^= 1;
  writeFile(data_ / ".scanmill/train/train-000000.tar.json", record);
  EXPECT_THAT(message(), HasSubstr("--shards 0"));
}

TEST_F(Merge, RefusesPartsOfAnotherPlanAndFoldersThatAreInUse) {
  make(data_, {0, 1, 2, 3});
  const auto file = data_ / ".scanmill/train/train-000001.tar.json";
  const std::string record = readFile(file);
  std::string other = record;
  other.replace(other.find("plan\":\"plan"), 11, "plan\":\"none");
  writeFile(file, other);
  EXPECT_THAT(message(), AllOf(HasSubstr("train-000001"), HasSubstr("another pipeline")));
  writeFile(file, record);
  {
    const DatasetFolder used(data_, FolderUse::Share, kMergePlan);
    EXPECT_THAT(message(), HasSubstr("is being written by"));
  }
  EXPECT_EQ(mergeDataset(data_).samples.size(), 4u);
}

TEST_F(Merge, RefusesWhatIsNoUnfinishedDataset) {
  EXPECT_THAT(message(), HasSubstr("has no unfinished dataset"));
  folder_.write("data/notes.txt", "mine");
  EXPECT_THAT(message(), HasSubstr("has no unfinished dataset"));
  EXPECT_THAT(filesOf(data_), ElementsAre("notes.txt"));
}

}  // namespace
}  // namespace scanmill
