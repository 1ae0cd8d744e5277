#include "pipeline/read/pipeline.h"

#include "scenefile/scene_file.h"
#include "sensors/trajectory.h"
#include "tests/core/pipeline/small_world.h"

namespace scanmill {
namespace {

// "line:column" of the first place at which a text stands.
std::string placeOf(const std::string& text, const std::string& what) {
  const std::size_t at = text.find(what);
  if (at == std::string::npos) return "'" + what + "' is not in the text";
  int line = 1;
  int column = 1;
  for (std::size_t i = 0; i < at; ++i) {
    column = text[i] == '\n' ? 1 : column + 1;
    line += text[i] == '\n' ? 1 : 0;
  }
  return fmt::format("{}:{}", line, column);
}

class ReadPipeline : public Yard {
 protected:
  // The pipeline with `from` replaced by `to`.
  static std::string changed(const std::string& from, const std::string& to) {
    std::string text = kYardPipeline;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  }

  std::string refusal(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    folder_.write("changed.yaml", text);
    return messageOf<InputError>([&] { makePlan(readPipeline(folder_.path() / "changed.yaml", overrides)); });
  }

  std::vector<std::string> keys(const std::vector<std::string>& overrides) const {
    std::vector<std::string> all;
    for (const Sequence& s : readPipeline(pipeline_, overrides).sequences) all.push_back(s.key() + " " + s.split);
    return all;
  }
};

TEST_F(ReadPipeline, FillsInDefaults) {
  const Pipeline p =
      readPipeline(folder_.write("minimal.yaml",
                                 "scenes: [{scene: scenes/yard.yaml}]\n"
                                 "trajectories: [{poses: [{position: [0, 0, 0]}]}]\n"
                                 "sensors: [{columns: 4, rate_hz: 5, elevation_deg: [0], range_m: [1, 9]}]\n"
                                 "method: ray_tracing\n"
                                 "output: {formats: [pcd]}\n"),
                   {});
  EXPECT_EQ(p.name, "minimal");
  EXPECT_EQ(p.seed, 1u);
  EXPECT_TRUE(p.ontology.empty());
  EXPECT_EQ(p.wavelengthNm, 905);
  ASSERT_EQ(p.sequences.size(), 1u);
  EXPECT_EQ(p.sequences[0].key(7), "yard-s1-t0-000007");
  EXPECT_EQ(p.sequences[0].sceneSeed, 1u);
  EXPECT_EQ(p.sequences[0].split, "train");
  ASSERT_EQ(p.sensors.size(), 1u);
  EXPECT_EQ(p.sensors[0].name, "lidar0");
  EXPECT_EQ(p.sensors[0].vehicleFromSensor, Pose{});
  EXPECT_EQ(p.motion.kind, MotionKind::None);
  EXPECT_TRUE(p.sensors[0].effects->empty());
  EXPECT_FALSE(p.output.layout.organised);
  EXPECT_EQ(p.output.layout.columns, ColumnSet::byDefault());
  EXPECT_EQ(p.output.shards.bytes, 256'000'000u);
  EXPECT_EQ(p.maxRays, 1e11);
}

// Keys are ASCII, so that every tar reader reads the same names; names of other scripts stay apart.
TEST_F(ReadPipeline, NamesOfOtherScriptsKeepTheirCodesInKeys) {
  EXPECT_EQ(keyPart("Straße 7.b"), "strau00dfe_7_b");
  EXPECT_THAT(keys({"trajectories=[{name: 北, poses: [{position: [0, 0, 0]}]}, "
                    "{name: 南, poses: [{position: [1, 0, 0]}]}]"}),
              ElementsAre(HasSubstr("yard-s1-u5317 "), HasSubstr("yard-s1-u5357 ")));
}

// Every seed of a town has a lane of its own; the trajectory follows it, on the road's surface.
TEST_F(ReadPipeline, FollowsTheLaneOfATown) {
  folder_.write("scenes/place.yaml", fmt::format("ontology: {0}/labels/scanmill.yaml\n"
                                                 "materials: {0}/labels/materials.yaml\n"
                                                 "objects: [{{town: {{length: 120}}, position: [1000, 0, 50]}}]\n",
                                                 SCANMILL_SOURCE_DIR));
  const auto read = [&](const std::string& scene, const std::string& trajectory) {
    return readPipeline(folder_.write("town.yaml", "scenes: [{scene: scenes/" + scene +
                                                       ", seeds: [1, 2]}]\ntrajectories: [{" + trajectory +
                                                       "}]\nsensors: [{columns: 4, rate_hz: 5, elevation_deg: [0], "
                                                       "range_m: [1, 9]}]\nmethod: ray_tracing\n"
                                                       "output: {formats: [pcd]}\n"),
                        {});
  };
  const Pipeline p = read("place.yaml", "name: drive, along: lane, speed: 10, every_m: 20, frames: 4");
  ASSERT_EQ(p.sequences.size(), 2u);
  for (const Sequence& s : p.sequences) {
    EXPECT_EQ(s.frames, 4u);
    const std::vector<Vec3d> lane = readSceneLanes(s.sceneFile, s.sceneSeed)->lane;
    EXPECT_LT(length(s.trajectory->pose(0, 0).translation - lane.front()), 1e-9);
    EXPECT_NEAR(s.trajectory->pose(0, 0).translation.x, 1000 - 40, 8);
    EXPECT_NEAR(s.trajectory->pose(0, 0).translation.z, 50, 8);
  }
  EXPECT_NE(p.sequences[0].trajectory->pose(0, 0).translation, p.sequences[1].trajectory->pose(0, 0).translation);
  EXPECT_THAT(messageOf([&] { read("yard.yaml", "along: lane, speed: 10"); }),
              AllOf(HasSubstr("town.yaml:2:"), HasSubstr("yard.yaml"), HasSubstr("has no town")));
  EXPECT_THAT(messageOf([&] { read("place.yaml", "along: lan, speed: 10"); }), HasSubstr("did you mean 'lane'"));
}

TEST_F(ReadPipeline, TakesEveryKey) {
  folder_.write("labels.yaml", readFile(SCANMILL_SOURCE_DIR "/labels/scanmill.yaml"));
  folder_.write("scenes/Other Yard.yaml", yardScene());
  const Pipeline p = readPipeline(folder_.write("deep/all.yaml", R"(name: all keys
seed: 4611686018427387904
labels: ../labels.yaml
wavelength_nm: 1064
scenes:
  - {scene: ../scenes/yard.yaml, seeds: [7, 8]}
  - scene: ../scenes/Other Yard.yaml
    trajectories: [{name: Back.Yard, poses: [{position: [1, 2, 3]}]}]
trajectories: [{name: drive, waypoints: [[0, 0, 0], [9, 0, 0]], speed: 1, every_m: 1, frames: 3}]
sensors:
  - {name: top, columns: 4, rate_hz: 5, elevation_deg: [3, 2], range_m: [1, 9], mount: {position: [1, 2, 3], yaw_deg: 90}}
  - {name: rear_2, columns: 8, rate_hz: 5, elevation_deg: [0], range_m: [1, 9]}
motion: {steps: 3, deskew: true}
method: {ray_tracing: {}}
effects:
  - quantize: {step_m: 0.01}
  - range_noise: {sigma_m: 0.01}
  - intensity
splits: {by: seed, train: [7], val: [8], test: [1]}
output:
  layout: organised
  columns: [label]
  formats: [csv, {draco: {max_error_mm: 5}}]
  shard_mb: 1.5
limits: {max_rays: 1e6}
)"),
                                  {});
  EXPECT_EQ(p.name, "all keys");
  EXPECT_EQ(p.seed, std::uint64_t{1} << 62);
  EXPECT_EQ(std::filesystem::weakly_canonical(p.ontology), folder_.path() / "labels.yaml");
  EXPECT_EQ(p.wavelengthNm, 1064);
  ASSERT_EQ(p.sequences.size(), 3u);
  EXPECT_EQ(p.sequences[1].key(), "yard-s8-drive");
  EXPECT_EQ(p.sequences[1].split, "val");
  EXPECT_EQ(p.sequences[2].key(), "other_yard-s1-back_yard");  // keys hold neither dots nor spaces
  EXPECT_EQ(std::filesystem::weakly_canonical(p.sequences[2].sceneFile), folder_.path() / "scenes/Other Yard.yaml");
  EXPECT_EQ(p.frames(), 3u + 3u + 1u);
  EXPECT_EQ(p.raysPerFrame(), 4u * 2u + 8u);
  EXPECT_EQ(p.sensors[1].name, "rear_2");
  EXPECT_EQ(p.sensors[0].vehicleFromSensor.translation, (Vec3d{1, 2, 3}));
  EXPECT_NEAR((p.sensors[0].vehicleFromSensor * Vec3d{1, 0, 0}).y, 3, 1e-12);
  EXPECT_EQ(p.motion.kind, MotionKind::Steps);
  EXPECT_EQ(p.motion.steps, 3u);
  EXPECT_TRUE(p.motion.deskew);
  std::vector<std::string_view> effects;
  for (const ChosenEffect& e : *p.sensors[0].effects) effects.push_back(e.entry->name);
  EXPECT_THAT(effects, ElementsAre("intensity", "range_noise", "quantize"));  // by stage, not by the file's order
  EXPECT_TRUE(p.output.layout.organised && p.output.layout.columns.has(kLabel));
  EXPECT_EQ(p.output.layout.columns, ColumnSet(kLabel));
  ASSERT_EQ(p.output.formats.size(), 2u);
  EXPECT_EQ(p.output.formats[0].entry->name, "csv");
  EXPECT_DOUBLE_EQ(p.output.formats[1].format->maxError(), 0.005);
  EXPECT_EQ(p.output.shards.bytes, 1'500'000u);
  EXPECT_EQ(p.maxRays, 1e6);
}

TEST_F(ReadPipeline, OverridesReplaceAndAreRemembered) {
  const Pipeline p = readPipeline(pipeline_, {"seed=9", "trajectories.0.frames=2", "scenes.0.seeds=[4,5]",
                                              "output.formats=[csv, pcd]", "motion={steps: 5}"});
  EXPECT_EQ(p.seed, 9u);
  EXPECT_EQ(p.frames(), 4u);
  EXPECT_EQ(p.output.formats.size(), 2u);
  EXPECT_EQ(p.motion.steps, 5u);
  EXPECT_EQ(p.text, std::string(kYardPipeline) +
                        "# --set seed=9\n# --set trajectories.0.frames=2\n# --set scenes.0.seeds=[4,5]\n"
                        "# --set output.formats=[csv, pcd]\n# --set motion={steps: 5}\n");
  EXPECT_THAT(refusal(kYardPipeline, {"outptu.shard_mb=3"}), HasSubstr("did you mean 'output'?"));
  EXPECT_THAT(refusal(kYardPipeline, {"sensors.1.name=x"}), HasSubstr("--set sensors.1.name"));
}

// The text in the manifest must stay the pipeline that ran.
TEST_F(ReadPipeline, OverridesAreCommentsEvenWhereTheLastLineIsOpen) {
  std::string text = kYardPipeline;
  text.pop_back();
  const Pipeline p = readPipeline(folder_.write("open.yaml", text), {"seed=9"});
  EXPECT_EQ(p.text, text + "\n# --set seed=9\n");
  const Pipeline lines = readPipeline(pipeline_, {"name=\"two\nlines\""});
  EXPECT_EQ(lines.name, "two lines");
  EXPECT_EQ(lines.text, std::string(kYardPipeline) + "# --set name=\"two\n# lines\"\n");
}

// Such as those of a pipeline that was taken from a manifest.
TEST_F(ReadPipeline, CommentsOfAFileThatLookLikeOverridesStayComments) {
  const std::string text = std::string(kYardPipeline) + "# --set seed=7\n";
  const auto file = folder_.write("own.yaml", text);
  const Pipeline plain = readPipeline(file, {});
  EXPECT_EQ(plain.seed, 3u);
  EXPECT_EQ(plain.text, text + "#\n");
  EXPECT_EQ(readPipelineText(plain.text, file).seed, 3u);
  const Pipeline overridden = readPipeline(file, {"name=other"});
  EXPECT_EQ(overridesIn(overridden.text), std::vector<std::string>{"name=other"});
  EXPECT_EQ(readPipelineText(overridden.text, file).seed, 3u);
  EXPECT_EQ(readPipelineText(overridden.text, file).name, "other");
}

TEST_F(ReadPipeline, KeysWithoutAValueCountAsAbsent) {
  const Pipeline p = readPipeline(
      pipeline_,
      {"name=", "seed=", "sensors.0.name=", "sensors.0.mount=", "effects=", "trajectories.0.name=", "output.columns="});
  EXPECT_EQ(p.name, "yard");
  EXPECT_EQ(p.seed, 1u);
  EXPECT_EQ(p.sensors[0].name, "lidar0");
  EXPECT_EQ(p.sensors[0].vehicleFromSensor, Pose{});
  EXPECT_EQ(p.sequences[0].key(), "yard-s1-t0");
  EXPECT_TRUE(p.output.layout.columns.has(kLabel));
}

// A key of a preset is refused where it stands.
TEST_F(ReadPipeline, PresetsAreRefusedInTheirOwnFile) {
  const std::string preset = "model: tiny\ncolumns: 16\nrate_hz: 10\nelevation_deg: [0, -5]\nrange_m: [1, 50]\n";
  const std::string use =
      "sensors: [{preset: tiny.yaml}]\nmethod: ray_tracing\noutput: {formats: [pcd]}\n"
      "scenes: [{scene: scenes/yard.yaml}]\ntrajectories: [{poses: [{position: [0, 0, 0]}]}]\n";
  folder_.write("tiny.yaml", preset + "columms: 3\n");
  EXPECT_THAT(refusal(use), AllOf(HasSubstr("tiny.yaml:6:1"), HasSubstr("did you mean 'columns'")));
  folder_.write("tiny.yaml", "");
  EXPECT_THAT(refusal(use), AllOf(HasSubstr("tiny.yaml"), HasSubstr("empty")));
  folder_.write("tiny.yaml", "columns: 3\n");
  EXPECT_THAT(refusal(use), HasSubstr("elevation_deg"));
}

struct Refusal {
  std::string from, to, where;  // `where`: a text that stands at the place in the message
  std::string says;             // words that " | " separates
};

const Refusal kRefusals[] = {
    // Unknown keys at every level, with a suggestion.
    {"seed: 3", "sede: 3", "sede", "sede | did you mean 'seed'"},
    {"  - scene: scenes/yard.yaml", "  - {scene: scenes/yard.yaml, seed: 1}", "seed: 1}", "'seeds'"},
    {"speed: 20", "sped: 20, speed: 20", "sped", "did you mean 'speed'"},
    {"rate_hz: 10", "rate_hz: 10\n    rat_hz: 3", "rat_hz", "did you mean 'rate_hz'"},
    {"rings: 8}", "rings: 8, ring: 8}", "ring: 8}", "did you mean 'rings'"},
    {"[0, 0, 1.8]}", "[0, 0, 1.8], yaw: 3}", "yaw", "yaw_deg"},
    {"method:", "motion: {steps: 3, deskw: true}\nmethod:", "deskw", "did you mean 'deskew'"},
    {"method:", "effects: [range_noise: {sigma: 1}]\nmethod:", "sigma", "sigma_m"},
    {"method:", "splits: {trian: 1}\nmethod:", "trian", "train"},
    {"  formats: [pcd]", "  format: [pcd]\n  formats: [pcd]", "format: ", "did you mean 'formats'"},
    {"[pcd]", "[draco: {max_error: 1}]", "max_error", "max_error_mm"},
    {"method:", "limits: {max_ray: 3}\nmethod:", "max_ray", "did you mean 'max_rays'"},
    // Unknown names.
    {"ray_tracing", "ray_trace", "ray_trace", "did you mean 'ray_tracing'"},
    {"method:", "effects: [range_nois]\nmethod:", "range_nois", "did you mean 'range_noise'"},
    {"[pcd]", "[pdc]", "pdc", "did you mean 'pcd'"},
    {"[intensity, label", "[intensity, lable", "lable", "did you mean 'label'"},
    {"output:", "output:\n  layout: dens", "dens", "did you mean 'dense'"},
    {"method:", "motion: per_colum\nmethod:", "per_colum", "did you mean 'per_column'"},
    {"seed: 3", "wavelength_nm: 900", "900", "did you mean '905'"},
    // Wrong types and ranges.
    {"seed: 3", "seed: three", "three", "whole number"},
    {"seed: 3", "seed: -3", "-3", "whole number"},
    {"  - scene: scenes/yard.yaml", "  scene: scenes/yard.yaml", "scene: sc", "list"},
    {"scenes:\n  - scene: scenes/yard.yaml", "scenes: []", "[]", "at least one"},
    {"yard.yaml", "yard.yaml\n    seeds: [1, x]", "x]", "whole number"},
    {"yard.yaml", "yard.yaml\n    seeds: []", "[]", "at least one seed"},
    {"columns: 64", "columns: [64]", "[64]", "columns"},
    {"mount: {position: [0, 0, 1.8]}", "mount: [0, 0, 1.8]", "[0, 0, 1.8]", "mount"},
    {"mount: {position: [0, 0, 1.8]}", "mount: {position: [1e300, 0, 1.8]}", "{position: [1e300", "farther than"},
    {"method:", "effects: {quantize: {step_m: 1}}\nmethod:", "{quantize", "effects must be a list"},
    {"method:", "effects: [{quantize: {step_m: 1}, intensity: {}}]\nmethod:", "{quantize", "one"},
    {"method:", "effects: [quantize: 3]\nmethod:", "3]", "quantize"},
    {"method:", "effects: [quantize: {step_m: -1}]\nmethod:", "-1}", "step_m"},
    {"method: ray_tracing", "method: [ray_tracing]", "[ray", "method"},
    {"method: ray_tracing", "method: teleport", "teleport", "known: ray_tracing"},
    {"method: ray_tracing", "method: {particle: {voxel_mm: 1}}", "voxel_mm", "did you mean 'voxel_m'"},
    {"method: ray_tracing", "method: {auto: {min_rate: 5e6}}", "{auto", "write `method: ray_tracing` | tradeoff.md"},
    {"columns: [intensity, label, instance, ring, column, time, range_true]", "columns: label", "label",
     "columns must be a list"},
    {"[pcd]", "[]", "[]", "at least one"},
    {"[pcd]", "[pcd]\n  shard_mb: big", "big", "shard_mb"},
    {"[pcd]", "[pcd]\n  shard_mb: 1e-3", "1e-3", "shard_mb"},
    {"output:", "output: [pcd]\nlimits:", "[pcd]", "output"},
    {"method:", "limits: {max_rays: .nan}\nmethod:", ".nan", "max_rays"},
    // Too much.
    {"rings: 8", "rings: 1000000", "1000000", "1000000 x 64 = 64000000 beams | 8192 rings"},
    {"columns: 64", "columns: 1099511627776", "1099511627776", "8 x 1099511627776 | 65536 columns"},
    {"frames: 4", "frames: 1000000000000", "1000000000000", "frames | 10000000"},
    // Twice the same.
    {"seed: 3", "seed: 3\nseed: 4", "seed: 4", "duplicate key 'seed'"},
    {"method:", "  - {name: top, columns: 4, rate_hz: 9, elevation_deg: [0], range_m: [1, 9]}\nmethod:",
     "{name: top, col", "two sensors are named 'top'"},
    {"method:", "effects: [quantize: {step_m: 1}, quantize: {step_m: 2}]\nmethod:", "quantize: {step_m: 2}", "twice"},
    {"[pcd]", "[pcd, csv, pcd: {encoding: ascii}]", "pcd: {", "two formats write '.pcd'"},
    {"sensors:", "  - {name: Drive, poses: [{position: [0, 0, 0]}]}\nsensors:", "{name: Drive",
     "two trajectories | 'drive' and 'Drive'"},
    {"yard.yaml", "yard.yaml\n    seeds: [5, 6, 5]", "5]", "seed 5 is listed twice"},
    {"yard.yaml", "yard.yaml\n  - {scene: other/yard.yaml}", "{scene: other", "two sequences | 'yard-s1-drive'"},
    // Names that become names of files.
    {"name: top", "name: Top/Left", "Top/Left", "file names | 'top_left'"},
    {"name: top", "name: ''", "''", "empty"},
    {"name: drive", "name: ''", "{name: ''", "empty"},
    // Effects that need others.
    {"method:", "effects: [dropout: {threshold: 0.1}]\nmethod:", "dropout", "add the effect `intensity`"},
    {"method:", "effects: [speckle: {looks: 4}]\nmethod:", "speckle",
     "'speckle' changes the power | add the effect `intensity`"},
    {"method:", "effects: [ring_bias: {range_m: [0.1, 0.2]}]\nmethod:", "[0.1", "values is 2 | one value per ring"},
    {"method:", "motion: {steps: 0}\nmethod:", "0}", "steps"},
};

TEST_F(ReadPipeline, MistakesAreRefusedWithTheirPlace) {
  const std::string file = (folder_.path() / "changed.yaml").string();
  folder_.write("other/yard.yaml", yardScene());
  for (const Refusal& r : kRefusals) {
    const std::string text = changed(r.from, r.to);
    const std::string place = file + ":" + placeOf(text, r.where) + ":";
    expectRefusals([&](const std::string&) { return refusal(text); }, {{r.to, place + " | " + r.says}});
  }
}

TEST_F(ReadPipeline, MissingKeysAreNamed) {
  for (const std::string key : {"scenes", "sensors", "method", "output"}) {
    std::string text = kYardPipeline;
    text.insert(text.find("\n" + key + ":") + 1, "# ");
    // What was below the key is a comment too.
    for (std::size_t at = text.find('\n', text.find("# " + key)); text[at + 1] == ' '; at = text.find('\n', at + 1)) {
      text[at + 1] = '#';
    }
    EXPECT_THAT(refusal(text), AllOf(HasSubstr("changed.yaml"), HasSubstr(key), HasSubstr("missing"))) << text;
  }
  EXPECT_THAT(refusal(changed("trajectories:\n  - {", "# {")), HasSubstr("no trajectories"));
}

TEST_F(ReadPipeline, AbsurdSizesAreRefusedWithTheArithmetic) {
  const std::vector<std::string> sizes{"sensors.0.elevation_deg.rings=100",
                                       "sensors.0.columns=1000",
                                       "trajectories.0.waypoints=[[0, 0, 0], [1000000, 0, 0]]",
                                       "trajectories.0.speed=100",
                                       "trajectories.0.every_s=0.001",
                                       "trajectories.0.frames=10000000"};
  EXPECT_THAT(refusal(kYardPipeline, sizes),
              AllOf(HasSubstr("changed.yaml"), HasSubstr("10000000 frames x 100000 beams = 1e+12 rays"),
                    HasSubstr("limits.max_rays = 1e+11"), HasSubstr("13.9 hours")));
  std::vector<std::string> allowed = sizes;
  allowed.emplace_back("limits.max_rays=1e12");
  EXPECT_EQ(readPipeline(pipeline_, allowed).frames(), 10'000'000u);
}

TEST_F(ReadPipeline, SplitsKeepSequencesTogether) {
  EXPECT_THAT(keys({"scenes.0.seeds=[1, 2]"}), ElementsAre("yard-s1-drive train", "yard-s2-drive train"));
  EXPECT_THAT(keys({"scenes.0.seeds=[1, 2, 3]", "splits={by: seed, train: [3], val: [1], test: [2]}"}),
              ElementsAre("yard-s1-drive val", "yard-s2-drive test", "yard-s3-drive train"));
  EXPECT_THAT(
      keys({"scenes.0.seeds=[1, 2]",
            "trajectories=[{name: a, poses: [{position: [0, 0, 0]}]}, {name: b, poses: [{position: [1, 0, 0]}]}]",
            "splits={by: trajectory, train: [b], test: [a]}"}),
      ElementsAre("yard-s1-a test", "yard-s1-b train", "yard-s2-a test", "yard-s2-b train"));
  EXPECT_THAT(refusal(kYardPipeline, {"splits={train: 0.5, val: 0.5}"}), HasSubstr("less than one"));
}

TEST_F(ReadPipeline, PathsAreRelativeToTheFileThatNamesThem) {
  const Pipeline here = readPipeline(pipeline_, {});
  EXPECT_EQ(std::filesystem::weakly_canonical(here.sequences[0].sceneFile), folder_.path() / "scenes/yard.yaml");
  folder_.write("sensors/tiny.yaml",
                "model: tiny\ncolumns: 16\nrate_hz: 10\nelevation_deg: [0, -5]\nrange_m: [1, 50]\n");
  const std::string preset = "sensors: [{name: top, preset: ../sensors/tiny.yaml, columns: 32}]\n";
  std::string text = kYardPipeline;
  text.replace(text.find("sensors:"), text.find("method:") - text.find("sensors:"), preset);
  text.replace(text.find("scenes/yard"), 6, "../scenes");
  const Pipeline deep = readPipeline(folder_.write("deep/yard.yaml", text), {});
  EXPECT_EQ(deep.raysPerFrame(), 64u);  // the pipeline's columns replace the preset's
  EXPECT_EQ(std::filesystem::weakly_canonical(deep.sequences[0].sceneFile), folder_.path() / "scenes/yard.yaml");
}

TEST_F(ReadPipeline, FilesThatAreNoPipelinesAreNamed) {
  for (const std::string text : {"", "\n", "[]", "3", "a: b: c", "\xff\xfe", "{", "&a [*a]", "name: *none"}) {
    EXPECT_THAT(refusal(text), HasSubstr("changed.yaml")) << text;
  }
  EXPECT_THAT(messageOf<InputError>([&] { readPipeline(folder_.path() / "absent.yaml", {}); }),
              HasSubstr("absent.yaml"));
  EXPECT_THAT(messageOf<InputError>([&] { readPipeline(folder_.path(), {}); }), HasSubstr(folder_.path().string()));
}

// A sensor on a link of a robot that stands turned in the vehicle's scene, with a joint that is not at 0.
TEST_F(ReadPipeline, ASensorIsMountedOnALink) {
  folder_.write(
      "mast.urdf",
      "<robot name=\"mast\"><link name=\"base_link\"><visual><geometry><box size=\"1 1 1\"/></geometry></visual>"
      "</link><link name=\"top\"/><joint name=\"lift\" type=\"prismatic\"><parent link=\"base_link\"/><child "
      "link=\"top\"/><axis xyz=\"0 0 1\"/><limit lower=\"0\" upper=\"2\"/></joint></robot>");
  folder_.write("robot.yaml",
                "objects: [{name: mast, file: mast.urdf, class: ego_vehicle, material: default, position: [1, 0, 0], "
                "yaw_deg: 90, joints: {lift: 1.5}}]\n");
  const std::string mount = "mount: {link: top, position: [0.5, 0, 0.1]}";
  const std::string text = changed("mount: {position: [0, 0, 1.8]}", mount);
  folder_.write("changed.yaml", text + "vehicle: robot.yaml\n");
  const Pipeline p = readPipeline(folder_.path() / "changed.yaml", {});
  EXPECT_NEAR(length(p.sensors[0].vehicleFromSensor.translation - Vec3d{1, 0.5, 1.6}), 0, 1e-12);
  EXPECT_NEAR(length(p.sensors[0].vehicleFromSensor * Vec3d{1, 0, 0} - Vec3d{1, 1.5, 1.6}), 0, 1e-12);
  EXPECT_THAT(refusal(text), HasSubstr("name its scene as `vehicle`"));
  EXPECT_THAT(refusal(changed("mount: {position: [0, 0, 1.8]}", "mount: {link: tpo}") + "vehicle: robot.yaml\n"),
              HasSubstr("no link 'tpo' (did you mean 'top'"));
}

}  // namespace
}  // namespace scanmill
