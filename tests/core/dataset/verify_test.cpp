#include "dataset/verify.h"

#include "base/error.h"
#include "base/file.h"
#include "base/parallel.h"
#include "tests/core/dataset/fixture.h"
#include "tests/support/described_beside.h"

namespace scanmill {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class VerifyTest : public ::testing::Test {
 protected:
  std::vector<std::string> problems() const { return verifyDataset(folder_.path()).problems; }

  // Changes the members of a shard, and where `honest` the manifest's hash and size with it.
  void edit(std::size_t shard, const std::function<void(Members&)>& change, bool honest = true) {
    ShardRecord& record = manifest_.shards[shard];
    const fs::path file = folder_.path() / record.file;
    Members members = membersOf(file);
    change(members);
    writeMembers(file, members);
    if (!honest) return;
    const std::string bytes = readFile(file);
    record.bytes = bytes.size();
    record.sha256 = sha256(bytes);
    saveManifest();
  }
  void saveManifest() { writeFile(folder_.path() / "manifest.json", toJson(manifest_)); }

  TemporaryFolder folder_;
  Manifest manifest_ = writeTestDataset(folder_.path());
};

TEST_F(VerifyTest, ASoundDatasetHasNoProblems) {
  std::vector<std::uint64_t> seen;
  std::uint64_t total = 0;
  const Verification result = verifyDataset(folder_.path(), [&](std::uint64_t done, std::uint64_t of) {
    seen.push_back(done);
    total = of;
  });
  EXPECT_THAT(result.problems, IsEmpty());
  EXPECT_EQ(result.shards, manifest_.shards.size());
  EXPECT_EQ(result.samples, 9u);
  EXPECT_EQ(result.scans, 36u);
  std::uint64_t points = 0;
  for (const SampleRecord& sample : manifest_.samples) {
    for (const ScanRecord& scan : sample.scans) points += 2 * scan.points;
  }
  EXPECT_EQ(result.points, points);
  EXPECT_EQ(total, manifest_.shards.size());
  ASSERT_EQ(seen.size(), manifest_.shards.size());
  for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_EQ(seen[i], i + 1);
}

TEST(Verify, SoundInEveryFormat) {
  for (const bool images : {false, true}) {
    const TemporaryFolder folder;
    Manifest manifest = testManifest();
    manifest.organised = images;
    manifest.formats.push_back({"draco", "drc", 0.001});
    PackedDataset writer(folder.path() / "data", false, 1 << 20);
    for (std::uint32_t i = 0; i < 5; ++i) {
      writer.add(testSample(manifest, i, "street-1-drive-" + std::to_string(i), "train"));
    }
    writer.finish(manifest);
    EXPECT_THAT(verifyDataset(folder.path() / "data").problems, IsEmpty()) << images;
  }
}

TEST(Verify, ScansMayBeEmpty) {
  const TemporaryFolder folder;
  Manifest manifest = testManifest();
  manifest.formats.push_back({"draco", "drc", 0.001});
  Scan empty;
  empty.rings = 4;
  empty.columns = 16;
  empty.columnsIfEmpty = columnsOf(testScan(manifest.sensors[0].beams, 0));
  Sample sample{{.key = "night-0", .split = "train", .scans = {testRecord(manifest.sensors[0], empty, 0)}}, {}};
  for (const FormatRecord& f : manifest.formats) {
    sample.files.push_back({memberSuffix(sample.scans[0], f.suffix), encode(f.name, empty)});
  }
  PackedDataset writer(folder.path() / "data", false, 1 << 20);
  writer.add(sample);
  writer.finish(manifest);
  EXPECT_THAT(verifyDataset(folder.path() / "data").problems, IsEmpty());
  empty.columnsIfEmpty = {};
  EXPECT_THAT(checkScan(empty, sample.scans[0], manifest, 0), Contains(HasSubstr("the scan has no column label")));
}

// Whatever byte of a member changes, the member is named, and so its sample.
TEST_F(VerifyTest, NamesTheMemberThatWasChanged) {
  const fs::path file = folder_.path() / manifest_.shards[1].file;
  const std::string sound = readFile(file);
  std::size_t from = 0;
  for (const auto& [name, bytes] : membersOf(file)) {
    const std::size_t first = sound.find(bytes, from);
    ASSERT_NE(first, std::string::npos);
    from = first + bytes.size();
    for (const double place : {0.0, 0.2, 0.5, 0.9}) {
      std::string damaged = sound;
      damaged[first + static_cast<std::size_t>(place * static_cast<double>(bytes.size()))] ^= 4;
      writeFile(file, damaged);
      EXPECT_THAT(problems(), Contains(HasSubstr(name))) << place;
    }
  }
  writeFile(file, sound);
  EXPECT_THAT(problems(), IsEmpty());
}

// Each is named, and the shards are checked nonetheless.
TEST_F(VerifyTest, FindsAllDamagedDescriptions) {
  ASSERT_GE(manifest_.shards.size(), 4u);
  describeBesideShards(folder_.path());
  EXPECT_THAT(problems(), IsEmpty());
  const auto beside = [&](std::size_t shard) { return folder_.path() / samplesFileOf(manifest_.shards[shard].file); };
  const auto named = [&](std::size_t shard, const char* what) {
    return AllOf(HasSubstr(samplesFileOf(manifest_.shards[shard].file)), HasSubstr(what));
  };
  std::string text = readFile(beside(0));
  text[text.size() / 2] ^= 1;
  writeFile(beside(0), text);
  fs::remove(beside(1));
  text = readFile(beside(2));
  writeFile(beside(2), text.substr(0, text.size() / 2));
  writeFile(folder_.path() / "val/val-000009.json", text);
  text = readFile(folder_.path() / manifest_.shards[1].file);
  text[text.size() / 2] ^= 1;
  writeFile(folder_.path() / manifest_.shards[1].file, text);
  const Verification result = verifyDataset(folder_.path());
  EXPECT_THAT(result.problems, ElementsAre(named(0, "was changed"), named(1, "cannot be read"), named(2, "was changed"),
                                           AllOf(HasSubstr(manifest_.shards[1].file), HasSubstr("its SHA-256 is")),
                                           "val/val-000009.json: is not in the manifest"));
  EXPECT_EQ(result.damaged.size(), 3u);
  EXPECT_EQ(result.samples, 9u);
}

// Whatever is changed in the manifest, though all of it still agrees: a sensor's elevation, a seed, a space.
TEST_F(VerifyTest, FindsAnyChangeOfTheManifest) {
  const fs::path file = folder_.path() / "manifest.json";
  const std::string sound = readFile(file);
  const auto found = [&](const std::string& text) -> std::vector<std::string> {
    writeFile(file, text);
    try {
      return problems();
    } catch (const InputError& error) {
      return {error.what()};
    }
  };
  EXPECT_THAT(found(sound), IsEmpty());
  const std::size_t step = std::max<std::size_t>(sound.size() / 300, 1);
  for (std::size_t at = 0; at < sound.size(); at += step) {
    std::string changed = sound;
    changed[at] ^= 1;
    EXPECT_THAT(found(changed), Not(IsEmpty())) << at;
  }
  EXPECT_THAT(found(sound + "\n"), ElementsAre(HasSubstr("manifest.json: was changed since it was written")));
  const std::size_t seed = sound.find("\"seed\": ") + 8;
  EXPECT_THAT(found(sound.substr(0, seed) + "5" + sound.substr(sound.find(',', seed))),
              ElementsAre(HasSubstr("its digest is")));
  std::string without = sound;
  without.erase(without.rfind(','), 79);
  EXPECT_THAT(found(without), ElementsAre(HasSubstr("key 'digest' is missing")));
}

TEST_F(VerifyTest, FindsMissingAndTruncatedShards) {
  fs::remove(folder_.path() / manifest_.shards[0].file);
  fs::resize_file(folder_.path() / manifest_.shards[1].file, manifest_.shards[1].bytes - 3000);
  const std::vector<std::string> found = problems();
  EXPECT_EQ(found[0], manifest_.shards[0].file + ": is missing");
  EXPECT_THAT(found, Contains(AllOf(HasSubstr(manifest_.shards[1].file), HasSubstr("but the manifest says"))));
  EXPECT_THAT(found,
              Contains(AllOf(HasSubstr(manifest_.shards[1].file), HasSubstr("not a complete tar file at offset"))));
}

TEST_F(VerifyTest, FindsFilesNobodyListed) {
  folder_.write("train/train-000777.tar", "x");
  folder_.write("val/val-000000.tar.partial-3", "x");
  folder_.write("extra.tar", "x");
  folder_.write("notes.txt", "a note beside the dataset is no problem");
  folder_.write("pictures/scan.png", "nor is a picture");
  folder_.write("old/train/train-000000.tar", "x");
  EXPECT_THAT(problems(),
              ElementsAre("extra.tar: is not in the manifest", "old/train/train-000000.tar: is not in the manifest",
                          "train/train-000777.tar: is not in the manifest",
                          "val/val-000000.tar.partial-3: is not in the manifest"));
}

TEST_F(VerifyTest, FindsMembersThatAreMissingAddedOrOutOfOrder) {
  edit(0, [](Members& members) { members.erase(members.begin() + 2); });
  EXPECT_THAT(problems(), ElementsAre(HasSubstr(manifest_.samples[0].members[2] + ": is missing")));
  edit(1, [](Members& members) { members.push_back({"other-0.pcd", "x"}); });
  EXPECT_THAT(problems(), Contains(HasSubstr("other-0.pcd: is not in the manifest")));
  edit(2, [](Members& members) { members.push_back(members[1]); });
  EXPECT_THAT(problems(), Contains(HasSubstr("is in the shard twice")));
  edit(3, [](Members& members) { std::swap(members[1], members[3]); });
  EXPECT_THAT(problems(), Contains(AllOf(HasSubstr(manifest_.shards[3].file), HasSubstr("out of order"))));
  EXPECT_EQ(problems().size(), 4u);
}

TEST_F(VerifyTest, FindsMembersThatDoNotDecodeOrAgree) {
  edit(0, [](Members& members) { members[1].second.resize(members[1].second.size() / 2); });
  EXPECT_THAT(problems(),
              ElementsAre(AllOf(HasSubstr(manifest_.shards[0].file), HasSubstr(manifest_.samples[0].members[1]))));
  edit(1, [](Members& members) { members[0].second = "{}"; });
  EXPECT_THAT(problems(), Contains(AllOf(HasSubstr(manifest_.shards[1].file), HasSubstr(".json: "))));
  edit(2, [](Members& members) { std::swap(members[1].second, members[3].second); });
  EXPECT_THAT(problems(), Contains(AllOf(HasSubstr(manifest_.shards[2].file), HasSubstr("points, but the manifest"))));
}

TEST_F(VerifyTest, FindsAManifestThatContradictsItself) {
  ++manifest_.shards[0].samples;
  manifest_.pipelineText += "# edited\n";
  manifest_.samples[0].scans[0].points += 1;
  manifest_.samples[0].key = "val_street-1-drive-000000";
  for (std::string& member : manifest_.samples[0].members) {
    member = manifest_.samples[0].key + member.substr(member.find('.'));
  }
  manifest_.formats.push_back({"draco", "drc", 0.001});
  saveManifest();
  const std::vector<std::string> found = problems();
  EXPECT_THAT(found, Contains("manifest.json: the SHA-256 of the pipeline's text differs from the stated one"));
  EXPECT_THAT(found, Contains("manifest.json: frames of sequence val_street-1-drive are in several splits"));
  EXPECT_THAT(found, Contains(AllOf(HasSubstr("does not list the member"), HasSubstr(".drc"))));
  EXPECT_THAT(found, Contains(HasSubstr("samples, but the manifest lists")));
}

TEST_F(VerifyTest, ListsTheSameProblemsWhateverTheThreads) {
  for (std::size_t i = 0; i < manifest_.shards.size(); ++i) {
    edit(
        i, [](Members& members) { members[1].second.resize(100); }, false);
  }
  std::vector<std::string> alone;
  {
    const ThreadLimit one(1);
    alone = problems();
  }
  EXPECT_GE(alone.size(), 2 * manifest_.shards.size());
  for (int i = 0; i < 5; ++i) EXPECT_EQ(problems(), alone);
}

TEST(Verify, AnUnreadableManifestIsRefused) {
  const TemporaryFolder folder;
  EXPECT_THROW(verifyDataset(folder.path()), InputError);
  folder.write("manifest.json", "{");
  EXPECT_THROW(verifyDataset(folder.path()), InputError);
}

// A scan, its record and its manifest, one of which breaks a law, and what is said of it.
struct CheckedScan {
  Manifest manifest = testManifest();
  Scan scan = testScan(manifest.sensors[0].beams, 1);
  ScanRecord record = testRecord(manifest.sensors[0], scan, 0);
};

struct BrokenLaw {
  void (*change)(CheckedScan&);
  std::vector<std::string> says;  // the beginnings of all lines
};

void makeImage(CheckedScan& c) {
  c.scan = organised(c.scan);
  c.manifest.organised = true;
}

const BrokenLaw kBrokenLaws[] = {
    {[](CheckedScan&) {}, {}},
    {makeImage, {}},
    {[](CheckedScan& c) { c.scan.position[5].y = NAN; }, {"1 point not finite (the first is point 5)"}},
    {[](CheckedScan& c) {
       c.scan.position[5] = {NAN, NAN, NAN};
     },
     {"1 point not finite"}},  // a dense scan has no misses
    {[](CheckedScan& c) {
       c.scan.position[3] = {200, 0, 0};
     },
     {"1 point farther than 120"}},
    {[](CheckedScan& c) { c.record.instances = 9; }, {"3 instances, but the manifest says 9"}},
    {[](CheckedScan& c) { c.record.beams = 63; }, {"63 beams, but its sensor has 64"}},
    {[](CheckedScan& c) { c.scan[kRing][0] = 4; }, {"1 point with a ring above 3 (the first is point 0)"}},
    {[](CheckedScan& c) { c.scan[kColumn][1] = 16; }, {"1 point with a column above 15 (the first is point 1)"}},
    {[](CheckedScan& c) { c.scan[kTime][5] = NAN; }, {"1 point with time not finite (the first is point 5)"}},
    {[](CheckedScan& c) { c.scan[kIntensity][6] = INFINITY; }, {"1 point with intensity not finite"}},
    {[](CheckedScan& c) {
       c.scan[kRangeTrue][2] = 80.1f;
       c.scan[kRangeTrue][3] = 0.4f;
       c.scan[kRangeTrue][4] = NAN;  // a false positive has none
     },
     {"2 points with range_true outside 0.5 to 80 m (the first is point 2)"}},
    {[](CheckedScan& c) {
       c.manifest.columns.emplace_back("cause");
       c.scan[kCause].assign(c.scan.size(), 1);
       c.scan[kRangeTrue][4] = NAN;
     },
     {"1 point with range_true"}},
    {[](CheckedScan& c) { c.manifest.columns.emplace_back("incidence"); },
     {"the scan has no column incidence, but the manifest lists it"}},
    {[](CheckedScan& c) {
       c.manifest.columns.emplace_back("incidence");
       c.scan[kIncidence].assign(c.scan.size(), static_cast<float>(kPi / 2));
       c.scan[kIncidence][1] = NAN;  // a recording may not know a normal
       c.scan[kIncidence][2] = 1.58f;
       c.scan[kIncidence][3] = -0.01f;
     },
     {"2 points with incidence outside 0 to 1.5708 rad (the first is point 2)"}},
    {[](CheckedScan& c) { c.scan[kTime].clear(); }, {}},  // it follows from ring and column
    {[](CheckedScan& c) { c.scan[kIntensity].clear(); },
     {"the scan has no column intensity, but the manifest lists it"}},
    {[](CheckedScan& c) { c.manifest.columns.pop_back(); },
     {"the scan has the column range_true, but the manifest does not list it"}},
};

TEST(ScanCheck, NamesEveryBrokenLaw) {
  for (std::size_t i = 0; i < std::size(kBrokenLaws); ++i) {
    CheckedScan c;
    kBrokenLaws[i].change(c);
    const std::vector<std::string> lines = checkScan(c.scan, c.record, c.manifest, 0.001);
    ASSERT_EQ(lines.size(), kBrokenLaws[i].says.size()) << i << testing::PrintToString(lines);
    for (std::size_t k = 0; k < lines.size(); ++k) EXPECT_THAT(lines[k], testing::StartsWith(kBrokenLaws[i].says[k]));
  }
}

TEST(ScanCheck, CountsClassesAndSizesMustAgree) {
  const auto check = [](const CheckedScan& c) { return checkScan(c.scan, c.record, c.manifest, 0.001); };
  CheckedScan c;
  c.record.points += 1;
  EXPECT_THAT(check(c), ElementsAre(HasSubstr("points, but the manifest says " + std::to_string(c.record.points))));
  c = {};
  c.record.pointsPerClass[7] += 2;
  EXPECT_THAT(check(c), ElementsAre(HasSubstr("points of road, but the manifest says")));
  c = {};
  for (std::uint16_t& label : c.scan[kLabel]) label = label == 7 ? 8 : label;
  EXPECT_THAT(check(c), ElementsAre(HasSubstr("points of class 8, which is not in the ontology 'ours'"),
                                    HasSubstr("no points of road")));
  c = {};
  makeImage(c);
  c.scan.columns = 8;
  c.scan.position.resize(32);
  EXPECT_THAT(check(c), Contains(HasSubstr("4 x 8 points, but its sensor has 4 rings of 16 columns")));
}

}  // namespace
}  // namespace scanmill
