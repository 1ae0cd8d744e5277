#include <set>

#include "report/dataset/scan_reading.h"

namespace scanmill {
namespace {

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
    const std::vector<ScanPlace> spread = spreadScans(manifest, most);
    ASSERT_EQ(spread.size(), most);
    EXPECT_TRUE(std::ranges::is_sorted(spread));
    EXPECT_EQ(std::set<ScanPlace>(spread.begin(), spread.end()).size(), most);
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
  const std::vector<ScanPlace> chosen = randomScans(manifest, kSound, 4, 1);
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
    for (const ScanPlace& p : randomScans(manifest, kSound, 4, seed)) {
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
  const std::vector<ScanPlace> chosen = randomScans(manifest, {true, false}, 10, 0);
  const std::set<ScanPlace> found(chosen.begin(), chosen.end());
  EXPECT_EQ(found, (std::set<ScanPlace>{{0, 1}, {2, 1}}));
  EXPECT_TRUE(randomScans(manifest, {false, false}, 10, 0).empty());
  EXPECT_TRUE(randomScans(manifest, kSound, 0, 0).empty());
}

}  // namespace
}  // namespace scanmill
