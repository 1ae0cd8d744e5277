// Datasets of which sensors' mounts, effects and scenes are drawn at random.

#include <set>

#include "pipeline/read/drawn_sensors.h"
#include "tests/core/pipeline/small_world.h"
#include "tests/support/lines_of.h"

namespace scanmill {
namespace {

const std::string kSeeds = "scenes.0.seeds=[1, 2, 3]";
const std::string kHeight = "sensors.0.mount.position.2={uniform: [1.2, 2.4]}";
const std::string kNoise = "effects=[{range_noise: {sigma_m: {uniform: [0.01, 0.2], per: frame}}}]";

class Drawn : public Yard {
 protected:
  static std::string drawOf(const SampleRecord& sample, const std::string& key) {
    for (const DrawnValue& draw : sample.draws) {
      if (draw.key == key) return draw.value;
    }
    return "";
  }
};

// Each sample tells what was drawn: the same in all frames of a sequence, unless it is drawn for each frame.
TEST_F(Drawn, SamplesTellWhatWasDrawn) {
  const Manifest m = sound({kSeeds, kHeight, kNoise});
  ASSERT_EQ(m.samples.size(), 12U);
  std::set<std::string> heights;
  std::set<std::string> sigmas;
  for (const SampleRecord& sample : m.samples) {
    ASSERT_EQ(sample.draws.size(), 2U);
    heights.insert(drawOf(sample, "sensors.0.mount.position.2"));
    sigmas.insert(drawOf(sample, "effects.0.range_noise.sigma_m"));
    EXPECT_EQ(drawOf(sample, "sensors.0.mount.position.2"),
              fmt::format("{}", mountOf(m.sensors[0], sample.scans[0]).translation.z));
  }
  EXPECT_EQ(heights.size(), 3U);
  EXPECT_FALSE(m.sensors[0].vehicleFromSensor) << "there is no mount of all sequences";
  EXPECT_EQ(sigmas.size(), 12U);
  EXPECT_THAT(linesOf(m.modelled),
              Contains(HasSubstr("random for each sequence: sensors.0.mount.position.2 {uniform")));
  EXPECT_THAT(linesOf(m.modelled), Contains(HasSubstr("random for each frame: effects.0.range_noise.sigma_m")));
}

// The points of a drawn scan are those of a pipeline with the drawn values written into it: ranges on the floor follow
// from the height, errors from the standard deviation.
TEST_F(Drawn, ScansAreThoseOfTheDrawnValues) {
  const Manifest m = sound({kSeeds, kHeight, kNoise}, "drawn");
  const MembersByName drawn = members("drawn");
  for (const std::size_t i : {0U, 6U, 11U}) {
    std::vector<std::string> written{kSeeds, "effects=[range_noise: {sigma_m: 0}]"};
    for (const DrawnValue& draw : m.samples[i].draws) written.push_back(draw.key + "=" + draw.value);
    const std::string name = fmt::format("written{}", i);
    sound(written, name);
    const std::string member = m.samples[i].members.back();
    EXPECT_EQ(members(name).at(member), drawn.at(member));
  }
}

// A choice among effects: weather in some sequences, none in others; and all cases count for what is modelled.
TEST_F(Drawn, EffectsMayBeDrawn) {
  const Manifest m =
      sound({"scenes.0.seeds=[1, ..., 12]", "trajectories.0.frames=1",
             "effects=[intensity, {choice: [none, {dropout: {probability: 1}}, {dropout: {threshold: 1e-9}}]}]"});
  std::set<std::string> keys;
  for (const SampleRecord& sample : m.samples) {
    ASSERT_EQ(sample.draws.size(), 1U);
    const DrawnValue& draw = sample.draws[0];
    keys.insert(draw.key);
    EXPECT_EQ(draw.number, draw.value != "none") << draw.value;
    EXPECT_EQ(sample.scans[0].points == 0, draw.key == "effects.1.dropout.probability") << draw.key;
  }
  EXPECT_THAT(keys, ElementsAre("effects.1", "effects.1.dropout.probability", "effects.1.dropout.threshold"));
}

// Each split has rain and dry weather, however few sequences it has, and as many frames of a value as its share.
TEST_F(Drawn, SplitsShareStratifiedValuesEvenly) {
  const Manifest m =
      sound({"scenes.0.seeds=[1, ..., 16]", "splits={by: seed, train: 0.5, val: 0.25, test: 0.25}",
             "effects=[{choice: [none, {dropout: {probability: 0.1}}], stratify: split}, {range_noise: {sigma_m: "
             "{choice: [0.01, 0.02, 0.03, 0.04], per: frame, stratify: split}}}]"});
  std::map<std::pair<std::string, std::string>, int> counts;
  std::map<std::string, int> frames;
  for (const SampleRecord& sample : m.samples) {
    ++frames[sample.split];
    for (const DrawnValue& draw : sample.draws) ++counts[{sample.split, draw.value}];
  }
  EXPECT_EQ(frames.size(), 3U);
  EXPECT_EQ(counts.size(), 18U);
  for (const auto& [which, count] : counts) {
    const int of = which.second.starts_with("0.0") ? 4 : 2;
    EXPECT_EQ(count, frames[which.first] / of) << which.first << " " << which.second;
  }
  EXPECT_THAT(messageOf([&] {
                folder_.write("scenes/yard.yaml", yardScene() +
                                                      "  - {name: more, primitive: box, size: [1, 1, {uniform: "
                                                      "[1, 2], stratify: split}], class: car}\n");
                run({}, "refused");
              }),
              AllOf(HasSubstr("yard.yaml:"), HasSubstr("a scene does not know the splits")));
}

// Recorded hits are sensed as traced ones are, but for the rays that a recording does not hold.
TEST_F(Drawn, RecordedHitsHaveDrawnEffects) {
  const std::string lit = "effects=[intensity, {range_noise: {sigma_m: {uniform: [0.01, 0.2], per: frame}}}]";
  generate(planOf({kSeeds, lit}), {.folder = out("traced"), .keepHits = out("hits"), .quiet = true});
  const auto fromHits = [&](const std::vector<std::string>& overrides, const std::string& name) {
    generate(planOf(overrides, recordingIn(out("hits"))), {.folder = out(name), .quiet = true});
  };
  fromHits({kSeeds, lit}, "sensed");
  EXPECT_EQ(members("sensed"), members("traced"));
  fromHits({kSeeds, "effects=[intensity, light_paths, {range_noise: {sigma_m: {uniform: [0.01, 0.2]}}}]"}, "paths");
  fromHits({kSeeds, "effects=[intensity, {range_noise: {sigma_m: {uniform: [0.01, 0.2]}}}]"}, "none");
  std::map<std::string, std::uint64_t> points;
  for (const char* name : {"paths", "none"}) {
    for (const SampleRecord& sample : readManifest(out(name)).samples) points[name] += sample.scans[0].points;
  }
  EXPECT_EQ(points["paths"], points["none"]);
  EXPECT_THAT(messageOf([&] { fromHits({kSeeds, kHeight}, "moved"); }), HasSubstr("mount"));
}

// A sensor's own effects may be drawn, too.
TEST_F(Drawn, SensorsOwnEffectsMayBeDrawn) {
  const Manifest m = sound({"scenes.0.seeds=[1, ..., 8]", "trajectories.0.frames=1", "effects=sensor",
                            "sensors.0.effects=[{choice: [none, {dropout: {probability: 1}}]}]"});
  int empty = 0;
  for (const SampleRecord& sample : m.samples) {
    const bool lost = drawOf(sample, "sensors.0.effects.0") != "none";
    EXPECT_EQ(sample.scans[0].points == 0, lost);
    empty += lost ? 1 : 0;
  }
  EXPECT_GT(empty, 0);
  EXPECT_LT(empty, 8);
}

// Half of the sequences have the one sensor, as if there were no other, half of them the other.
TEST_F(Drawn, SensorsMayBeDrawn) {
  const std::string seeds = "scenes.0.seeds=[1, ..., 6]";
  const std::string flat =
      "{name: flat, columns: 90, rate_hz: 10, elevation_deg: [0, -10], range_m: [0.5, 100], mount: {position: [0, 0, "
      "{uniform: [1, 2]}]}}";
  const std::string either = "sensors=[{choice: [" + kTop + ", " + flat + "], stratify: split}]";
  const Manifest m = sound({seeds, either}, "either");
  sound({seeds}, "top");
  const MembersByName drawn = members("either");
  const MembersByName top = members("top");
  EXPECT_EQ(m.sensors.at(1).choice, "sensors.0");
  std::size_t tops = 0;
  for (const SampleRecord& sample : m.samples) {
    const bool isTop = drawOf(sample, "sensors.0") == "top";
    tops += isTop ? 1 : 0;
    ASSERT_EQ(sample.scans.size(), 1U);
    EXPECT_EQ(sample.scans[0].sensor, isTop ? "top" : "flat");
    EXPECT_EQ(drawOf(sample, "sensors.0.choice.1.mount.position.2").empty(), isTop);
    const std::string& points = sample.members.back();
    EXPECT_EQ(isTop, top.contains(points) && drawn.at(points) == top.at(points));
  }
  EXPECT_EQ(2 * tops, m.samples.size());
  const Plan plan = planOf({seeds, either});
  EXPECT_THAT(messageOf([&] { generate(plan, {.folder = out("kept"), .keepHits = out("hits"), .quiet = true}); }),
              HasSubstr("chosen at random"));
}

// What a scene's file draws is told, too; the scene is the one with the drawn values.
TEST_F(Drawn, ScenesMayDraw) {
  std::string scene = yardScene();
  scene.replace(scene.find("size: [4, 2, 1.5]"), 17, "size: [4, {uniform: [1.5, 3]}, 1.5]");
  folder_.write("scenes/yard.yaml", scene);
  const Manifest m = sound({kSeeds});
  std::set<std::string> widths;
  for (const SampleRecord& sample : m.samples) widths.insert(drawOf(sample, "objects.3.size.1"));
  EXPECT_EQ(widths.size(), 3U);
  scene.replace(scene.find("{uniform: [1.5, 3]}"), 19, "{uniform: [1.5, 3], per: frame}");
  folder_.write("scenes/yard.yaml", scene);
  EXPECT_THAT(messageOf([&] { run({kSeeds}, "other"); }), AllOf(HasSubstr("yard.yaml:"), HasSubstr("per: frame")));
}

// A sweep leaves what is drawn elsewhere as it was.
TEST_F(Drawn, ValuesDoNotDependOnOtherKeys) {
  const Manifest a = sound({kSeeds, kHeight}, "a");
  const Manifest b = sound({kSeeds, kHeight, kNoise, "trajectories.0.speed=10"}, "b");
  for (std::size_t i = 0; i < a.samples.size(); ++i) {
    EXPECT_EQ(drawOf(a.samples[i], "sensors.0.mount.position.2"), drawOf(b.samples[i], "sensors.0.mount.position.2"));
  }
  const Manifest other = sound({kSeeds, kHeight, "seed=4"}, "other");
  EXPECT_NE(drawOf(a.samples[0], "sensors.0.mount.position.2"), drawOf(other.samples[0], "sensors.0.mount.position.2"));
}

// The ends of what may be drawn are checked before the first ray, whether or not they will be met.
TEST_F(Drawn, RefusesWhatMightNotWork) {
  expectRefusals([&](const std::string& override) { return refusal({override}); },
                 {{"effects=[{range_noise: {sigma_m: {normal: [0.1, 0.03]}}}]", "sigma_m must be"},
                  {"effects=[{footprint: {rays: {choice: [7, 19]}}}, intensity]", "the number of rays per beam"},
                  {"effects=[{choice: [none, intensity]}]", "the existence or the unit of its intensity"},
                  {"effects=[{intensity: {output: {choice: [float, u8]}}}]", "the unit of its intensity"},
                  {"sensors.0.mount.position.2={uniform: [1, 2], per: frame}", "per: frame"},
                  {"sensors.0.columns={choice: [64, 128]}", "cannot be random"},
                  {"effects=[{choice: [{speckle: {looks: 2}}, none]}, {quantise: {step_m: 1}}]", "quantize"}});
  EXPECT_THAT(
      messageOf([&] { generate(planOf({kHeight}), {.folder = out("kept"), .keepHits = out("hits"), .quiet = true}); }),
      HasSubstr("give each `mount` fixed values"));
}

}  // namespace
}  // namespace scanmill
