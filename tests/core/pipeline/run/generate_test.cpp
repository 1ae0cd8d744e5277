#include "pipeline/run/generate.h"

#include <array>
#include <tuple>

#include "base/hash.h"
#include "dataset/card.h"
#include "dataset/dataset_folder.h"
#include "formats/format.h"
#include "pipeline/plan/shard_jobs.h"
#include "tests/core/pipeline/small_world.h"
#include "tests/support/gl.h"

namespace scanmill {
namespace {

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

// A random number's address holds the sequence's index in the pipeline: what comes before may not change, what comes
// after may.
TEST_F(GenerateTest, LaterSequencesDoNotChangeEarlierOnes) {
  std::vector<std::string> alone = everything();
  alone[1] = "scenes.0.seeds=[1]";
  alone[2] = "name=alone";
  sound(alone, "alone");
  sound(everything(), "among");
  const MembersByName among = members("among");
  const MembersByName one = members("alone");
  EXPECT_EQ(one.size(), 4u * (1 + 2 * 3));
  for (const auto& [name, content] : one) EXPECT_TRUE(among.at(name) == content) << name;
}

TEST_F(GenerateTest, TheManifestAndTheSummaryTellWhatWasMade) {
  const GenerateSummary s = run(everything());
  EXPECT_THAT(verifyDataset(out()).problems, IsEmpty());
  const Manifest m = readManifest(out());
  EXPECT_EQ(m.name, "yard");
  EXPECT_EQ(m.seed, 3u);
  EXPECT_THAT(m.pipelineText, AllOf(HasSubstr("name: yard"), HasSubstr("# --set scenes.0.seeds=[1, 2, 3]")));
  EXPECT_THAT(m.columns,
              ElementsAre("x", "y", "z", "intensity", "label", "instance", "ring", "column", "time", "range_true"));
  ASSERT_EQ(m.sensors.size(), 2u);
  EXPECT_EQ(m.sensors[1].name, "front");
  EXPECT_EQ(m.sensors[1].vehicleFromSensor->translation, (Vec3d{2, 0, 0.8}));
  EXPECT_EQ(m.formats.size(), 3u);
  std::uint64_t points = 0;
  std::map<std::uint16_t, std::uint64_t> perClass;
  std::map<std::string, int> perSplit;
  for (const SampleRecord& sample : m.samples) {
    ++perSplit[sample.split];
    const std::string& split = sample.split;
    EXPECT_TRUE(sample.key.starts_with(split == "train" ? "yard-s1-" : split == "val" ? "yard-s2-" : "yard-s3-"));
    std::vector<std::string> members{sample.key + ".json"};
    for (const char* sensor : {"top", "front"}) {
      for (const char* suffix : {"pcd", "drc", "csv"}) {
        members.push_back(fmt::format("{}.{}.ray_tracing.{}", sample.key, sensor, suffix));
      }
    }
    EXPECT_EQ(sample.members, members);
    ASSERT_EQ(sample.scans.size(), 2u);
    const Vec3d top = sample.scans[0].worldFromSensor.front().translation;
    EXPECT_LT(length(sample.scans[1].worldFromSensor.front().translation - top - Vec3d{2, 0, -1}), 1e-9);
    for (const ScanRecord& scan : sample.scans) {
      points += scan.points;
      for (const auto& [id, count] : scan.pointsPerClass) perClass[id] += count;
    }
  }
  EXPECT_EQ(perSplit, (std::map<std::string, int>{{"test", 4}, {"train", 4}, {"val", 4}}));
  std::uint64_t bytes = 0;
  for (const ShardRecord& shard : m.shards) bytes += std::filesystem::file_size(out() / shard.file);
  EXPECT_EQ(s.beams, 12u * (8 * 64 + 3 * 100));
  EXPECT_EQ(s.points, points);
  EXPECT_EQ(s.pointsPerClass, perClass);
  EXPECT_EQ(s.bytes, bytes);
  for (const char* stage : {"setup", "trace", "effects", "encode", "write"}) EXPECT_GT(s.stages.at(stage), 0) << stage;
}

TEST_F(GenerateTest, ACardStandsBesideTheManifest) {
  const Manifest m = sound({"about={license: CC-BY-4.0, creator: Some Body, description: A yard}"});
  EXPECT_EQ(m.about.size(), 3u);
  EXPECT_EQ(readFile(out() / kCardName), cardText(m));
  EXPECT_THAT(readFile(out() / kCardName), HasSubstr("A yard."));
  run({}, "out", true);
  EXPECT_THAT(readFile(out() / kCardName), HasSubstr("License: not stated"));
  EXPECT_THAT(messageOf([&] { run({"about={licence: MIT}"}, "no"); }), HasSubstr("did you mean 'license'"));
}

// The seed is that of the noise: beams, labels and noise-free ranges stay.
TEST_F(GenerateTest, AnotherSeedChangesTheNoiseAlone) {
  const std::vector<std::string> noisy{"effects=[range_noise: {sigma_m: 0.05}]"};
  std::vector<std::string> other = noisy;
  other.emplace_back("seed=4");
  sound(noisy, "a");
  sound(other, "b");
  const std::vector<Scan> a = scans(".pcd", "a");
  const std::vector<Scan> b = scans(".pcd", "b");
  ASSERT_EQ(a.size(), 4u);
  std::size_t moved = 0;
  std::size_t points = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].size(), b[i].size());
    EXPECT_EQ(a[i][kLabel], b[i][kLabel]);
    EXPECT_EQ(a[i][kRangeTrue], b[i][kRangeTrue]);
    EXPECT_EQ(rowsByBeam(a[i]), rowsByBeam(b[i]));
    for (std::size_t p = 0; p < a[i].size(); ++p) moved += a[i].position[p] == b[i].position[p] ? 0 : 1;
    points += a[i].size();
  }
  EXPECT_GT(moved, points * 99 / 100);
}

// The sensor looks at the yard's faces, whose distances and angles of incidence have closed forms.
TEST_F(GenerateTest, PointsLieOnTheSceneAndBearItsLabels) {
  const Manifest m = sound({"output.columns=[label, instance, incidence]"});
  const std::uint16_t car = m.ontology.require("car", {}).id;
  const std::map<std::uint16_t, std::array<double, 3>> known{
      {m.ontology.require("ground", {}).id, {INFINITY, INFINITY, 0}},
      {m.ontology.require("wall", {}).id, {30, 20, INFINITY}}};
  const std::vector<Scan> all = scans();
  std::map<std::uint16_t, int> seen;
  for (std::size_t s = 0; s < all.size(); ++s) {
    const Pose& pose = m.samples[s].scans[0].worldFromSensor.front();
    for (std::size_t i = 0; i < all[s].size(); ++i) {
      const Vec3d p = pose * Vec3d(all[s].position[i]);
      const Vec3d beam = normalized(p - pose.translation);
      const std::uint16_t label = all[s][kLabel][i];
      ++seen[label];
      const auto off = [&](double x, double y,
                           double z) {  // distances from the faces of these distances from the middle
        return std::array{std::abs(std::abs(p.x - (label == car ? 8 : 0)) - x),
                          std::abs(std::abs(std::abs(p.y) - (label == car ? 5 : 0)) - y), std::abs(p.z - z)};
      };
      const std::array<double, 3> faces = label == car ? off(2, 1, 1.5) : std::apply(off, known.at(label));
      const std::size_t nearest = static_cast<std::size_t>(std::ranges::min_element(faces) - faces.begin());
      EXPECT_NEAR(faces[nearest], 0, 1e-4);
      const double along[] = {beam.x, beam.y, beam.z};
      EXPECT_NEAR(all[s][kIncidence][i], std::acos(std::abs(along[nearest])), 5e-4);
      EXPECT_EQ(all[s][kInstance][i], label != car ? 0u : p.y > 0 ? 1u : 2u);
    }
  }
  EXPECT_EQ(seen.size(), 3u);
  EXPECT_GT(seen[car], 0);
}

TEST_F(GenerateTest, OneBeamIsEnough) {
  const Manifest m = sound({"sensors.0.columns=1", "sensors.0.elevation_deg=[-10]", "motion=per_column",
                            "output.formats=[pcd, draco, csv]", "output.layout=organised"});
  EXPECT_EQ(m.samples.front().scans[0].points, 1u);
}

// What --overwrite would replace stays until the new run is known to work.
TEST_F(GenerateTest, ABrokenRunDoesNotCostTheDatasetThatItWouldReplace) {
  sound();
  const MembersByName before = shards();
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
    opened.storeRecord(record);
  }
}

// Whatever shards an interrupted run has made, resuming gives the bytes of a run that was not interrupted, the
// manifest's too. Also where a shard was damaged meanwhile.
TEST_F(GenerateTest, ResumedRunsGiveTheSameBytes) {
  std::vector<std::string> overrides = everything();
  overrides.emplace_back("output.shard_samples=1");
  const Manifest whole = sound(overrides, "whole");
  ASSERT_EQ(whole.shards.size(), 12u);
  const Plan plan = planOf(overrides);
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
  const Plan plan = planOf(overrides);
  interrupt(out(), plan, out("whole"), {1});
  const GenerateOptions options{.folder = out(), .resume = true, .quiet = true};
  const Plan other = planOf({"output.shard_samples=1", "trajectories.0.frames=4"});
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

  const Plan plan = planOf(overrides);
  // All shards are made in one run, then the last one, of the second seed, is all that is left of it.
  generate(plan, {.folder = out("listed"), .shards = {ShardChoice::Kind::Listed, {0, 1, 2, 3}}, .quiet = true});
  DatasetFolder listed(out("listed"), FolderUse::Share, datasetPlan(plan, shardJobs(plan)));
  const auto ofSecondSeed = listed.findRecord(whole.shards[3].file, DatasetFolder::Check::Bytes);
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
              AllOf(HasSubstr("crate.obj"), HasSubstr("--overwrite"), HasSubstr("--resume=anyway")));
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
  Plan plan = planOf();
  plan.pipeline.files.push_back({"scenes/yard.yaml", "0123456789abcdef0123456789abcdef"});
  EXPECT_THAT(messageOf<InputError>([&] { generate(plan, {.folder = out(), .quiet = true}); }),
              AllOf(HasSubstr("yard.yaml"), HasSubstr("--resume=anyway")));
}

}  // namespace
}  // namespace scanmill
