#include "report/dataset/scan_counts.h"

#include "base/file.h"
#include "dataset/objects.h"
#include "report/dataset/dataset_report.h"
#include "tests/studio/report/dataset/made_dataset.h"

namespace scanmill {
namespace {

TEST(ScanCounts, StepsHoldTheFarthestRange) {
  for (const double farthest : {0.5, 1.0, 7.0, 12.0, 80.0, 120.0, 245.0, 1000.0, 12345.0}) {
    const RangeSteps steps = rangeStepsFor(farthest);
    EXPECT_LE(steps.count, 122u) << farthest;
    EXPECT_GE(double(steps.count - 1) * steps.step, farthest * (1 - 1e-12));
    EXPECT_EQ(steps.of(2 * farthest + steps.step), steps.count - 1);
    EXPECT_EQ(steps.of(0), 0u);
    const double digit = steps.step / std::pow(10, std::floor(std::log10(steps.step) + 1e-9));
    EXPECT_TRUE(std::abs(digit - 1) < 1e-9 || std::abs(digit - 2) < 1e-9 || std::abs(digit - 5) < 1e-9) << steps.step;
  }
}

TEST(ScanCounts, IntensityKeysKeepOrderAndBytes) {
  for (int i = 1; i <= 256; ++i) EXPECT_EQ(intensityOfKey(intensityKey(float(i))), float(i));
  float before = 0;
  for (float v = 1e-6f; v < 1e6f; v *= 1.01f) {
    const float of = intensityOfKey(intensityKey(v));
    EXPECT_LE(of, v);
    EXPECT_GT(of, v * (1 - 1.0f / 127));
    EXPECT_GE(of, before);
    before = of;
  }
  EXPECT_EQ(intensityKey(0), 0);
  EXPECT_EQ(intensityKey(-3), 0);
}

TEST(ScanCounts, CountsWhatIsThere) {
  const Manifest manifest = madeManifest();
  std::vector<MadePoint> points;
  for (int k = 0; k < 10; ++k) points.push_back({{float(k) + 0.5f, 0, 0}, 7, 0, 10});
  for (int k = 0; k < 6; ++k) points.push_back({{0, 5, 0}, 65535, k < 4 ? 9u : 0u, 255});
  points.push_back({{0, 5, 0}, 7, 9, 255});
  Scan scan = madeScan(manifest.sensors[0].beams, points);
  scan.position.push_back({NAN, NAN, NAN});  // a miss
  scan[kLabel].push_back(7);
  scan[kInstance].push_back(0);
  scan[kIntensity].push_back(0);
  scan[kRing].push_back(0);
  const RangeSteps steps{1, 8};
  const ScanCounts counts = countScan(scan, steps);
  EXPECT_EQ(counts.points, 17u);
  EXPECT_EQ(counts.rangesOfClass.at(7), (std::vector<std::uint64_t>{1, 1, 1, 1, 1, 2, 1, 3}));
  EXPECT_EQ(counts.rangesOfClass.at(65535), (std::vector<std::uint64_t>{0, 0, 0, 0, 0, 6, 0, 0}));
  EXPECT_EQ(counts.intensities.at(intensityKey(10)), 10u);
  EXPECT_EQ(counts.intensities.at(intensityKey(255)), 7u);
  ASSERT_EQ(counts.instances.size(), 1u);
  EXPECT_EQ(counts.instances[0].id, 9u);
  EXPECT_EQ(counts.instances[0].pointsOfClass, (std::map<std::uint16_t, std::uint64_t>{{7, 1}, {65535, 4}}));
  EXPECT_EQ(counts.withoutId, (std::map<std::uint16_t, std::uint64_t>{{7, 10}, {65535, 2}}));
}

TEST(ScanCounts, AScanWithoutColumnsIsCountedToo) {
  Scan scan;
  scan.position = {{1, 0, 0}, {2, 0, 0}};
  const ScanCounts counts = countScan(scan, {1, 4});
  EXPECT_EQ(counts.points, 2u);
  EXPECT_EQ(counts.rangesOfClass.at(0), (std::vector<std::uint64_t>{0, 1, 1, 0}));
  EXPECT_TRUE(counts.intensities.empty() && counts.instances.empty() && counts.withoutId.empty());
}

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
