#include "study/tradeoff/study.h"
#include "tests/core/pipeline/small_world.h"
#include "tests/support/blender.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

constexpr const char* kCoarse = "{particle: {refine: none, voxel_m: 0.5}}";
constexpr const char* kNoRenderer = "{depth_camera: {renderer: blender}}";

class RunStudy : public Yard {
 protected:
  const ScopedVariable blender_{"SCANMILL_BLENDER", "/no/such/blender"};

  // The pipeline with such a key of its own, as a file.
  std::filesystem::path withKey(const std::string& tradeoff, const std::string& name = "study.yaml") const {
    return folder_.write(name, std::string(kYardPipeline) + "effects: [intensity]\ntradeoff: " + tradeoff + "\n");
  }

  // Drawing belongs to the report: here a picture is a text that counts what differs.
  static std::string countErrors(const TrueShot& truth, const Hits& tested) {
    std::size_t differing = 0;
    for (std::size_t i = 0; i < tested.size(); ++i) {
      differing += std::abs(double{tested.range[i]} - truth.truth.range[i]) > 1e-3 ? 1 : 0;
    }
    return fmt::format("{} of {}", differing, tested.size());
  }

  static Study studied(const std::filesystem::path& file, StudyOptions options = {}) {
    options.quiet = true;
    options.drawErrors = countErrors;
    return runStudy(makePlan(readPipeline(file, {})), options);
  }

  static std::string three() {
    return fmt::format(
        "{{settings: [ray_tracing, {}, {}], encodings: [pcd, {{draco: {{max_error_mm: [1, 20]}}}}], "
        "shots: 3, repeats: 1}}",
        kCoarse, kNoRenderer);
  }

  // What two runs of a study must agree on: all but times, of processors and of the study.
  static std::string errorsOf(Study study) {
    study.seconds = 0;
    study.date.clear();
    for (auto& [stage, seconds] : study.commonStages) seconds = 0;
    for (SettingResult& s : study.settings) {
      const std::uint64_t memory = s.measured.cost.memoryBytes;
      s.measured.cost = {};
      s.measured.cost.memoryBytes = memory;
    }
    for (EncodingResult& e : study.encodings) e.encodePointsPerSecond = e.decodePointsPerSecond = 0;
    return toJson(study);
  }
};

TEST_F(RunStudy, MeasuresEverySettingAgainstTheTruth) {
  const Study study = studied(withKey(three()));
  EXPECT_EQ(study.pipelineName, "yard");
  EXPECT_EQ(study.shots, 3u);
  EXPECT_EQ(study.beamsPerShot, 512u);
  EXPECT_EQ(study.scene.key, "yard-s1-drive");
  EXPECT_THAT(study.scene.frames, ElementsAre(0, 2, 3)) << "spread over the four";
  EXPECT_GT(study.scene.triangles, 60u);
  EXPECT_THAT(study.sensors, ElementsAre(AllOf(HasSubstr("top: "), HasSubstr("8 x 64 beams"))));
  EXPECT_EQ(study.repeats, 1);
  EXPECT_EQ(study.budgetSeconds, 300u);
  EXPECT_GT(study.seconds, 0);
  EXPECT_THAT(study.date, testing::MatchesRegex("[0-9]{4}-[0-9]{2}-[0-9]{2}"));
  EXPECT_THAT(study.machine.processor, Not(IsEmpty()));
  EXPECT_THAT(study.leftOut, IsEmpty());
  EXPECT_THAT(study.ontology.classes, Not(IsEmpty()));

  ASSERT_THAT(study.settings, SizeIs(3));
  const Measurement& rays = study.settings[0].measured;
  EXPECT_THAT(study.settings[0].failure, IsEmpty());
  EXPECT_EQ(rays.errors.all.beams, 3u * 512);
  EXPECT_LT(rays.errors.all.range.max, 1e-5);
  EXPECT_LT(rays.errors.all.range.mean, 1e-6);
  EXPECT_EQ(rays.errors.all.missRate(), 0);
  EXPECT_EQ(rays.errors.all.labels(), 1);
  EXPECT_LT(rays.errors.all.intensity.max, 1e-5);
  EXPECT_EQ(rays.errors.all.intensity.count, rays.errors.all.bothHit);
  EXPECT_LT(rays.errors.all.hausdorff(), 1e-4);
  EXPECT_GT(rays.cost.scanSeconds, 0);

  const Measurement& coarse = study.settings[1].measured;
  EXPECT_THAT(study.settings[1].failure, IsEmpty());
  EXPECT_GT(coarse.errors.all.range.p99, 0.01);
  EXPECT_GT(coarse.errors.all.hausdorff(), 0.01);
  EXPECT_GT(coarse.cost.setupSeconds, 0);

  // One that cannot run ends nothing.
  EXPECT_THAT(study.settings[2].failure, HasSubstr("/no/such/blender"));
  EXPECT_EQ(study.settings[2].measured.errors.all.beams, 0u);
}

TEST_F(RunStudy, EncodesWhatThePipelineWouldWrite) {
  const Study study = studied(withKey(three()));
  EXPECT_THAT(study.commonStages, testing::UnorderedElementsAre(testing::Pair("effects", testing::Gt(0)),
                                                                testing::Pair("encode pcd", testing::Gt(0))));
  ASSERT_THAT(study.encodings, SizeIs(3));
  for (const EncodingResult& e : study.encodings) {
    EXPECT_THAT(e.failure, IsEmpty()) << e.name;
    EXPECT_LE(e.largestError, e.statedError) << e.name;
  }
  EXPECT_EQ(study.encodings[0].largestError, 0);
  EXPECT_GT(study.encodings[1].bytesPerPoint, study.encodings[2].bytesPerPoint);
}

TEST_F(RunStudy, ABlindSensorIsRefused) {
  const Plan plan =
      makePlan(readPipeline(withKey(three()), {"trajectories=[{name: sky, poses: [{position: [0, 0, 5000]}]}]"}));
  expectInputError([&] { runStudy(plan, {.quiet = true}); }, {"study.yaml", "hits anything", "trajectory"});
}

TEST_F(RunStudy, PicturesShowOnlyWhatErrs) {
  const Study study = studied(withKey(three()));
  ASSERT_THAT(study.pictures, SizeIs(1));
  EXPECT_EQ(study.pictures[0].setting, study.settings[1].setting.name);
  EXPECT_THAT(study.pictures[0].png, AllOf(HasSubstr(" of 512"), Not(testing::StartsWith("0 of"))));
  EXPECT_THAT(studied(withKey("{settings: [ray_tracing], shots: 1, repeats: 1}")).pictures, IsEmpty());
}

// The figures of a report can be measured again from what the report holds.
TEST_F(RunStudy, ThePipelineThatItHoldsGivesTheSameStudy) {
  const Study first = studied(withKey(three()));
  Study again = studied(folder_.write("study.yaml", first.pipelineText));
  EXPECT_EQ(errorsOf(again), errorsOf(first));
}

TEST_F(RunStudy, AStopEndsItWithoutAStudy) {
  const std::atomic<bool> stop = true;
  const StudyOptions options{.stop = &stop};
  const auto file = withKey(three());
  EXPECT_THAT(messageOf<Error>([&] { studied(file, options); }), HasSubstr("stopped"));
}

TEST_F(RunStudy, WhatTheBudgetDoesNotHoldIsLeftOutAndSaid) {
  const StudyOptions options{.budgetSeconds = 1e-6};
  const Study study =
      studied(withKey(fmt::format("{{settings: [ray_tracing, {}, {{ray_tracing: {{instancing: always}}}}], shots: 4, "
                                  "repeats: 1}}",
                                  kCoarse)),
              options);
  ASSERT_THAT(study.settings, SizeIs(1)) << "something to report";
  EXPECT_EQ(study.settings[0].setting.name, "ray_tracing");
  EXPECT_EQ(study.shots, 1u) << "one frame is the least";
  EXPECT_THAT(study.leftOut, SizeIs(2));
  EXPECT_THAT(study.leftOut, Each(HasSubstr("the budget of ")));
  EXPECT_THAT(study.leftOut[0], testing::StartsWith("particle refine=none"));
}

TEST_F(RunStudy, SensorsMayHaveEffectsOfTheirOwn) {
  std::string text = kYardPipeline;
  text.insert(text.find("    mount:"), "    effects: [intensity, {range_noise: {sigma_m: 0.02}}]\n");
  const auto file = folder_.write("own.yaml", text +
                                                  "effects: sensor\ntradeoff: {settings: [ray_tracing], encodings: "
                                                  "[pcd], shots: 1, repeats: 1}\n");
  const Study study = studied(file);
  EXPECT_GT(study.settings[0].measured.errors.all.intensity.count, 0u) << "its own intensities are compared";
  EXPECT_LT(study.settings[0].measured.errors.all.range.max, 1e-5) << "methods are compared without noise";
  EXPECT_EQ(study.encodings[0].failure, "");
}

TEST_F(RunStudy, RecordingsAreRefused) {
  generate(makePlan(readPipeline(pipeline_, {}), Channels::all()),
           {.folder = out("kept"), .keepHits = out("hits"), .quiet = true});
  const Plan plan = makePlan(readPipeline(pipeline_, {}, recordingIn(out("hits"))));
  expectInputError([&] { runStudy(plan, {.quiet = true}); }, {"yard.yaml", "cannot use a recording"});
}

}  // namespace
}  // namespace scanmill
