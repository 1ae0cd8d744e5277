#include "base/file.h"
#include "dataset/objects.h"
#include "report/dataset/dataset_report.h"
#include "report/dataset/scan_counts.h"
#include "tests/studio/report/dataset/made_dataset.h"

namespace scanmill {
namespace {

ObjectRecord carAt(double distance, std::uint64_t points, std::uint32_t beams, std::uint32_t alone) {
  ObjectRecord car;
  car.id = static_cast<std::uint32_t>(distance * 10);
  car.semantic = 65535;
  car.size = {4, 2, 1.5};
  ObjectView view;
  view.sensor = "top";
  view.sensorFromBox = {{}, {distance, 0, 0}};
  view.points = points;
  view.beams = beams;
  view.beamsAlone = alone;
  car.views = {view};
  return car;
}

TEST(ObjectCounts, AreByClassDistanceAndVisibility) {
  const TemporaryFolder folder;
  Manifest manifest = madeManifest();
  {
    PackedDataset writer(folder.path() / "data", false, 10'000'000);
    for (int i = 0; i < 2; ++i) {
      SampleObjects objects{"street-s1-lane-00000" + std::to_string(i), 0, {}};
      objects.objects = {carAt(5, 10, 10, 10), carAt(15, 9, 3, 10), carAt(45, 0, 0, 10), carAt(300, 1, 7, 10)};
      Sample sample{objects.key, "train", {}, {}};
      sample.objects = objects.counts();
      sample.members.push_back({std::string(kObjectsSuffix), objectsJson(objects, manifest.ontology)});
      writer.add(sample);
    }
    writer.finish(manifest);
  }
  std::vector<std::string> faults;
  const ObjectCounts counts = countObjects(folder.path() / "data", manifest, {0, 1}, faults);
  EXPECT_TRUE(faults.empty());
  EXPECT_EQ(counts.samples, 2u);
  EXPECT_EQ(counts.ofClass.at(65535), (VisibilityCounts{2, 2, 0, 2, 2}));
  EXPECT_EQ(counts.ofDistance[0], (VisibilityCounts{0, 0, 0, 0, 2}));
  EXPECT_EQ(counts.ofDistance[1], (VisibilityCounts{0, 2, 0, 0, 0}));
  EXPECT_EQ(counts.ofDistance[3], (VisibilityCounts{2, 0, 0, 0, 0}));
  EXPECT_EQ(counts.ofDistance[kDistanceSteps.size()], (VisibilityCounts{0, 0, 0, 2, 0}));
  DatasetReport report;
  report.manifest = manifest;
  report.shardFaults.resize(manifest.shards.size());
  report.summary.sensors.resize(manifest.sensors.size());
  EXPECT_EQ(datasetPage(report).find("id=\"objects\""), std::string::npos);
  report.objects = counts;
  const std::string page = datasetPage(report), table = page.substr(page.find("id=\"objects\""));
  EXPECT_NE(table.find("car"), std::string::npos);
  EXPECT_NE(table.find("30 to 50 m"), std::string::npos);
  EXPECT_EQ(table.find("50 to 80 m"), std::string::npos) << "nothing stands there";

  // What is damaged is a fault, not an end.
  const std::string shard = (folder.path() / "data" / manifest.shards[0].file).string();
  std::string bytes = readFile(shard);
  bytes[bytes.find("\"beams_alone\"") + 3] = 'X';
  writeFile(shard, bytes);
  EXPECT_EQ(countObjects(folder.path() / "data", manifest, {0, 1}, faults).samples, 1u);
  ASSERT_EQ(faults.size(), 1u);
}

}  // namespace
}  // namespace scanmill
