#include <set>

#include "base/file.h"
#include "dataset/objects.h"
#include "report/dataset/dataset_report.h"
#include "report/dataset/scan_reading.h"
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
  EXPECT_EQ(counts.instances.at(9), (ClassPoints{{7, 1}, {65535, 4}}));
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
      Sample sample{{.key = objects.key, .split = "train"}, {}};
      sample.objects = objects.counts();
      sample.files.push_back({std::string(kObjectsSuffix), objectsJson(objects, manifest.ontology)});
      writer.add(sample);
    }
    writer.finish(manifest);
  }
  std::vector<std::string> faults;
  const ObjectCounts counts = countObjects(ScanStore(folder.path() / "data"), {0, 1}, faults);
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

  // Damage is an error, not the end of the shard.
  const std::string shard = (folder.path() / "data" / manifest.shards[0].file).string();
  std::string bytes = readFile(shard);
  bytes[bytes.find("\"beams_alone\"") + 3] = 'X';
  writeFile(shard, bytes);
  EXPECT_EQ(countObjects(ScanStore(folder.path() / "data"), {0, 1}, faults).samples, 1u);
  ASSERT_EQ(faults.size(), 1u);
}

// Samples of two sensors each, the splits one after the other.
Manifest manifestOf(std::size_t train, std::size_t val) {
  Manifest manifest;
  manifest.shards = {{"a", "train", "", 0, train}, {"b", "val", "", 0, val}};
  for (std::size_t i = 0; i < train + val; ++i) {
    SampleRecord sample;
    sample.key = "s-" + std::to_string(i);
    sample.split = i < train ? "train" : "val";
    sample.shard = i < train ? 0 : 1;
    sample.scans.resize(2);
    sample.scans[0].points = sample.scans[1].points = 5;
    manifest.samples.push_back(sample);
  }
  return manifest;
}

const std::vector<bool> kSound{true, true};

TEST(ScanChoice, AllScansOrAnEvenSpread) {
  const Manifest manifest = manifestOf(30, 20);
  EXPECT_EQ(spreadScans(manifest, 100).size(), 100u);
  EXPECT_EQ(spreadScans(manifest, 1000).size(), 100u);
  for (const std::size_t most : {1u, 7u, 10u, 99u}) {
    const std::vector<ScanIndex> spread = spreadScans(manifest, most);
    ASSERT_EQ(spread.size(), most);
    EXPECT_TRUE(std::ranges::is_sorted(spread));
    EXPECT_EQ(std::set<ScanIndex>(spread.begin(), spread.end()).size(), most);
    const double step = 100.0 / double(most);
    for (std::size_t k = 0; k < most; ++k) {
      const double place = double(2 * spread[k].sample + spread[k].scan);
      EXPECT_NEAR(place, (double(k) + 0.5) * step, 1.0);
    }
  }
  EXPECT_TRUE(spreadScans(Manifest(), 5).empty());
}

TEST(ScanChoice, SplitsAndSensorsTakeTurns) {
  const Manifest manifest = manifestOf(30, 20);
  const std::vector<ScanIndex> chosen = randomScans(manifest, kSound, 4, 1);
  ASSERT_EQ(chosen.size(), 4u);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(manifest.samples[chosen[k].sample].split, k % 2 == 0 ? "train" : "val");
    EXPECT_EQ(chosen[k].scan, k % 2);
  }
}

TEST(ScanChoice, TheSeedChooses) {
  const Manifest manifest = manifestOf(300, 200);
  EXPECT_EQ(randomScans(manifest, kSound, 8, 5), randomScans(manifest, kSound, 8, 5));
  EXPECT_NE(randomScans(manifest, kSound, 8, 5), randomScans(manifest, kSound, 8, 6));
  // Every sample has the same chance: 600 draws of 2 among 300 of train.
  std::vector<int> hits(300, 0);
  for (std::uint64_t seed = 0; seed < 600; ++seed) {
    for (const ScanIndex& p : randomScans(manifest, kSound, 4, seed)) {
      if (p.sample < 300) ++hits[p.sample];
    }
  }
  EXPECT_LT(*std::ranges::max_element(hits), 20);  // a mean of 4; of Poisson's law below 1e-8
  EXPECT_LT(std::ranges::count(hits, 0), 25);      // 5.5 are expected
}

TEST(ScanChoice, EmptyScansAndBadShardsArePassedOver) {
  Manifest manifest = manifestOf(3, 3);
  for (SampleRecord& s : manifest.samples) s.scans[0].points = 0;
  manifest.samples[1].scans[1].points = 0;
  const std::vector<ScanIndex> chosen = randomScans(manifest, {true, false}, 10, 0);
  const std::set<ScanIndex> found(chosen.begin(), chosen.end());
  EXPECT_EQ(found, (std::set<ScanIndex>{{0, 1}, {2, 1}}));
  EXPECT_TRUE(randomScans(manifest, {false, false}, 10, 0).empty());
  EXPECT_TRUE(randomScans(manifest, kSound, 0, 0).empty());
}

}  // namespace
}  // namespace scanmill
