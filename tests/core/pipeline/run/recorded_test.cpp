// Recordings: what is traced once makes the same scans again, byte for byte, and others, without the scene.

#include "passes/exr/hits_exr.h"
#include "pipeline/run/recorder.h"
#include "tests/core/pipeline/small_world.h"
#include "tests/support/gl.h"
#include "tests/support/lines_of.h"

namespace scanmill {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kNoisy = {
    "motion=per_column", "scenes.0.seeds=[1, 2]",
    "effects=[intensity: {output: u8}, dropout: {probability: 0.1, threshold: 0.0005}, range_noise: {sigma_m: 0.02}]",
    "splits={by: seed, train: [1], test: [2]}"};

std::vector<std::string> with(std::vector<std::string> overrides, const std::vector<std::string>& more) {
  overrides.insert(overrides.end(), more.begin(), more.end());
  return overrides;
}

class RecordedTest : public Yard {
 protected:
  void keep(const std::vector<std::string>& overrides, const std::string& name, const fs::path& hits) const {
    generate(makePlan(readPipeline(pipeline_, overrides), channelsThat(&ChannelRow::recorded)),
             {.folder = out(name), .keepHits = hits, .quiet = true});
  }

  void remake(const std::vector<std::string>& overrides, const std::string& name, const fs::path& recording,
              RecordingKind kind = RecordingKind::Hits) const {
    generate(planOf(overrides, recordingIn(recording, kind)), {.folder = out(name), .quiet = true});
    EXPECT_THAT(verifyDataset(out(name)).problems, IsEmpty());
  }
};

TEST_F(RecordedTest, KeptHitsMakeTheSameBytes) {
  run(kNoisy, "direct");
  keep(kNoisy, "kept", out("hits"));
  EXPECT_TRUE(shards("direct") == shards("kept"));
  fs::remove_all(folder_.path() / "scenes");  // nobody needs it any more
  remake(kNoisy, "again", out("hits"));
  EXPECT_EQ(shards("again").size(), 4u);
  EXPECT_TRUE(shards("direct") == shards("again"));
  EXPECT_EQ(readManifest(out("again")).samples.size(), 8u);
}

TEST_F(RecordedTest, KeptHitsMakeWhatAnotherPipelineWouldTrace) {
  keep({"motion=per_column"}, "plain", out("hits"));  // the run itself has no effects
  for (const auto& more : std::vector<std::vector<std::string>>{
           {"effects=[intensity: {output: u8}, range_noise: {sigma_m: 0.1}]", "output.formats=[draco]"},
           {"effects=[intensity: {gain: 3}, dropout: {threshold: 0.001}]", "output.layout=organised"},
           {"seed=77", "effects=[angular_jitter: {sigma_deg: 0.1}]", "output.columns=[ring]"},
           {"output.columns=[incidence]", "output.formats=[pcd, draco, csv]"}}) {
    fs::remove_all(out("traced"));
    fs::remove_all(out("remade"));
    run(with({"motion=per_column"}, more), "traced");
    remake(with({"motion=per_column"}, more), "remade", out("hits"));
    EXPECT_TRUE(shards("traced") == shards("remade")) << more.front();
  }
}

TEST_F(RecordedTest, TheMethodOfAPipelineIsNotNeeded) {
  keep({}, "kept", out("hits"));
  std::string text = kYardPipeline;
  const auto erase = [&](const std::string& from, const std::string& to) {
    const std::size_t first = text.find(from);
    text.erase(first, text.find(to) - first);
  };
  erase("scenes:", "sensors:");
  erase("method:", "output:");
  const fs::path bare = folder_.write("bare.yaml", text);
  generate(makePlan(readPipeline(bare, {}, recordingIn(out("hits")))), {.folder = out("bare"), .quiet = true});
  EXPECT_TRUE(shards("kept") == shards("bare"));
}

TEST_F(RecordedTest, WhatDoesNotFitIsRefused) {
  keep({}, "kept", out("hits"));
  const auto refused = [&](const std::vector<std::string>& overrides, const std::vector<std::string>& words) {
    expectInputError([&] { remake(overrides, "refused", out("hits")); }, words);
  };
  std::string wider = "sensors=[" + kTop + "]";
  wider.replace(wider.find("columns: 64"), 11, "columns: 65");
  refused({wider}, {"'top' has 8 x 65 beams", "8 x 64"});
  std::string other = "sensors=[" + kTop + "]";
  other.replace(other.find("name: top"), 9, "name: tip");
  refused({other}, {"has no sensor 'tip'", "top"});
  expectInputError([&] { readRecording(out("hits"), RecordingKind::Passes); },
                   {"/kind", "recording of hits", "--from-hits"});
  expectInputError([&] { readRecording(out("kept"), RecordingKind::Hits); }, {"no recording.json", "--keep-hits"});
  expectInputError([&] { readRecording(out("nowhere"), RecordingKind::Hits); }, {"nowhere"});
  expectInputError([&] { keep({}, "second", out("hits")); }, {"hits", "--overwrite"});
  EXPECT_FALSE(fs::exists(out("second") / "manifest.json"));
}

TEST_F(RecordedTest, WhatWasMetCannotBeTurnedOrMoved) {
  keep({}, "kept", out("hits"));
  const auto refused = [&](const std::string& override, const std::vector<std::string>& words) {
    fs::remove_all(out("refused"));
    expectInputError([&] { remake({override}, "refused", out("hits")); }, words);
  };
  refused("sensors.0.first_azimuth_deg=90", {"'top'", "beams", "differ"});
  refused("sensors.0.range_m=[0.5, 50]", {"beams", "range limits"});
  refused("sensors.0.mount.position=[0, 0, 3]", {"'top'", "recorded hits cannot be moved", "[0, 0, 1.8]"});
  refused(fmt::format("labels={}/labels/semantic_kitti.yaml", SCANMILL_SOURCE_DIR),
          {"other classes", "cannot be converted"});
  std::string text = kYardPipeline;  // without a mount: the recording's
  text.erase(text.find("    mount:"), text.find("method:") - text.find("    mount:"));
  const fs::path bare = folder_.write("bare.yaml", text);
  const Manifest manifest =
      generate(makePlan(readPipeline(bare, {}, recordingIn(out("hits")))), {.folder = out("bare"), .quiet = true})
          .manifest;
  EXPECT_EQ(manifest.sensors.front().vehicleFromSensor->translation.z, 1.8);
  EXPECT_THAT(linesOf(manifest.modelled), Contains("ego motion: as in the recording"));
}

TEST_F(RecordedTest, FoldersDoNotOverlap) {
  for (const fs::path& hits : {out("same"), out("same") / "..hits", folder_.path()}) {
    expectInputError([&] { keep({}, "same", hits); }, {"separate folders"});
    EXPECT_FALSE(fs::exists(out("same") / "manifest.json"));
  }
}

TEST_F(RecordedTest, DamageIsNamed) {
  keep({}, "kept", out("hits"));
  const auto damaged = [&](const std::string& file, const std::string& bytes, const std::vector<std::string>& words) {
    const std::string whole = readFile(out("hits") / file);
    writeFile(out("hits") / file, bytes);
    fs::remove_all(out("refused"));
    expectInputError([&] { remake({}, "refused", out("hits")); }, words);
    EXPECT_FALSE(fs::exists(out("refused") / "manifest.json"));
    writeFile(out("hits") / file, whole);
  };
  const std::string shot = "yard-s1-drive-000002.top.json";
  const std::string text = readFile(out("hits") / shot);
  damaged(shot, text.substr(0, text.size() / 2), {shot, "not complete JSON"});
  damaged(shot, R"({"time": 0, "world_from_sensor": [], "hits": "a.exr"})", {shot, "/world_from_sensor", "no pose"});
  damaged(shot, R"({"time": 0, "world_from_sensor": [[1, 0, 0, 0, 0, 0, 0]], "hits": "../a.exr"})",
          {shot, "/hits", "'../a.exr'"});
  damaged(shot, R"({"time": 0, "world_from_sensor": [[1, 1, 0, 0, 0, 0, 0]], "hits": "a.exr"})",
          {shot, "/world_from_sensor/0", "quaternion"});
  const std::string image = "yard-s1-drive-000001.top.hits.exr";
  damaged(image, readFile(out("hits") / image).substr(0, 300), {image});
  Hits small;
  small.reset(2, 3, Channels::all());
  writeHits(folder_.path() / "small.exr", small);
  damaged(image, readFile(folder_.path() / "small.exr"), {image, "2 x 3", "8 x 64"});
  fs::remove(out("hits") / image);
  fs::remove_all(out("refused"));
  expectInputError([&] { remake({}, "refused", out("hits")); }, {image});
}

// A method's own outcome, carried by its hits: into recordings, and into each scan's record.
TEST_F(RecordedTest, UnresolvedBeamsAreCounted) {
  keep({}, "kept", out("hits"));
  const fs::path image = out("hits") / "yard-s1-drive-000001.top.hits.exr";
  Hits hits;
  readHits(image, channelsThat(&ChannelRow::recorded), hits);
  const std::vector<std::uint32_t> givenUp{0, 17, 300};
  const auto clear = [&](auto& column) {
    for (const std::uint32_t beam : givenUp) {
      if (!column.empty()) column[beam] = {};
    }
  };
  clear(hits.normal);
  clear(hits.instance);
  clear(hits.semantic);
  clear(hits.material);
  clear(hits.primitive);
  clear(hits.reflectance);
  clear(hits.incidence);
  for (const std::uint32_t beam : givenUp) hits.range[beam] = kMiss;
  hits.unresolved = givenUp;
  writeHits(image, hits);
  remake({}, "again", out("hits"));
  const Manifest manifest = readManifest(out("again"));
  ASSERT_EQ(manifest.samples.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    const ScanRecord& scan = manifest.samples[i].scans.at(0);
    EXPECT_EQ(scan.unresolved, i == 1 ? 3u : 0u);
    EXPECT_LE(scan.points + scan.unresolved, scan.beams);
  }
}

TEST_F(RecordedTest, AStoppedRunIsNoRecording) {
  GenerateOptions options{.folder = out("stopped"), .keepHits = out("hits"), .quiet = true};
  const std::atomic<bool> stop = true;
  options.stop = &stop;
  EXPECT_THROW(generate(planOf(), options), Error);
  EXPECT_FALSE(fs::exists(out("hits") / "recording.json"));
}

TEST_F(RecordedTest, OverwriteReplacesRecordingsOnly) {
  keep({}, "kept", out("hits"));
  GenerateOptions options{.folder = out("kept"), .keepHits = out("hits"), .overwrite = true, .quiet = true};
  generate(planOf({"trajectories.0.frames=2"}), options);
  EXPECT_FALSE(fs::exists(out("hits") / "yard-s1-drive-000003.top.json"));
  writeFile(out("hits") / "thesis.txt", "years of work");
  expectInputError([&] { generate(planOf(), options); }, {"thesis.txt"});
  EXPECT_TRUE(fs::exists(out("hits") / "thesis.txt"));
  // What looks like ours, but is not: another's image beside a recording, another's recording, images alone.
  fs::remove(out("hits") / "thesis.txt");
  writeFile(out("hits") / "beauty.0001.exr", "art");
  expectInputError([&] { generate(planOf(), options); }, {"beauty.0001.exr"});
  EXPECT_TRUE(fs::exists(out("hits") / "recording.json"));
  options.keepHits = out("studio");
  folder_.write("studio/recording.json",
                R"({"what": "scanmill recording", "schema_version": 1, "kind": "passes", "sensors": [],
                    "sequences": [{"scene": "yard", "trajectory": "drive", "frames": 1}]})");
  writeFile(out("studio") / "yard-s1-drive-000000.top.0.front.exr", "days of rendering");
  expectInputError([&] { generate(planOf(), options); }, {"studio", "another program"});
  fs::remove(out("studio") / "recording.json");
  expectInputError([&] { generate(planOf(), options); }, {"studio", "no finished recording"});
  EXPECT_EQ(readFile(out("studio") / "yard-s1-drive-000000.top.0.front.exr"), "days of rendering");
}

const std::string kCamera = "method={depth_camera: {resolution: 256}}";

class RecordedPassesTest : public RecordedTest {};

TEST_F(RecordedPassesTest, HitsOfTheDepthCameraAreKeptToo) {
  SKIP_WITHOUT_GL();
  const std::vector<std::string> overrides = with(kNoisy, {kCamera});
  keep(overrides, "kept", out("hits"));
  remake(overrides, "again", out("hits"));
  EXPECT_TRUE(shards("kept") == shards("again"));
}

// Rendered alone, with all passes; then read by another pipeline with another sampling than none at all.
TEST_F(RecordedPassesTest, RenderedPassesMakeTheSameBytes) {
  SKIP_WITHOUT_GL();
  for (const char* motion : {"motion={steps: 3, deskew: true}", "motion=none", "motion=per_column"}) {
    SCOPED_TRACE(motion);
    const std::vector<std::string> overrides = with(kNoisy, {kCamera, motion});
    for (const char* old : {"direct", "again", "passes"}) fs::remove_all(out(old));
    const RenderOptions options{.folder = out("passes"), .passes = {Channels::all(), true}, .quiet = true};
    const RenderSummary summary =
        render(makePlan(readPipeline(pipeline_, overrides), options.passes.channels), options);
    EXPECT_EQ(summary.shots, 8u);
    EXPECT_GE(summary.images, 8u);
    run(overrides, "direct");
    remake(overrides, "again", out("passes"), RecordingKind::Passes);
    EXPECT_TRUE(shards("direct") == shards("again"));
  }
  const std::string nearest = "method={depth_camera: {resolution: 256, sampling: nearest}}";
  run(with(kNoisy, {nearest}), "nearest");
  remake(with(kNoisy, {nearest}), "nearest_again", out("passes"), RecordingKind::Passes);
  EXPECT_TRUE(shards("nearest") == shards("nearest_again"));
  EXPECT_FALSE(shards("nearest") == shards("direct"));
}

// Another renderer writes what docs/recordings.md asks for and no more: no ontology, no materials, no triangles.
TEST_F(RecordedPassesTest, PassesOfOthersMakeTheSamePoints) {
  SKIP_WITHOUT_GL();
  const std::vector<std::string> overrides = {kCamera,
                                              "effects=[intensity: {output: u8}, range_noise: {sigma_m: 0.02}]"};
  const RenderOptions options{.folder = out("passes"),
                              .passes = {Channels::all().without(Channel::Material | Channel::Primitive), true},
                              .quiet = true};
  render(makePlan(readPipeline(pipeline_, overrides), options.passes.channels), options);
  writeFile(out("passes") / "recording.json", R"({"what": "scanmill recording", "schema_version": 1, "kind": "passes",
    "sensors": [{"name": "top", "rings": 8, "columns": 64}],
    "sequences": [{"scene": "yard", "trajectory": "drive", "frames": 4}]})");
  run(overrides, "direct");
  expectInputError([&] { remake(overrides, "nameless", out("passes"), RecordingKind::Passes); },
                   {"no ontology", "labels"});
  remake(with(overrides, {fmt::format("labels={}/labels/scanmill.yaml", SCANMILL_SOURCE_DIR)}), "again", out("passes"),
         RecordingKind::Passes);
  EXPECT_TRUE(shards("direct") == shards("again"));
}

TEST_F(RecordedPassesTest, MaterialsThatNobodyListsAreNamed) {
  SKIP_WITHOUT_GL();
  const RenderOptions options{.folder = out("passes"), .passes = {Channels::all(), false}, .quiet = true};
  render(makePlan(readPipeline(pipeline_, {kCamera}), options.passes.channels), options);
  std::string index = readFile(out("passes") / "recording.json");
  const std::size_t first = index.find("\"materials\": [");
  index.replace(first, index.find("\"modelled\"") - first, "\"materials\": [[]], ");
  writeFile(out("passes") / "recording.json", index);
  expectInputError(
      [&] {
        remake({kCamera, "effects=[intensity]"}, "again", out("passes"), RecordingKind::Passes);
      },
      {"recording.json", "/materials/0", "has 0 materials", "roughness"});
}

TEST_F(RecordedPassesTest, WhatIsNotThereIsNamed) {
  SKIP_WITHOUT_GL();
  RenderOptions options{.folder = out("passes"), .passes = {Channel::Range, false}, .quiet = true};
  render(planOf({kCamera}), options);
  expectInputError([&] { remake({kCamera}, "again", out("passes"), RecordingKind::Passes); },
                   {".exr", "channel", "normal"});
  options.folder = out("none");
  expectInputError([&] { render(planOf(), options); }, {"ray_tracing", "depth_camera"});
  expectInputError(
      [&] {
        render(planOf({kCamera}), {out("passes"), {}, false, true, nullptr});
      },
      {"passes", "--overwrite"});
}

}  // namespace
}  // namespace scanmill
