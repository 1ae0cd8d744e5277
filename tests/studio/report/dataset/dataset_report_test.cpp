#include "report/dataset/dataset_report.h"

#include "base/file.h"
#include "base/parallel.h"
#include "tests/studio/report/dataset/made_dataset.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

constexpr std::size_t kAll = 400;

DatasetReport examined(const std::filesystem::path& folder, std::size_t samples = 0, std::size_t most = kAll) {
  return examineDataset(folder, {.samples = samples, .mostScans = most, .quiet = true});
}

// The warnings, each with its places behind it.
std::vector<std::string> warningTexts(const DatasetReport& report) {
  std::vector<std::string> texts;
  for (const DatasetWarning& w : report.warnings) {
    std::string text = w.text;
    for (const std::string& place : w.places) text += "\n" + place;
    texts.push_back(text);
  }
  return texts;
}

class MadeDataset : public testing::Test {
 protected:
  std::filesystem::path at() const { return folder_.path() / "made"; }
  DatasetReport made(const Manifest& manifest = madeManifest()) {
    writeMadeDataset(at(), samples_, manifest);
    return examined(at());
  }
  std::vector<std::string> warningsFor(const std::vector<WrittenSample>& samples, Manifest manifest = madeManifest()) {
    writeMadeDataset(at(), samples, std::move(manifest));
    return warningTexts(examined(at()));
  }

  TemporaryFolder folder_;
  std::vector<WrittenSample> samples_ = soundSamples();
};

// Pages are megabytes: nobody wants to see them printed.
bool has(const std::string& text, const std::string& words) {
  return text.find(words) != std::string::npos;
}

std::size_t times(const std::string& text, const std::string& words) {
  std::size_t count = 0;
  for (std::size_t i = text.find(words); i != std::string::npos; i = text.find(words, i + 1)) ++count;
  return count;
}

const ClassSummary& classNamed(const DatasetReport& report, const std::string& name) {
  for (const ClassSummary& c : report.summary.classes) {
    if (c.name == name) return c;
  }
  throw std::runtime_error("no class " + name);
}

TEST_F(MadeDataset, FiguresAreThoseOfTheScans) {
  const DatasetReport report = made();
  const DatasetSummary& s = report.summary;
  EXPECT_EQ(s.samples, 6u);
  EXPECT_EQ(s.points, 150u);
  EXPECT_EQ(s.scansRead, 6u);
  const ClassSummary& car = classNamed(report, "car");
  EXPECT_EQ(car.points, 30u);
  EXPECT_EQ(car.scans, 6u);
  EXPECT_EQ(car.views, 6u);
  EXPECT_EQ(car.objects, 2u);  // instance 3 of each of two sequences
  EXPECT_EQ(car.medianPoints, 5);
  EXPECT_EQ(car.pointsOfSplit, (std::map<std::string, std::uint64_t>{{"train", 20}, {"val", 10}}));
  ASSERT_EQ(s.sequences.size(), 2u);
  EXPECT_EQ(s.sequences[1].name, "street-s2-lane");
  EXPECT_EQ(s.sequences[1].scene, "street");
  EXPECT_EQ(s.sequences[1].seed, "2");
  EXPECT_EQ(s.sequences[1].trajectory, "lane");
  EXPECT_EQ(s.sequences[0].samples, 4u);
  EXPECT_NEAR(s.sequences[0].seconds, 0.3, 1e-9);
  const std::string page = datasetPage(report);
  for (const char* cell : {">120<", ">30<", ">80.0 %<", ">20.0 %<", "street-s2-lane"}) {
    EXPECT_TRUE(has(page, cell));
  }
}

// Of ranges, classes and sensors alike: every point is in one place.
TEST_F(MadeDataset, HistogramsHoldEveryPoint) {
  const DatasetReport report = made();
  std::uint64_t byClass = 0, bySensor = 0, intensities = 0;
  for (const ClassSummary& c : report.summary.classes) {
    for (const std::uint64_t n : c.ranges) byClass += n;
  }
  for (const SensorSummary& s : report.summary.sensors) {
    for (const std::uint64_t n : s.ranges) bySensor += n;
    for (const auto& [key, n] : s.intensities) intensities += n;
  }
  EXPECT_EQ(byClass, 150u);
  EXPECT_EQ(bySensor, 150u);
  EXPECT_EQ(intensities, 150u);
}

TEST_F(MadeDataset, ASoundOneHasNoWarnings) {
  EXPECT_THAT(warningsFor(samples_), testing::IsEmpty());
  EXPECT_FALSE(has(datasetPage(examined(at())), "id=\"warnings\""));
}

TEST_F(MadeDataset, AClassWithoutPointsIsANote) {
  Manifest manifest = madeManifest();
  manifest.ontology.classes.push_back({9, "tram", {1, 2, 3}, true, {}});
  EXPECT_THAT(warningsFor(samples_, manifest),
              testing::ElementsAre("No points of 1 of the ontology's 3 classes: tram."));
  const DatasetReport report = examined(at());
  EXPECT_TRUE(report.warnings[0].note);
  const std::string page = datasetPage(report);
  EXPECT_TRUE(has(page, "<h2>1 note</h2>") && has(page, "id=\"notes\""));
  EXPECT_FALSE(has(page, "id=\"warnings\""));
}

TEST(AlikeLines, DifferOnlyInTheirNumbers) {
  EXPECT_THAT(alikeLines({"Tree", "Bauble.001", "Bauble.002", "Bauble.017", "Star", "Tree", "lamp 7"}),
              testing::ElementsAre("Tree", "Bauble.001 and 2 alike", "Star", "lamp 7"));
}

// Training needs labels and the splits train and val, and the layout of the export has labels.
TEST_F(MadeDataset, OffersOnlyCommandsThatWork) {
  const auto offers = [&](const Manifest& manifest) {
    std::filesystem::remove_all(at());
    const std::string page = datasetPage(made(manifest));
    return std::pair(has(page, "train_example.py " + at().string()), has(page, "export " + at().string()));
  };
  Manifest bare = madeManifest();
  std::erase(bare.columns, "label");
  EXPECT_EQ(offers(madeManifest()), std::pair(true, true));
  EXPECT_EQ(offers(bare), std::pair(false, false));
  for (WrittenSample& s : samples_) s.split = "train";
  EXPECT_EQ(offers(madeManifest()), std::pair(false, true));
}

TEST_F(MadeDataset, ScansAreInTheOrderOfTheirKeys) {
  std::ranges::reverse(samples_);
  writeMadeDataset(at(), samples_);
  const DatasetReport report = examined(at(), 6);
  ASSERT_EQ(report.pictured.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_THAT(report.pictured[i].title, HasSubstr("00000" + std::to_string(i)));
}

TEST_F(MadeDataset, WarnsOfFewPointsOfAClass) {
  Manifest manifest = madeManifest();
  manifest.ontology.classes.push_back({9, "tram", {1, 2, 3}, false, {}});
  for (WrittenSample& s : samples_) {
    s.points.resize(2200, MadePoint{{20, 1, -1}, 7, 0, 1});
    if (s.split == "val") s.points[100].label = 9;
  }
  samples_[0].points[100].label = 9;
  samples_[0].points[101].label = 9;  // 4 of 13200 points
  EXPECT_THAT(warningsFor(samples_, manifest), testing::IsEmpty());
  std::filesystem::remove_all(at());
  samples_[0].points[101].label = samples_[0].points[100].label = samples_[5].points[100].label = 7;
  samples_[1].points[100].label = 7;
  EXPECT_THAT(warningsFor(samples_, manifest),
              testing::ElementsAre("Fewer than 1 in 10,000 points each: tram.", "In val but not in train: tram."));
}

// Each mistake is one warning, which names the places.
TEST_F(MadeDataset, WarnsOfMistakes) {
  struct Case {
    std::string says;
    std::function<void(std::vector<WrittenSample>&)> change;
  };
  const std::string mixed =
      "1 instance has labels of more than one class that seldom occur in one object: a sign of wrong labels.\n";
  const Case cases[]{
      {"In train but not in val: car.",
       [](auto& samples) {
         for (WrittenSample& s : samples) {
           if (s.split == "val") s.points.resize(20);
         }
       }},
      {"2.0 % of the points are unlabelled, in 1 scan.",
       [](auto& samples) { samples[2].points[0].label = samples[2].points[1].label = samples[2].points[2].label = 0; }},
      {"1 of 6 scans have no points.\nstreet-s1-lane-000001, top", [](auto& samples) { samples[1].points.clear(); }},
      {"1 scan has unusually few points: less than half of their sensor's median.\n"
       "street-s1-lane-000003, top: 12 points, where the sensor's median is 25",
       [](auto& samples) { samples[3].points.resize(12); }},
      {"The method gave up 2 beams (0.52 %), so that it is unknown whether they hit.\n"
       "street-s2-lane-000004, top: 2 beams",
       [](auto& samples) { samples[4].unresolved = 2; }},
      {mixed + "street-s1-lane-000003, instance 3: 1 road, 20 car points",
       [](auto& samples) { samples[3].points[2].instance = 3; }},
      {"Points of classes with instances that have no instance id.\ncar: 1 point",
       [](auto& samples) { samples[0].points[22].instance = 0; }}};
  for (const Case& wrong : cases) {
    std::filesystem::remove_all(at());
    std::vector<WrittenSample> samples = samples_;
    wrong.change(samples);
    EXPECT_THAT(warningsFor(samples), testing::ElementsAre(wrong.says));
  }
}

// Trees have trunks: what most have is no mistake.
TEST_F(MadeDataset, PartsThatMostInstancesHaveAreNoMistake) {
  Manifest manifest = madeManifest();
  manifest.ontology.classes.push_back({9, "wheel", {1, 2, 3}, true, {}});
  for (WrittenSample& s : samples_) {
    for (std::uint32_t id = 10; id < 14; ++id) {
      s.points.push_back({{9, 1, 0}, 65535, id, 5});
      s.points.push_back({{9, 1, 0}, 9, id, 5});
    }
  }
  EXPECT_THAT(warningsFor(samples_, manifest), testing::IsEmpty());
}

TEST_F(MadeDataset, GoesOnWithoutDamagedShards) {
  writeMadeDataset(at(), samples_, madeManifest(), true);
  const Manifest manifest = readManifest(at());
  ASSERT_EQ(manifest.shards.size(), 6u);
  std::filesystem::remove(at() / manifest.shards[0].file);
  const std::string whole = readFile(at() / manifest.shards[1].file);
  writeFile(at() / manifest.shards[1].file, whole.substr(0, 700));  // truncated
  std::string changed = readFile(at() / manifest.shards[2].file);
  changed[changed.find("DATA") + 20] ^= 1;  // of a scan
  writeFile(at() / manifest.shards[2].file, changed);
  const DatasetReport report = examined(at(), 4);
  ASSERT_EQ(report.warnings.size(), 2u);
  EXPECT_THAT(report.warnings[0].text, HasSubstr("3 shards are missing or damaged"));
  EXPECT_THAT(report.warnings[0].places,
              testing::ElementsAre(HasSubstr("is missing"), HasSubstr("has 700 bytes"), HasSubstr("SHA-256")));
  EXPECT_EQ(report.warnings[1].text, "2 of 6 scans could not be read.");
  EXPECT_THAT(report.warnings[1].places,
              testing::ElementsAre(testing::AllOf(HasSubstr(manifest.shards[1].file), HasSubstr("is truncated"))));
  EXPECT_EQ(report.summary.scansRead, 4u);
  EXPECT_EQ(report.pictured.size(), 3u);  // only of sound shards
  EXPECT_TRUE(has(datasetPage(report), "is missing"));
}

TEST_F(MadeDataset, ADamagedShardIsOneLine) {
  writeMadeDataset(at(), samples_);
  const std::string file = readManifest(at()).shards.at(0).file;
  const auto expectOneLine = [&](const char* scans, const char* says) {
    const DatasetReport report = examined(at());
    ASSERT_GE(report.warnings.size(), 2u);
    EXPECT_EQ(report.warnings[1].text, scans);
    EXPECT_THAT(report.warnings[1].places, testing::ElementsAre(testing::StartsWith(file + ": " + says)));
  };
  const auto second = ShardIndex(at() / file).find(samples_[1].key + ".top.ray_tracing.pcd")->offset;
  std::filesystem::resize_file(at() / file, second);
  expectOneLine("3 of 6 scans could not be read.", "is truncated");
  writeFile(at() / file, "no tar");
  expectOneLine("4 of 6 scans could not be read.", "cannot be read as tar");
}

TEST_F(MadeDataset, NothingToReadIsAFailure) {
  writeMadeDataset(at(), samples_);
  for (const ShardRecord& s : readManifest(at()).shards) std::filesystem::remove(at() / s.file);
  try {
    examined(at());
    FAIL();
  } catch (const InputError&) {
    FAIL() << "the input's form is not at fault";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("none of its scans can be read"));
  }
  writeFile(at() / "manifest.json", "{");
  EXPECT_THROW(examined(at()), InputError);
}

TEST_F(MadeDataset, StopsWhenAsked) {
  writeMadeDataset(at(), samples_);
  const std::atomic<bool> stop = true;
  const DatasetReportOptions options{.quiet = true, .stop = &stop};
  EXPECT_THAT(messageOf<Error>([&] { examineDataset(at(), options); }), HasSubstr("stopped: nothing was written"));
}

TEST_F(MadeDataset, ASpreadIsReadOfLargeOnes) {
  writeMadeDataset(at(), samples_);
  const DatasetReport report = examined(at(), 2, 3);
  EXPECT_EQ(report.summary.scansRead, 3u);
  EXPECT_EQ(report.summary.points, 150u);  // of the manifest
  EXPECT_EQ(report.pictured.size(), 2u);
  EXPECT_TRUE(report.warnings.empty());
  EXPECT_TRUE(has(datasetPage(report), "3 of 6 scans"));
}

TEST_F(MadeDataset, NamesStayText) {
  Manifest manifest = madeManifest();
  const std::string evil = "</script><img src=x onerror=alert(1)>\"'&";
  manifest.name = evil;
  manifest.ontology.name = evil;
  manifest.ontology.classes[1].name = evil;
  manifest.sensors[0].beams.model = evil;
  manifest.pipelineText = evil;
  manifest.modelled = {{evil, evil}};
  writeMadeDataset(at(), samples_, manifest);
  const std::string page = datasetPage(examined(at(), 2));
  EXPECT_FALSE(has(page, "<img src=x"));
  EXPECT_TRUE(has(page, "&lt;img src=x onerror=alert(1)&gt;"));
  EXPECT_TRUE(has(page, "\\u003c/script>\\u003cimg src=x"));
  // Scripts that the program carries, the data of points, and no other.
  EXPECT_EQ(times(page, "<script>"), 4u);
  EXPECT_EQ(times(page, "<script type=\"application/json\""), 1u);
  EXPECT_EQ(times(page, "</script"), 5u);
}

TEST_F(MadeDataset, ThePageAsksForNothing) {
  writeMadeDataset(at(), samples_);
  const std::string page = datasetPage(examined(at(), 4));
  EXPECT_TRUE(has(page, "default-src 'none'; script-src 'sha256-"));
  EXPECT_TRUE(has(page, "connect-src 'none'"));
  EXPECT_FALSE(has(page, "'unsafe-eval'"));
  std::string own = page;  // without scripts, which the policy above binds
  for (std::size_t i = own.find("<script>"); i != std::string::npos; i = own.find("<script>")) {
    own.erase(i, own.find("</script>", i) + 9 - i);
  }
  for (const char* attribute : {" src=\"", " href=\""}) {
    for (std::size_t i = own.find(attribute); i != std::string::npos; i = own.find(attribute, i + 1)) {
      const std::string value = own.substr(own.find('"', i) + 1, 5);
      EXPECT_TRUE(value == "data:" || value[0] == '#') << value;
    }
  }
  for (const char* words : {"@import", "url(", "<link", "<iframe", "<object"}) EXPECT_FALSE(has(own, words)) << words;
  for (const char* file : {"dataset/scan_view.js", "page/page.js"}) {
    const std::string script = readFile(std::filesystem::path(SCANMILL_SOURCE_DIR) / "src/studio/report" / file);
    for (const char* words : {"http", "fetch", "XMLHttpRequest", "import", "innerHTML", "eval"}) {
      EXPECT_FALSE(has(script, words)) << words;
    }
  }
  EXPECT_EQ(times(own, "<img src=\"data:image/png;base64,"), 8u);
  EXPECT_TRUE(has(page, "under the MIT License"));
}

TEST_F(MadeDataset, TheSameBytesOnAnyNumberOfThreads) {
  Manifest manifest = writeTestDataset(at());
  std::string first;
  for (const int threads : {1, 2, 5}) {
    const ThreadLimit limit(threads);
    const std::string page = datasetPage(examined(at(), 3));
    if (first.empty()) first = page;
    EXPECT_TRUE(page == first) << threads;
  }
  EXPECT_NE(datasetPage(examineDataset(at(), {.seed = 1, .quiet = true})), first);
}

// Two sensors, misses kept, and a dataset without labels or anything else but positions.
TEST_F(MadeDataset, OtherLayoutsAreShownToo) {
  writeTestDataset(at(), false, true);
  const DatasetReport images = examined(at(), 2);
  EXPECT_EQ(images.pictured.size(), 2u);
  std::filesystem::remove_all(at());
  Manifest bare = madeManifest();
  bare.columns = {"x", "y", "z"};
  bare.formats = {{"pcd", "pcd", 0}};
  PackedDataset writer(at(), false, 100000);
  Scan scan;
  scan.rings = 4;
  scan.columns = 16;
  scan.position = {{1, 2, 3}, {4, 5, 6}};
  ScanRecord record;
  record.sensor = "top";
  record.method = "ray_tracing";
  record.worldFromSensor = {Pose{}};
  record.beams = 64;
  record.points = 2;
  writer.add({{.key = "a-s1-b-000000", .split = "train", .scans = {record}},
              {{memberSuffix(record, "pcd"), encode("pcd", scan)}}});
  writer.finish(bare);
  const DatasetReport report = examined(at(), 1);
  EXPECT_TRUE(report.warnings.empty());
  EXPECT_EQ(report.pictured.at(0).pictures.at(0).first, "range");
  EXPECT_TRUE(has(datasetPage(report), "no class labels"));
}

TEST_F(MadeDataset, ADatasetWithoutSamplesIsAPage) {
  EXPECT_THAT(warningsFor({}), testing::ElementsAre("The dataset has no samples."));
  EXPECT_TRUE(has(datasetPage(examined(at(), 4)), "no samples"));
}

}  // namespace
}  // namespace scanmill
