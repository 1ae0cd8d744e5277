// What `plan` and `info` tell.

#include <fmt/core.h>

#include "base/file.h"
#include "dataset/manifest.h"
#include "dataset/reader.h"
#include "formats/format.h"
#include "tests/commands/program.h"

namespace scanmill {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

class Tell : public SmallWorld {
 protected:
  std::string told(const std::vector<std::string>& arguments) const {
    const Outcome o = scanmill(arguments);
    EXPECT_EQ(o.code, 0) << o.error;
    EXPECT_EQ(o.error, "");
    return o.out;
  }

  // A square of two triangles and a lone triangle, each its own object and material.
  std::string asset() const {
    return folder_
        .write("shed.obj",
               "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\no Shed_Wall\nusemtl planks\nf 1 2 3 4\no Shed_Roof\nusemtl tin\n"
               "f 1 2 3\n")
        .string();
  }
};

TEST_F(Tell, PlanSaysFirstHowLongItTakesAndHowLargeItIs) {
  const std::string out = told({"plan", pipeline_});
  EXPECT_TRUE(out.starts_with("4 frames in 1 shard\n")) << out;
  EXPECT_THAT(out, AllOf(ContainsRegex("\ntime: [0-9.]+ s \\([0-9.]+ to [0-9.]+ s\\) on [0-9]+ threads?\n"),
                         ContainsRegex("\nsize: [0-9.]+ [KM]iB \\([0-9.]+ to [0-9.]+ [KM]iB\\)\n")));
}

TEST_F(Tell, InfoDescribesEverySensor) {
  std::size_t sensors = 0;
  for (const auto& file : fs::directory_iterator(fs::path(SCANMILL_SOURCE_DIR) / "pipelines/sensors")) {
    if (file.path().extension() != ".yaml") continue;
    EXPECT_THAT(told({"info", file.path().stem()}),
                AllOf(HasSubstr("\nrange "), HasSubstr("source: "), ContainsRegex("elevation deg|field of")))
        << file.path();
    ++sensors;
  }
  EXPECT_GT(sensors, 30u);
}

TEST_F(Tell, PlanPrintsRaysMemoryAndWhatIsLeftOut) {
  const std::string out = told({"plan", pipeline_});
  EXPECT_THAT(
      out, AllOf(HasSubstr("4 frames x 512 beams = 2.05 k rays (limits.max_rays: 100 G)"),
                 ContainsRegex("memory: [0-9.]+ [KMG]?i?B for frames in flight\n"),
                 HasSubstr("properties of hits that nothing reads: left out, "), HasSubstr("scene-s1-drive"),
                 HasSubstr("scenes were not loaded; --check loads them"), HasSubstr("method: ray_tracing; --check")));
  EXPECT_THAT(told({"plan", pipeline_, "--check"}),
              AllOf(ContainsRegex("frames in flight and about [0-9.]+ [KMG]?i?B for the scene"),
                    HasSubstr("unlabelled geometry: none"), HasSubstr("rays: traced by Embree"),
                    HasSubstr("nothing to warn of"), Not(HasSubstr("were not loaded"))));
}

// A scene that cannot be loaded costs a plan nothing, and a check says what is wrong with it.
TEST_F(Tell, PlanLoadsNoSceneUnlessItIsAskedTo) {
  folder_.write("scene.yaml", fmt::format("ontology: {0}/labels/scanmill.yaml\nmaterials: {0}/labels/materials.yaml\n"
                                          "objects:\n  - {{file: absent.obj, class: building, material: wood}}\n",
                                          SCANMILL_SOURCE_DIR));
  EXPECT_THAT(told({"plan", pipeline_}), HasSubstr("\ntime: "));
  const Outcome checked = scanmill({"plan", pipeline_, "--check"});
  EXPECT_EQ(checked.code, 2);
  EXPECT_THAT(checked.error, HasSubstr("absent.obj"));
}

TEST_F(Tell, PlanSaysHowManySeedsSoManyFramesWant) {
  const std::string out = told({"plan", pipeline_, "--frames", "1001"});
  EXPECT_THAT(out, AllOf(HasSubstr("for 1,001 frames: the scenes are the same for all seeds"), HasSubstr("\ntime: ")));
  EXPECT_THAT(told({"plan", pipeline_, "--frames", "1001", "--set", "scenes.0.scene=street"}),
              HasSubstr("for 1,001 frames: 251 seeds of 4 frames, `seeds: [1, ..., 251]`"));
  EXPECT_THAT(told({"plan", pipeline_, "--frames", "30000000000", "--set", "scenes.0.scene=street"}),
              HasSubstr("--set limits.max_rays=1e+14"));
}

TEST_F(Tell, PlanListsUnlabelledGeometryOfEveryScene) {
  const std::string file = asset();
  for (const std::string folder : {"a", "b"}) {
    folder_.write(folder + "/town.yaml", fmt::format("ontology: {0}/labels/scanmill.yaml\n"
                                                     "materials: {0}/labels/materials.yaml\n"
                                                     "objects:\n  - file: {1}\n    rules: [{{match: {{node: {2}}}, "
                                                     "class: building, material: wood}}]\n",
                                                     SCANMILL_SOURCE_DIR, file, folder == "a" ? "'*'" : "'*Roof*'"));
  }
  // Scenes of the same name and seed are still two scenes.
  const std::string out =
      told({"plan", pipeline_, "--check", "--set",
            fmt::format("scenes=[{{scene: {0}}}, {{scene: {1}, trajectories: [{{name: spot, poses: [{{position: [0, 0, "
                        "1]}}]}}]}}]",
                        at("a/town.yaml"), at("b/town.yaml"))});
  EXPECT_THAT(out, AllOf(HasSubstr("no rule gives it a class"), ContainsRegex("shed.obj +planks +Shed_Wall +2\n"),
                         Not(HasSubstr("Shed_Roof"))));
}

TEST_F(Tell, PlanOfARecordingNeedsNoScene) {
  ASSERT_EQ(scanmill({"generate", pipeline_, "-q", "-o", at("out"), "--keep-hits", at("hits")}).code, 0);
  std::string text = readFile(pipeline_);
  for (const std::string key : {"scenes:", "trajectories:", "method:"}) {
    const std::size_t line = text.find(key);
    text.erase(line, text.find('\n', line) + 1 - line);
  }
  const std::string bare = folder_.write("bare.yaml", text).string();
  fs::remove(at("scene.yaml"));
  EXPECT_THAT(told({"plan", bare, "--from-hits", at("hits")}),
              AllOf(HasSubstr("scenes: none, the scans are made from the hits in " + at("hits")),
                    HasSubstr("4 frames x 512 beams"), HasSubstr("scene-s1-drive"), HasSubstr("\nsize: "),
                    HasSubstr("hits: read from a recording"), Not(HasSubstr("unlabelled"))));
  expectRefused(scanmill({"plan", bare}), "the key 'scenes' is missing");
}

TEST_F(Tell, InfoOnEveryKindOfFile) {
  ASSERT_EQ(scanmill({"generate", pipeline_, "-q", "-o", at("out")}).code, 0);
  const Manifest m = readManifest(at("out"));
  const std::string shard = at("out/" + m.shards.at(0).file);

  const std::string dataset = told({"info", at("out")});
  EXPECT_THAT(dataset, AllOf(HasSubstr("dataset small: 4 samples"), HasSubstr("train/train-000000.tar"),
                             HasSubstr("ray_tracing"), HasSubstr("ground"), HasSubstr("positions within 1 mm"),
                             HasSubstr("modelled and left out:")));
  EXPECT_EQ(told({"info", at("out/manifest.json")}), dataset);
  EXPECT_THAT(dataset, testing::Not(HasSubstr("gave up")));
  Manifest unresolved = m;
  unresolved.samples[0].scans[0].unresolved = 7;
  unresolved.samples[2].scans[0].unresolved = 4;
  folder_.write("unresolved/manifest.json", toJson(unresolved));
  EXPECT_THAT(told({"info", at("unresolved")}), HasSubstr("the method gave up 11 beams (0.54 %)"));
  EXPECT_THAT(told({"info", shard}),
              AllOf(HasSubstr("member"), HasSubstr("scene-s1-drive-000003.top.ray_tracing.drc")));

  const std::uint64_t points = m.samples[0].scans[0].points;
  readTar(shard, [&](const std::string& name, std::string_view bytes) {
    if (!name.starts_with("scene-s1-drive-000000.") || name.ends_with(".json")) return;
    const std::string file = folder_.write(name, bytes).string();
    EXPECT_THAT(told({"info", file}), AllOf(HasSubstr(fmt::format("scan {}: {} points", file, points)),
                                            HasSubstr("intensity"), HasSubstr("label"), HasSubstr("distance (m)")));
  });

  EXPECT_THAT(told({"info", at("scene.yaml")}),
              AllOf(HasSubstr("scene scene: "), HasSubstr("3 instances, 1 things"), HasSubstr("brick")));
  EXPECT_THAT(told({"info", asset(), "--colors"}), ContainsRegex("planks .*#[0-9a-f]{6} +2\n"));
  const std::string town =
      folder_
          .write("town.yaml", fmt::format("ontology: {0}/labels/scanmill.yaml\n"
                                          "materials: {0}/labels/materials.yaml\n"
                                          "objects:\n  - {{town: {{length: 100, detail: 0.05}}}}\n",
                                          SCANMILL_SOURCE_DIR))
          .string();
  EXPECT_EQ(told({"info", town}), told({"info", town, "--seed", "1"}));
  EXPECT_NE(told({"info", town}), told({"info", town, "--seed", "2"}));
  EXPECT_THAT(told({"info", SCANMILL_SOURCE_DIR "/pipelines/sensors/os1_128.yaml"}),
              AllOf(HasSubstr("sensor OS1-128: 128 rings x 1024 columns"), HasSubstr("20.950"), HasSubstr("source: ")));
  EXPECT_THAT(told({"info", pipeline_}), HasSubstr("4 frames x 512 beams"));
  EXPECT_THAT(told({"info", asset()}),
              AllOf(HasSubstr("3 triangles"), HasSubstr("Shed_Roof"), HasSubstr("planks"), HasSubstr("material")));
  std::string many = "v 0 0 0\nv 1 0 0\nv 0 0 1\n";
  for (int i = 0; i < 70; ++i) many += fmt::format("o part{}\nf 1 2 3\n{}", i, i == 69 ? "f 3 2 1\n" : "");
  const std::string parts = told({"info", folder_.write("many.obj", many)});
  EXPECT_THAT(parts, AllOf(ContainsRegex("triangles\n +part69 .*\n +part0 "), HasSubstr("and 10 more (smaller)\n")));
}

TEST_F(Tell, InfoNamesTheReturnsOfAnImage) {
  Scan scan;
  scan.rings = 2;
  scan.columns = 3;
  scan.organised = true;
  scan.planes = 2;
  scan.position.assign(12, {3, 4, 0});
  scan.position[7] = {NAN, NAN, NAN};
  const Value none;
  Fields options(none, "pcd");
  const std::string file = folder_.write("two.pcd", requireFormat("pcd", {}).make(options)->encode(scan)).string();
  EXPECT_THAT(told({"info", file}), AllOf(HasSubstr("organised 2 rings x 3 columns x 2 returns"), HasSubstr("5")));
}

}  // namespace
}  // namespace scanmill
