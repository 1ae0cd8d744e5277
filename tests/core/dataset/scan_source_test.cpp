#include "base/error.h"
#include "dataset/scan_store.h"
#include "tests/core/dataset/fixture.h"

namespace scanmill {

namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string complaint(const std::filesystem::path& path, const std::string& sample = "",
                      const std::string& sensor = "") {
  return messageOf<InputError>([&] { findScan(path, sample, sensor); });
}

class FindScan : public testing::Test {
 protected:
  FindScan() : dataset(folder.path() / "data"), manifest(writeTestDataset(dataset)) {}

  Scan expected(std::uint32_t sample, std::uint32_t sensor) const {
    return testScan(manifest.sensors[sensor].beams, sample * 10 + sensor);
  }

  TemporaryFolder folder;
  std::filesystem::path dataset;
  Manifest manifest;
};

TEST_F(FindScan, TakesTheMiddleSampleAndTheFirstSensor) {
  const ScanSource source = findScan(dataset, "", "");
  EXPECT_EQ(source.title, manifest.samples[4].key + ", top");
  EXPECT_EQ(source.scan.position, expected(4, 0).position);
  ASSERT_NE(source.beams, nullptr);
  EXPECT_EQ(source.beams->azimuthOffset, manifest.sensors[0].beams.azimuthOffset);
  ASSERT_TRUE(source.ontology);
  EXPECT_EQ(source.ontology->require("car", {}).id, 65535);
}

// A sensor that turns more slowly than frames follow each other has no scan in some samples.
TEST_F(FindScan, PassesOverSamplesWithoutTheFirstSensor) {
  PackedDataset writer(folder.path() / "slow", false, 1 << 20);
  Manifest slow = testManifest();
  for (std::uint32_t i = 0; i < 3; ++i) {
    Sample sample = testSample(slow, i, "drive-00000" + std::to_string(i), "train");
    if (i == 1) {
      std::erase_if(sample.scans, [&](const ScanRecord& s) { return s.sensor == slow.sensors[0].name; });
      std::erase_if(sample.files, [](const auto& m) { return m.suffix.starts_with("top."); });
    }
    writer.add(sample);
  }
  writer.finish(slow);
  EXPECT_EQ(findScan(folder.path() / "slow", "", "").scan.position, expected(2, 0).position);
  EXPECT_EQ(findScan(folder.path() / "slow", "", "rear").scan.position, expected(1, 1).position);
  EXPECT_THAT(complaint(folder.path() / "slow", "1"), HasSubstr("has no sensor 'top'; it has rear"));
}

// The first format of a dataset may round positions. Where the exact one is lost with a shard's end, it is taken.
TEST_F(FindScan, TakesTheMostExactFormat) {
  PackedDataset writer(folder.path() / "rounded", false, 1 << 20);
  Manifest rounded = testManifest();
  rounded.formats = {{"draco", "drc", 0.001}, {"pcd", "pcd", 0}};
  writer.add(testSample(rounded, 3, "drive-000003", "train"));
  writer.finish(rounded);
  EXPECT_EQ(findScan(folder.path() / "rounded", "", "").scan.position, expected(3, 0).position);
  const std::filesystem::path shard = folder.path() / "rounded/train/train-000000.tar";
  std::filesystem::resize_file(shard, ShardIndex(shard).find("drive-000003.top.ray_tracing.pcd")->offset);
  EXPECT_EQ(findScan(folder.path() / "rounded", "", "").scan.size(), expected(3, 0).size());
  EXPECT_THAT(complaint(folder.path() / "rounded", "", "rear"),
              AllOf(HasSubstr("is truncated"), HasSubstr(".drc comes after the damage"), HasSubstr(".pcd")));
}

TEST_F(FindScan, ByKeyByIndexAndBySensor) {
  for (std::uint32_t i = 0; i < 9; ++i) {
    EXPECT_EQ(findScan(dataset, std::to_string(i), "").scan.position, expected(i, 0).position);
    EXPECT_EQ(findScan(dataset, manifest.samples[i].key, "Rear").scan.position, expected(i, 1).position);
  }
  EXPECT_EQ(findScan(dataset, "2", "rear").scan.position, expected(2, 1).position);
  EXPECT_EQ(findScan(dataset, "drive-000005", "").scan.position, expected(5, 0).position);
}

TEST_F(FindScan, AShardFindsItsManifest) {
  const std::filesystem::path shard = dataset / manifest.shards.front().file;
  const ScanSource source = findScan(shard, "0", "");
  EXPECT_EQ(source.scan.position, expected(0, 0).position);
  EXPECT_TRUE(source.ontology);
  std::filesystem::copy(shard, folder.path() / "lonely.tar");
  const ScanSource lonely = findScan(folder.path() / "lonely.tar", "0", "rear");
  EXPECT_EQ(lonely.scan.position, expected(0, 1).position);
  EXPECT_FALSE(lonely.ontology);
}

TEST_F(FindScan, TakesTheFormatThatCanBeDecoded) {
  Members members = membersOf(dataset / manifest.shards.front().file);
  for (auto& [name, bytes] : members) {
    if (name.ends_with(".pcd")) bytes = "broken";
  }
  const std::filesystem::path shard = folder.path() / "half.tar";
  writeMembers(shard, members);
  EXPECT_EQ(findScan(shard, "0", "top").scan.size(), expected(0, 0).size());
  for (auto& [name, bytes] : members) {
    if (name.ends_with(".csv")) bytes = "broken";
  }
  writeMembers(folder.path() / "all.tar", members);
  EXPECT_THAT(complaint(folder.path() / "all.tar", "0", "top"), AllOf(HasSubstr(".pcd"), HasSubstr(".csv")));
}

TEST_F(FindScan, SingleScans) {
  const Scan scan = expected(0, 0);
  for (const char* format : {"pcd", "csv"}) {
    const auto file = folder.write(std::string("scan.") + format, encode(format, scan));
    const ScanSource source = findScan(file, "", "");
    EXPECT_EQ(source.scan.position, scan.position);
    EXPECT_EQ(source.title, file.filename().string());
    EXPECT_THAT(complaint(file, "3"), HasSubstr("single scan"));
  }
}

TEST_F(FindScan, BadFiles) {
  EXPECT_THAT(complaint(folder.path() / "none.pcd"), AllOf(HasSubstr("none.pcd"), HasSubstr("does not exist")));
  EXPECT_THAT(complaint(folder.write("scan.txt", "1 2 3")), HasSubstr(".tar, .pcd"));
  EXPECT_THAT(complaint(folder.write("scan.pcd", "")), HasSubstr("scan.pcd"));
  EXPECT_THAT(complaint(folder.write("scan.tar", "no tar at all")), HasSubstr("scan.tar"));
  EXPECT_THAT(complaint(folder.path()), HasSubstr("scan.pcd"));  // a folder of scans
  EXPECT_THAT(complaint(folder.write("other/notes.txt", "none").parent_path()), HasSubstr("manifest.json"));
  writeMembers(folder.path() / "notes.tar", {{"a.txt", "x"}});
  EXPECT_THAT(complaint(folder.path() / "notes.tar"), HasSubstr("no sample"));
  std::filesystem::remove(dataset / manifest.shards.front().file);
  EXPECT_THAT(complaint(dataset, "0"), HasSubstr("train-000000.tar"));
}

}  // namespace

}  // namespace scanmill
