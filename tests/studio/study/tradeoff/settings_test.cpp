#include <set>

#include "config/value.h"
#include "study/tradeoff/study.h"
#include "tests/core/pipeline/small_world.h"

namespace scanmill {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

class TradeoffKey : public Yard {
 protected:
  StudyChoice choice(const std::string& tradeoff) const {
    return readStudyChoice(readPipeline(pipeline_, {"tradeoff=" + tradeoff}));
  }

  // The key in a block of its own from line 2 on.
  void expectRefusedKey(const std::string& block, const std::vector<std::string>& words) const {
    SCOPED_TRACE(block);
    const auto file = folder_.write("study.yaml", "tradeoff:\n" + block + "\n" + kYardPipeline);
    std::vector<std::string> all = words;
    all.emplace_back("study.yaml:");
    expectInputError([&] { readStudyChoice(readPipeline(file, {})); }, all);
  }
};

TEST_F(TradeoffKey, AllOfItMayBeLeftOut) {
  const StudyChoice c = readStudyChoice(readPipeline(pipeline_, {}));
  EXPECT_EQ(c.settings.size(), defaultSettings().size());
  EXPECT_GT(c.settings.size(), 20u);
  EXPECT_EQ(c.settings.front().setting.name, "ray_tracing");
  std::set<std::string> methodNames;
  for (const MethodSetting& s : c.settings) methodNames.insert(s.setting.method);
  EXPECT_THAT(methodNames, SizeIs(methods().size())) << "every method is compared";
  std::set<std::string> names;
  for (const MethodSetting& s : c.settings) names.insert(s.setting.name);
  EXPECT_TRUE(names.contains("particle refine=none levels=3"));
  EXPECT_FALSE(c.encodings.empty());
  EXPECT_EQ(c.shots, 8u);
  EXPECT_EQ(c.repeats, 3);
  EXPECT_EQ(c.sequence, 0u);
}

TEST_F(TradeoffKey, SaysWhatIsCompared) {
  const StudyChoice c = choice(
      "{settings: [{ray_tracing: {instancing: [never, always]}}, particle], encodings: [csv, {draco: {max_error_mm: "
      "[1, 2.5]}}], "
      "sequence: yard-s1-drive, shots: 2, repeats: 1}");
  ASSERT_THAT(c.settings, SizeIs(3));
  EXPECT_EQ(c.settings[1].setting.name, "ray_tracing instancing=always");
  ASSERT_THAT(c.encodings, SizeIs(3));
  EXPECT_EQ(c.encodings[0].name, "csv");
  EXPECT_EQ(c.encodings[0].options, "{}");
  EXPECT_EQ(c.encodings[2].name, "draco max_error_mm=2.5");
  EXPECT_EQ(c.encodings[2].options, "{max_error_mm: 2.5}");
  EXPECT_EQ(c.encodings[2].choice.entry->name, "draco");
  EXPECT_LE(c.encodings[2].choice.format->maxError(), 0.0025 * (1 + 1e-9));
  EXPECT_EQ(c.shots, 2u);
  EXPECT_EQ(c.repeats, 1);
}

TEST_F(TradeoffKey, OneOfSeveralSequencesIsNamed) {
  const Pipeline pipeline = readPipeline(
      pipeline_, {"trajectories=[{name: a, poses: [{position: [0, 0, 0]}]}, {name: b, poses: [{position: [1, 0, 0]}]}]",
                  "tradeoff={sequence: yard-s1-b}"});
  EXPECT_EQ(readStudyChoice(pipeline).sequence, 1u);
}

// What --set makes of a default setting is that setting.
TEST_F(TradeoffKey, AssignmentsOfTheDefaultsReadBack) {
  for (const MethodSetting& s : defaultSettings()) {
    SCOPED_TRACE(s.setting.assignment());
    const Pipeline pipeline = readPipeline(pipeline_, {s.setting.assignment()});
    EXPECT_EQ(pipeline.method.entry, s.choice.entry);
    EXPECT_EQ(flowText(pipeline.method.options), s.setting.options);
    EXPECT_EQ(settingName(pipeline.methodName(), pipeline.method.options), s.setting.name);
  }
}

TEST_F(TradeoffKey, EveryWrongTextHasItsPlaceAndAWayOut) {
  expectRefusedKey("  setting: [ray_tracing]", {"study.yaml:2:3", "unknown key 'setting'", "did you mean 'settings'"});
  expectRefusedKey("  - settings", {"study.yaml:2", "tradeoff must be a map"});
  expectRefusedKey("  settings:\n    - rays", {"study.yaml:3:7", "unknown method 'rays'"});
  expectRefusedKey("  encodings: []", {"study.yaml:2:14", "tradeoff.encodings", "at least one item"});
  expectRefusedKey("  encodings: [laz]", {"study.yaml:2:15", "'laz'"});
  expectRefusedKey("  encodings: [{draco: {max_error_mm: [1, no]}}]", {"study.yaml:2:", "max_error_mm", "'no'"});
  expectRefusedKey("  encodings: [pcd, pcd]", {"study.yaml:2:20", "'pcd' is listed twice"});
  expectRefusedKey("  sequence: yard-s1-drivel", {"study.yaml:2:13", "no sequence", "did you mean 'yard-s1-drive'"});
  expectRefusedKey("  shots: 0", {"study.yaml:2:10", "shots"});
  expectRefusedKey("  repeats: many", {"study.yaml:2:12", "repeats", "'many'"});
}

}  // namespace
}  // namespace scanmill
