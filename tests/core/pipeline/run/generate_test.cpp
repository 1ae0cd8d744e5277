#include "pipeline/run/generate.h"

#include <algorithm>
#include <set>
#include <thread>

#include "base/hash.h"
#include "dataset/card.h"
#include "dataset/dataset_folder.h"
#include "formats/format.h"
#include "pipeline/plan/shard_jobs.h"
#include "tests/core/pipeline/small_world.h"
#include "tests/support/gl.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

// Two sensors, three formats, all effects, three splits.
std::vector<std::string> everything() {
  return {"sensors=[" + kTop +
              ", {name: front, columns: 100, rate_hz: 10, elevation_deg: [2, 0, -4], range_m: [1, 25], "
              "origin_offset_m: 0.03, azimuth_offset_deg: [1, 0, -1], firing_time_us: {step_us: 3}, "
              "mount: {position: [2, 0, 0.8], yaw_deg: 10}}]",
          "scenes.0.seeds=[1, 2, 3]",
          "splits={by: seed, train: [1], val: [2], test: [3]}",
          "motion=per_column",
          "effects=[intensity: {output: u8}, dropout: {probability: 0.1, threshold: 0.0005}, "
          "range_noise: {sigma_m: 0.02}, angular_jitter: {sigma_deg: 0.05}, shell: {scale_m: 0.01}, "
          "quantize: {step_m: 0.004}]",
          "output.formats=[pcd, draco: {max_error_mm: 2}, csv]"};
}

using GenerateTest = Yard;

TEST_F(GenerateTest, ThreadsDoNotChangeAByte) {
  std::vector<Bytes> bytes;
  std::vector<std::string> manifests;
  for (const int threads : {1, 2, 8}) {
    const ThreadLimit limit(threads);
    const std::string name = fmt::format("t{}", threads);
    manifests.push_back(toJson(sound(everything(), name)));
    bytes.push_back(shards(name));
  }
  EXPECT_EQ(bytes[0].size(), 6u) << "two for each split";
  EXPECT_TRUE(bytes[0] == bytes[1]);
  EXPECT_TRUE(bytes[0] == bytes[2]);
  EXPECT_EQ(manifests[0], manifests[1]);
  EXPECT_EQ(manifests[0], manifests[2]);
}

// A random number's address holds the sequence's index in the pipeline: what comes before may not change, what comes
// after may.
TEST_F(GenerateTest, LaterSequencesDoNotChangeEarlierOnes) {
  std::vector<std::string> alone = everything();
  alone[1] = "scenes.0.seeds=[1]";
  alone[2] = "name=alone";
  sound(alone, "alone");
  sound(everything(), "among");
  const Bytes among = members("among");
  const Bytes one = members("alone");
  EXPECT_EQ(one.size(), 4u * (1 + 2 * 3));
  for (const auto& [name, content] : one) EXPECT_TRUE(among.at(name) == content) << name;
}

TEST_F(GenerateTest, TheManifestTellsWhatWasMade) {
  const Manifest m = sound(everything());
  EXPECT_EQ(m.name, "yard");
  EXPECT_EQ(m.seed, 3u);
  EXPECT_THAT(m.pipelineText, AllOf(HasSubstr("name: yard"), HasSubstr("# --set scenes.0.seeds=[1, 2, 3]")));
  EXPECT_THAT(m.columns,
              ElementsAre("x", "y", "z", "intensity", "label", "instance", "ring", "column", "time", "range_true"));
  EXPECT_EQ(m.samples.size(), 12u);
  std::map<std::string, int> perSplit;
  for (const SampleRecord& s : m.samples) {
    ++perSplit[s.split];
    EXPECT_TRUE(s.key.starts_with(s.split == "train" ? "yard-s1-" : s.split == "val" ? "yard-s2-" : "yard-s3-"));
  }
  EXPECT_EQ(perSplit, (std::map<std::string, int>{{"test", 4}, {"train", 4}, {"val", 4}}));
  ASSERT_EQ(m.sensors.size(), 2u);
  EXPECT_EQ(m.sensors[1].name, "front");
  EXPECT_EQ(m.sensors[1].vehicleFromSensor->translation, (Vec3d{2, 0, 0.8}));
  EXPECT_EQ(m.formats.size(), 3u);
}

TEST_F(GenerateTest, ACardAndMetadataStandBesideTheManifest) {
  const Manifest m = sound({"about={license: CC-BY-4.0, creator: Some Body, description: A yard}"});
  EXPECT_EQ(m.about.size(), 3u);
  EXPECT_EQ(readFile(out() / kCardName), cardText(m));
  EXPECT_EQ(readFile(out() / kCroissantName), croissantJson(m));
  EXPECT_THAT(readFile(out() / kCardName), testing::HasSubstr("A yard."));
  run({}, "out", true);
  EXPECT_THAT(readFile(out() / kCardName), testing::HasSubstr("License: not stated"));
  EXPECT_THAT(messageOf([&] { run({"about={licence: MIT}"}, "no"); }), testing::HasSubstr("did you mean 'license'"));
}

TEST_F(GenerateTest, TheSummaryAddsUp) {
  const GenerateSummary s = run(everything());
  EXPECT_EQ(s.beams, 12u * (8 * 64 + 3 * 100));
  std::uint64_t points = 0;
  std::uint64_t bytes = 0;
  std::map<std::uint16_t, std::uint64_t> perClass;
  for (const SampleRecord& sample : s.manifest.samples) {
    for (const ScanRecord& scan : sample.scans) {
      points += scan.points;
      for (const auto& [id, count] : scan.pointsPerClass) perClass[id] += count;
    }
  }
  for (const ShardRecord& shard : s.manifest.shards) bytes += std::filesystem::file_size(out() / shard.file);
  EXPECT_EQ(s.points, points);
  EXPECT_EQ(s.pointsPerClass, perClass);
  EXPECT_EQ(s.bytes, bytes);
  for (const char* stage : {"setup", "trace", "effects", "encode", "write"}) EXPECT_GT(s.stages.at(stage), 0) << stage;
}

TEST_F(GenerateTest, SamplesHoldAllSensorsAndTheirMembersFollowEachOther) {
  const Manifest m = sound(everything());
  for (const SampleRecord& sample : m.samples) {
    ASSERT_EQ(sample.scans.size(), 2u);
    std::vector<std::string> expected{sample.key + ".json"};
    for (const char* sensor : {"top", "front"}) {
      for (const char* suffix : {"pcd", "drc", "csv"}) {
        expected.push_back(fmt::format("{}.{}.ray_tracing.{}", sample.key, sensor, suffix));
      }
    }
    EXPECT_EQ(sample.members, expected);
    const Pose& top = sample.scans[0].worldFromSensor.front();
    const Pose& front = sample.scans[1].worldFromSensor.front();
    EXPECT_NEAR(front.translation.x - top.translation.x, 2, 1e-9);
    EXPECT_NEAR(front.translation.z, 0.8, 1e-12);
  }
}

// The seed is that of the noise: beams, labels and noise-free ranges stay.
TEST_F(GenerateTest, AnotherSeedChangesTheNoiseAlone) {
  const std::vector<std::string> noisy{"effects=[range_noise: {sigma_m: 0.05}]"};
  std::vector<std::string> other = noisy;
  other.emplace_back("seed=4");
  sound(noisy, "a");
  sound(noisy, "again");
  sound(other, "b");
  EXPECT_TRUE(shards("a") == shards("again"));
  const std::vector<Scan> a = scans(".pcd", "a");
  const std::vector<Scan> b = scans(".pcd", "b");
  ASSERT_EQ(a.size(), 4u);
  std::size_t moved = 0;
  std::size_t points = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].size(), b[i].size());
    EXPECT_EQ(a[i][kLabel], b[i][kLabel]);
    EXPECT_EQ(a[i][kInstance], b[i][kInstance]);
    EXPECT_EQ(a[i][kRangeTrue], b[i][kRangeTrue]);
    EXPECT_EQ(a[i][kRing], b[i][kRing]);
    EXPECT_EQ(a[i][kColumn], b[i][kColumn]);
    for (std::size_t p = 0; p < a[i].size(); ++p) moved += a[i].position[p] == b[i].position[p] ? 0 : 1;
    points += a[i].size();
  }
  EXPECT_GT(moved, points * 99 / 100);
}

TEST_F(GenerateTest, ANoiseFreeReferenceJoinsByRingAndColumn) {
  sound({"motion=per_column"}, "reference");
  sound({"motion=per_column",
         "effects=[range_noise: {sigma_m: 0.05}, angular_jitter: {sigma_deg: 0.2}, quantize: {step_m: 0.01}]"},
        "noisy");
  const std::vector<Scan> references = scans(".pcd", "reference");
  const std::vector<Scan> noisy = scans(".pcd", "noisy");
  ASSERT_EQ(references.size(), noisy.size());
  for (std::size_t s = 0; s < references.size(); ++s) {
    const auto referenceRows = rowsByBeam(references[s]);
    const auto noisyRows = rowsByBeam(noisy[s]);
    ASSERT_EQ(referenceRows.size(), references[s].size());  // a beam has one row
    ASSERT_EQ(referenceRows.size(), noisyRows.size());
    double errors = 0;
    for (const auto& [beam, row] : referenceRows) {
      const std::size_t other = noisyRows.at(beam);
      const double range = length(Vec3d(references[s].position[row]));
      EXPECT_NEAR(noisy[s][kRangeTrue][other], range, 1e-6 * range);
      EXPECT_EQ(noisy[s][kLabel][other], references[s][kLabel][row]);
      errors += std::abs(length(Vec3d(noisy[s].position[other])) - range);
    }
    EXPECT_NEAR(errors / static_cast<double>(noisy[s].size()), 0.05 * std::sqrt(2 / kPi), 0.01);
  }
}

TEST_F(GenerateTest, OrganisedScansKeepEveryBeamInItsPlace) {
  sound({}, "dense");
  sound({"output.layout=organised", "output.formats=[pcd, csv]", "sensors.0.range_m=[0.5, 25]"}, "image");
  sound({"sensors.0.range_m=[0.5, 25]"}, "short");
  const std::vector<Scan> images = scans(".pcd", "image");
  const std::vector<Scan> dense = scans(".pcd", "short");
  ASSERT_EQ(images.size(), 4u);
  for (std::size_t s = 0; s < images.size(); ++s) {
    const Scan& image = images[s];
    EXPECT_TRUE(image.organised);
    EXPECT_EQ(image.height(), 8u);
    EXPECT_EQ(image.width(), 64u);
    ASSERT_EQ(image.size(), 512u);
    const auto rows = rowsByBeam(dense[s]);
    EXPECT_LT(rows.size(), 512u);
    for (std::size_t i = 0; i < image.size(); ++i) {
      const auto row = rows.find({static_cast<int>(i / 64), static_cast<int>(i % 64)});
      if (row == rows.end()) {
        EXPECT_FALSE(isFinite(image.position[i]));
        EXPECT_EQ(image[kLabel][i], 0);
      } else {
        EXPECT_EQ(image.position[i], dense[s].position[row->second]);
        EXPECT_EQ(image[kLabel][i], dense[s][kLabel][row->second]);
      }
    }
  }
}

// The sensor looks at the yard's faces, whose distance has a closed form.
TEST_F(GenerateTest, PointsLieOnTheSceneAndBearItsLabels) {
  const Manifest m = sound();
  const std::uint16_t ground = m.ontology.require("ground", {}).id;
  const std::uint16_t wall = m.ontology.require("wall", {}).id;
  const std::uint16_t car = m.ontology.require("car", {}).id;
  const std::vector<Scan> all = scans();
  std::map<std::uint16_t, int> seen;
  for (std::size_t s = 0; s < all.size(); ++s) {
    const Pose& pose = m.samples[s].scans[0].worldFromSensor.front();
    for (std::size_t i = 0; i < all[s].size(); ++i) {
      const Vec3d p = pose * Vec3d(all[s].position[i]);
      const std::uint16_t label = all[s][kLabel][i];
      ++seen[label];
      if (label == ground) {
        EXPECT_NEAR(p.z, 0, 1e-4);
      }
      if (label == wall) {
        EXPECT_NEAR(std::min(30 - std::abs(p.x), 20 - std::abs(p.y)), 0, 1e-4);
      }
      if (label == car) {
        EXPECT_NEAR(std::max({std::abs(p.x - 8) - 2, std::abs(std::abs(p.y) - 5) - 1, p.z - 1.5}), 0, 1e-4);
        EXPECT_EQ(all[s][kInstance][i], p.y > 0 ? 1u : 2u);
      } else {
        EXPECT_EQ(all[s][kInstance][i], 0u);
      }
    }
  }
  EXPECT_EQ(seen.size(), 3u);
  EXPECT_GT(seen[car], 0);
}

// Of the yard's faces: against the direction of the noise-free beam, in all formats and of all methods.
class IncidenceTest : public Yard {
 protected:
  static constexpr const char* kColumns = "output.columns=[label, ring, column, incidence]";

  // The angle between a beam from `from` and the normal of the nearest face to `to`, of a car or of the yard itself.
  static double angleAt(const Vec3d& from, const Vec3d& to, bool car) {
    const double alongX = car ? std::abs(std::abs(to.x - 8) - 2) : std::abs(30 - std::abs(to.x));
    const double alongY = car ? std::abs(std::abs(std::abs(to.y) - 5) - 1) : std::abs(20 - std::abs(to.y));
    const double alongZ = car ? std::abs(to.z - 1.5) : std::abs(to.z);
    const Vec3d beam = normalized(to - from);
    if (alongX < std::min(alongY, alongZ)) return std::acos(std::abs(beam.x));
    return std::acos(std::abs(alongY < alongZ ? beam.y : beam.z));
  }

  // The share of the points of all scans whose incidence is the closed form's within `bound`.
  double shareWithin(double bound, const std::string& name, const std::string& suffix) const {
    const Manifest m = readManifest(out(name));
    const std::uint16_t car = m.ontology.require("car", {}).id;
    const std::vector<Scan> all = scans(suffix, name);
    std::size_t points = 0;
    std::size_t right = 0;
    for (std::size_t s = 0; s < all.size(); ++s) {
      const Pose& pose = m.samples[s].scans[0].worldFromSensor.front();
      EXPECT_EQ(all[s][kIncidence].size(), all[s].size());
      for (std::size_t i = 0; i < all[s].size(); ++i) {
        ++points;
        const double expected = angleAt(pose.translation, pose * Vec3d(all[s].position[i]), all[s][kLabel][i] == car);
        right += std::abs(all[s][kIncidence][i] - expected) < bound ? 1u : 0u;
      }
    }
    EXPECT_GT(points, 1000u);
    return static_cast<double>(right) / static_cast<double>(points);
  }
};

TEST_F(IncidenceTest, IsThatOfTheFacesInEveryFormat) {
  const Manifest m = sound({kColumns, "output.formats=[pcd, draco, csv]"});
  EXPECT_THAT(m.columns, ElementsAre("x", "y", "z", "label", "ring", "column", "incidence"));
  for (const char* suffix : {".pcd", ".csv", ".drc"}) EXPECT_EQ(shareWithin(5e-4, "out", suffix), 1) << suffix;
}

TEST_F(IncidenceTest, MissesHaveNone) {
  sound({kColumns, "output.layout=organised", "sensors.0.range_m=[0.5, 15]"});
  std::size_t misses = 0;
  for (const Scan& image : scans()) {
    for (std::size_t i = 0; i < image.size(); ++i) {
      EXPECT_EQ(std::isnan(image[kIncidence][i]), !isFinite(image.position[i]));
      misses += isFinite(image.position[i]) ? 0u : 1u;
    }
  }
  EXPECT_GT(misses, 0u);
}

TEST_F(IncidenceTest, IsTheSameOfEveryMethodWithinItsAccuracy) {
  sound({kColumns, "method=particle"}, "particle");
  EXPECT_EQ(shareWithin(1e-3, "particle", ".pcd"), 1);
  SKIP_WITHOUT_GL();
  sound({kColumns, "method=depth_camera"}, "camera");
  EXPECT_EQ(shareWithin(1e-3, "camera", ".pcd"), 1);
}

TEST_F(GenerateTest, DropOutLosesTheShareItSays) {
  sound({"trajectories.0.every_s=0.01", "trajectories.0.frames=40"}, "all");
  sound({"trajectories.0.every_s=0.01", "trajectories.0.frames=40", "effects=[dropout: {probability: 0.3}]"}, "some");
  std::size_t all = 0;
  std::size_t kept = 0;
  for (const Scan& s : scans(".pcd", "all")) all += s.size();
  for (const Scan& s : scans(".pcd", "some")) kept += s.size();
  const auto n = static_cast<double>(all);
  EXPECT_NEAR(static_cast<double>(kept), 0.7 * n, 5 * std::sqrt(n * 0.3 * 0.7));
}

TEST_F(GenerateTest, QuantisedRangesAreWholeSteps) {
  sound({"effects=[quantize: {step_m: 0.25}]"});
  for (const Scan& s : scans()) {
    ASSERT_GT(s.size(), 0u);
    for (std::size_t i = 0; i < s.size(); ++i) {
      const double range = length(Vec3d(s.position[i]));
      EXPECT_NEAR(range, std::round(range / 0.25) * 0.25, 1e-5);
      EXPECT_NEAR(range, s[kRangeTrue][i], 0.125 + 1e-5);
    }
  }
}

TEST_F(GenerateTest, AllFormatsHoldTheSameCloud) {
  sound(everything());
  const std::vector<Scan> pcd = scans(".pcd");
  const std::vector<Scan> draco = scans(".drc");
  const std::vector<Scan> csv = scans(".csv");
  ASSERT_EQ(pcd.size(), 24u);
  ASSERT_EQ(draco.size(), 24u);
  ASSERT_EQ(csv.size(), 24u);
  for (std::size_t s = 0; s < pcd.size(); ++s) {
    EXPECT_EQ(csv[s].position, pcd[s].position);
    EXPECT_EQ(csv[s][kRangeTrue], pcd[s][kRangeTrue]);
    for (const Scan* other : {&draco[s], &csv[s]}) {
      ASSERT_EQ(other->size(), pcd[s].size());
      EXPECT_EQ((*other)[kLabel], pcd[s][kLabel]);
      EXPECT_EQ((*other)[kInstance], pcd[s][kInstance]);
      EXPECT_EQ((*other)[kRing], pcd[s][kRing]);
      EXPECT_EQ((*other)[kColumn], pcd[s][kColumn]);
      EXPECT_EQ((*other)[kIntensity], pcd[s][kIntensity]);
    }
    for (std::size_t i = 0; i < pcd[s].size(); ++i) {
      EXPECT_LE(length(Vec3d(draco[s].position[i]) - Vec3d(pcd[s].position[i])), 0.002);
    }
  }
}

TEST_F(GenerateTest, ColumnsThatNobodyAskedForAreNotThere) {
  const Manifest m = sound({"output.columns=[]", "output.formats=[pcd, draco, csv]"});
  EXPECT_THAT(m.columns, ElementsAre("x", "y", "z"));
  for (const char* suffix : {".pcd", ".drc", ".csv"}) {
    EXPECT_THAT(columnNames(scans(suffix).front()), ElementsAre("x", "y", "z")) << suffix;
  }
}

TEST_F(GenerateTest, ScansMayBeEmpty) {
  const Manifest m = sound({"sensors.0.range_m=[0.1, 0.2]", "output.formats=[pcd, draco, csv]",
                            "effects=[intensity, range_noise: {sigma_m: 1}]"});
  for (const SampleRecord& s : m.samples) EXPECT_EQ(s.scans[0].points, 0u);
  sound({"sensors.0.range_m=[0.1, 0.2]", "output.layout=organised"}, "image");
}

TEST_F(GenerateTest, OneBeamIsEnough) {
  const Manifest m = sound({"sensors.0.columns=1", "sensors.0.elevation_deg=[-10]", "motion=per_column",
                            "output.formats=[pcd, draco, csv]", "output.layout=organised"});
  EXPECT_EQ(m.samples.front().scans[0].points, 1u);
}

TEST_F(GenerateTest, AFolderThatIsNotEmptyIsRefusedUnlessItIsToBeReplaced) {
  sound();
  const Bytes before = shards();
  EXPECT_THAT(messageOf<InputError>([&] {
                run({"seed=5", "effects=[range_noise: {sigma_m: 1}]"});
              }),
              AllOf(HasSubstr(out().string()), HasSubstr("--overwrite")));
  EXPECT_TRUE(shards() == before);
  run({"trajectories.0.frames=1"}, "out", true);
  EXPECT_EQ(readManifest(out()).samples.size(), 1u);
  EXPECT_THAT(verifyDataset(out()).problems, testing::IsEmpty());
}

// What --overwrite would replace stays until the new run is known to work.
TEST_F(GenerateTest, ABrokenRunDoesNotCostTheDatasetThatItWouldReplace) {
  sound();
  const Bytes before = shards();
  folder_.write("scenes/broken.yaml", "objects: []\n");
  const std::pair<std::string, const char*> mistakes[] = {
      {"scenes.0.scene=" + (folder_.path() / "scenes/broken.yaml").string(),
       "broken.yaml:1:1: scene: the key 'ontology' is missing"},
      {"method={ray_tracing: {x: 1}}", "unknown key 'x'"},
      {"labels=/nowhere.yaml", "/nowhere.yaml"}};
  for (const auto& [mistake, said] : mistakes) {
    EXPECT_THAT(messageOf<InputError>([&] { run({mistake}, "out", true); }), HasSubstr(said)) << mistake;
    EXPECT_TRUE(shards() == before) << mistake;
  }
}

TEST_F(GenerateTest, StoppedRunsLeaveNothingThatLooksFinished) {
  const std::atomic<bool> stop = true;
  EXPECT_THAT(messageOf<Error>([&] { run({}, "out", false, &stop); }), HasSubstr("stopped"));
  EXPECT_FALSE(std::filesystem::exists(out()));

  std::atomic<bool> later = false;
  std::thread stopper([&] {
    // As soon as the first sample has come.
    while (!std::filesystem::exists(out("later") / ".scanmill/train")) std::this_thread::yield();
    later = true;
  });
  const std::vector<std::string> many{"trajectories.0.every_s=1e-5", "trajectories.0.frames=90000"};
  EXPECT_THAT(messageOf<Error>([&] { run(many, "later", false, &later); }), HasSubstr("stopped"));
  stopper.join();
  EXPECT_FALSE(std::filesystem::exists(out("later") / "manifest.json"));
}

// A folder in which a run has made these shards of a whole dataset, and was then interrupted.
void interrupt(const std::filesystem::path& folder, const Plan& plan, const std::filesystem::path& whole,
               const std::vector<std::size_t>& made) {
  const std::vector<ShardJob> jobs = shardJobs(plan);
  const DatasetPlan planned = datasetPlan(plan, jobs);
  DatasetFolder opened(folder, FolderUse::New, planned);
  const Manifest manifest = readManifest(whole);
  for (const std::size_t shard : made) {
    Manifest part = manifest;
    part.shards = {manifest.shards[shard]};
    std::erase_if(part.samples, [&](const SampleRecord& s) { return s.shard != shard; });
    for (SampleRecord& s : part.samples) s.shard = 0;
    const std::filesystem::path file = opened.staging() / part.shards[0].file;
    std::filesystem::create_directories(file.parent_path());
    std::filesystem::copy_file(whole / part.shards[0].file, file);
    DatasetPart record{planned.hash, {}, std::move(part)};
    for (const SampleAddress& sample : jobs[shard].samples) record.numbers.push_back(sample.number);
    opened.keep(record);
  }
}

// Whatever shards an interrupted run has made, resuming gives the bytes of a run that was not interrupted, the
// manifest's too. Also where a shard was damaged meanwhile.
TEST_F(GenerateTest, ResumedRunsGiveTheSameBytes) {
  std::vector<std::string> overrides = everything();
  overrides.emplace_back("output.shard_samples=1");
  const Manifest whole = sound(overrides, "whole");
  ASSERT_EQ(whole.shards.size(), 12u);
  const Plan plan = makePlan(readPipeline(pipeline_, overrides));
  int run = 0;
  for (const std::vector<std::size_t>& made :
       {std::vector<std::size_t>{0}, {11}, {0, 1, 2, 5, 9}, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}}) {
    for (const bool damaged : {false, true}) {
      const std::string name = fmt::format("cut{}", run++);
      SCOPED_TRACE(name);
      const GenerateOptions options{.folder = out(name), .resume = true, .quiet = true};
      interrupt(options.folder, plan, out("whole"), made);
      if (damaged) {
        const std::filesystem::path file = options.folder / ".scanmill" / whole.shards[made[0]].file;
        std::string bytes = readFile(file);
        bytes[bytes.size() / 2] ^= 4;
        writeFile(file, bytes);
      }
      const GenerateSummary resumed = generate(plan, options);
      EXPECT_EQ(resumed.resumedShards, made.size() - (damaged ? 1 : 0));
      EXPECT_EQ(readFile(options.folder / "manifest.json"), readFile(out("whole") / "manifest.json"));
      EXPECT_TRUE(shards(name) == shards("whole"));
      EXPECT_FALSE(std::filesystem::exists(options.folder / ".scanmill"));
      EXPECT_GT(resumed.points, 0u);
    }
  }
}

// What another pipeline has begun, or the same one on another scene, is not gone on with.
TEST_F(GenerateTest, ResumingRefusesOtherPipelines) {
  const std::vector<std::string> overrides{"output.shard_samples=1", "trajectories.0.frames=3"};
  sound(overrides, "whole");
  const Plan plan = makePlan(readPipeline(pipeline_, overrides));
  interrupt(out(), plan, out("whole"), {1});
  const GenerateOptions options{.folder = out(), .resume = true, .quiet = true};
  const Plan other = makePlan(readPipeline(pipeline_, {"output.shard_samples=1", "trajectories.0.frames=4"}));
  EXPECT_THAT(messageOf<InputError>([&] { generate(other, options); }), HasSubstr("another pipeline"));
  const std::filesystem::path scene = plan.pipeline.sequences[0].sceneFile;
  const std::string text = readFile(scene);
  writeFile(scene, text + "# changed\n");
  EXPECT_THAT(messageOf<InputError>([&] { generate(plan, options); }), HasSubstr("changed files"));
  writeFile(scene, text);
  EXPECT_EQ(generate(plan, options).resumedShards, 1u);
  EXPECT_THAT(messageOf<InputError>([&] { generate(plan, options); }), HasSubstr("has a complete dataset"));
}

// A mesh, a texture or a drive's poses that change between two runs would leave shards of both in one dataset. Both
// scenes of seeds show the same texture, which is read once.
TEST_F(GenerateTest, ResumingRefusesAssetsThatHaveChanged) {
  const std::string faces = "mtllib crate.mtl\nusemtl paint\nv 0 0 0\nv 1 0 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\n";
  const std::filesystem::path mesh = folder_.write("models/crate.obj", faces + "f 1/1 2/2 3/3\n");
  folder_.write("models/crate.mtl", "newmtl paint\nmap_Kd paint.ppm\n");
  const std::filesystem::path texture = folder_.write("models/paint.ppm", "P6\n1 1\n255\nabc");
  const std::filesystem::path poses = folder_.write("drive.csv", "time,x,y,z\n0,-10,0,0\n1,0,0,0\n");
  folder_.write("scenes/yard.yaml",
                yardScene() + "  - {file: ../models/crate.obj, class: ground, position: [5, 0, 0]}\n");
  const std::vector<std::string> overrides{
      "output.shard_samples=1", "scenes.0.seeds=[1, 2]", "effects=[intensity]",
      "trajectories=[{name: drive, recorded: {file: drive.csv}, every_s: 0.1, frames: 2}]"};
  const Manifest whole = sound(overrides, "whole");
  const auto hashOf = [](const Manifest& m, const std::string& file) {
    for (const FileRecord& record : m.files) {
      if (record.file == file) return record.xxh3;
    }
    return std::string();
  };
  EXPECT_EQ(hashOf(whole, "models/crate.obj"), xxh3(readFile(mesh)));
  EXPECT_EQ(hashOf(whole, "scenes/yard.yaml"), xxh3(readFile(folder_.path() / "scenes/yard.yaml")));
  EXPECT_FALSE(hashOf(whole, "scanmill:labels/materials.yaml").empty());

  const Plan plan = makePlan(readPipeline(pipeline_, overrides));
  // All shards are made in one run, then the last one, of the second seed, is all that is left of it.
  generate(plan, {.folder = out("listed"), .shards = {ShardChoice::Kind::Listed, {0, 1, 2, 3}}, .quiet = true});
  DatasetFolder listed(out("listed"), FolderUse::Share, datasetPlan(plan, shardJobs(plan)));
  const auto ofSecondSeed = listed.kept(whole.shards[3].file, DatasetFolder::Check::Bytes);
  ASSERT_TRUE(ofSecondSeed);
  EXPECT_EQ(hashOf(ofSecondSeed->manifest, "models/paint.ppm"), xxh3(readFile(texture)));
  EXPECT_EQ(hashOf(ofSecondSeed->manifest, "drive.csv"), xxh3(readFile(poses)));

  interrupt(out(), plan, out("whole"), {1});
  GenerateOptions options{.folder = out(), .resume = true, .quiet = true};
  for (const std::filesystem::path& file : {texture, poses}) {
    const std::string text = readFile(file);
    writeFile(file, text + "\n");
    EXPECT_THAT(messageOf<InputError>([&] { generate(plan, options); }), HasSubstr(file.filename().string()));
    writeFile(file, text);
  }
  writeFile(mesh, faces + "f 3/3 2/2 1/1\n");
  const GenerateOptions again{.folder = out("whole"), .shards = {ShardChoice::Kind::Any, {}}, .quiet = true};
  EXPECT_THAT(messageOf<InputError>([&] { generate(plan, again); }), HasSubstr("crate.obj")) << "of a whole dataset";
  EXPECT_THAT(messageOf<InputError>([&] { generate(plan, options); }),
              testing::AllOf(HasSubstr("crate.obj"), HasSubstr("--overwrite"), HasSubstr("--resume=anyway")));
  EXPECT_TRUE(std::filesystem::exists(out() / ".scanmill" / whole.shards[1].file)) << "nothing is lost";
  GenerateOptions others{.folder = out(), .shards = {ShardChoice::Kind::Any, {}}, .quiet = true};
  EXPECT_THAT(messageOf<InputError>([&] { generate(plan, others); }), HasSubstr("crate.obj"));
  options.anyFiles = true;
  const GenerateSummary mixed = generate(plan, options);
  EXPECT_EQ(mixed.resumedShards, 1u);
  EXPECT_EQ(mixed.manifest.files.size(), whole.files.size() + 1) << "both versions of the mesh";
}

// A file that changes after the pipeline was read is refused with the first scene, not after all shards are made.
TEST_F(GenerateTest, FilesThatChangeBeforeTheFirstSceneAreRefused) {
  Plan plan = makePlan(readPipeline(pipeline_, {}));
  plan.pipeline.files.push_back({"scenes/yard.yaml", "0123456789abcdef0123456789abcdef"});
  EXPECT_THAT(messageOf<InputError>([&] { generate(plan, {.folder = out(), .quiet = true}); }),
              AllOf(HasSubstr("yard.yaml"), HasSubstr("--resume=anyway")));
}

}  // namespace
}  // namespace scanmill
