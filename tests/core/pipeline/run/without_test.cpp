// The same scans with and without a thing.

#include "tests/core/pipeline/small_world.h"

namespace scanmill {
namespace {

class WithoutRun : public Yard {
 protected:
  static std::vector<std::string> options(const std::string& without) {
    return {"effects=[intensity, speckle: {looks: 5}, range_noise: {sigma_m: 0.02}, dropout: {probability: 0.1}]",
            "motion=per_column", "scenes.0.without=" + without};
  }
};

// What a beam met that is taken out stands farther away; all other beams are the same in every column, noise included.
TEST_F(WithoutRun, OtherBeamsStayAsTheyAre) {
  sound(options("[]"), "with");
  sound(options("[1]"), "without");
  const std::vector<Scan> with = scans(".pcd", "with"), without = scans(".pcd", "without");
  ASSERT_EQ(with.size(), without.size());
  std::size_t gone = 0, same = 0, second = 0;
  for (std::size_t s = 0; s < with.size(); ++s) {
    const auto rows = rowsByBeam(without[s]);
    for (std::size_t i = 0; i < with[s].size(); ++i) {
      const auto row = rows.find({with[s][kRing][i], with[s][kColumn][i]});
      if (with[s][kInstance][i] == 1) {
        ++gone;
        if (row == rows.end()) continue;
        EXPECT_NE(without[s][kInstance][row->second], 1u);
        EXPECT_GT(without[s][kRangeTrue][row->second], with[s][kRangeTrue][i]);
        continue;
      }
      ASSERT_NE(row, rows.end());
      ++same;
      second += with[s][kInstance][i] == 2 ? 1 : 0;
      const std::size_t other = row->second;
      ASSERT_EQ(with[s].position[i], without[s].position[other]);
      ASSERT_EQ(with[s][kIntensity][i], without[s][kIntensity][other]);
      ASSERT_EQ(with[s][kLabel][i], without[s][kLabel][other]);
      ASSERT_EQ(with[s][kInstance][i], without[s][kInstance][other]);
    }
  }
  EXPECT_GE(gone, 10u);
  EXPECT_GE(second, 10u);
  EXPECT_GT(same, 1000u);
}

TEST_F(WithoutRun, AClassANameAndTheIdsAreTheSame) {
  sound(options("[car]"), "class");
  sound(options("[1, 2]"), "ids");
  EXPECT_EQ(members("class"), members("ids"));
  sound(options("[across]"), "name");
  EXPECT_LT(scans(".pcd", "name")[0].size(), scans(".pcd", "class")[0].size());
  sound(options("['car#1']"), "copy");
  sound(options("[1]"), "first");
  EXPECT_EQ(members("copy"), members("first"));
  // As if the file had no such object.
  std::string scene = yardScene();
  scene.resize(scene.find("  - name: car"));
  folder_.write("scenes/yard.yaml", scene);
  sound(options("[]"), "never");
  EXPECT_EQ(members("class"), members("never"));
}

TEST_F(WithoutRun, KeptHitsAreOfWhatTheSceneWas) {
  const auto kept = [&](const std::string& without, const std::string& hits) {
    generate(planOf({"scenes.0.without=" + without}),
             {.folder = out("of" + hits), .keepHits = out(hits), .quiet = true});
    return recordingIn(out(hits));
  };
  const auto all = kept("[]", "all"), rest = kept("[car]", "rest");
  EXPECT_EQ(rest->sequences[0].without, (std::vector<std::string>{"car"}));
  EXPECT_THAT(messageOf([&] { readPipeline(pipeline_, {"scenes.0.without=[car]"}, all); }),
              HasSubstr("was recorded with all objects"));
  EXPECT_THAT(messageOf([&] { readPipeline(pipeline_, {"scenes.0.without=[1]"}, rest); }),
              HasSubstr("with other objects removed"));
  EXPECT_EQ(readPipeline(pipeline_, {}, rest).sequences[0].without.size(), 1u);
  EXPECT_EQ(readPipeline(pipeline_, {"scenes.0.without=[car]"}, rest).sequences[0].without[0].text, "car");
}

TEST_F(WithoutRun, IsSweptIntoSetsThatDifferInNothingElse) {
  const auto sequences = [&](const std::string& without) {
    return readPipeline(pipeline_, {"scenes.0.without=" + without}).sequences;
  };
  EXPECT_FALSE(sequences("[car]")[0].sameScene(sequences("[]")[0]));
  EXPECT_FALSE(sequences("[1]")[0].sameScene(sequences("[2]")[0]));
  EXPECT_TRUE(sequences("[car]")[0].sameScene(sequences("[car]")[0]));
  EXPECT_EQ(sequences("[car]")[0].key(), sequences("null")[0].key());
}

}  // namespace
}  // namespace scanmill
