#include "pipeline/plan/plan.h"

#include "base/memory.h"
#include "pipeline/scenes/shot_source.h"
#include "tests/core/pipeline/small_world.h"
#include "tests/support/lines_of.h"

namespace scanmill {
namespace {

using PlanTest = Yard;

TEST_F(PlanTest, OnlyChannelsThatSomebodyReads) {
  EXPECT_EQ(planOf({"output.columns=[ring]"}).channels, Channels(Channel::Range));
  EXPECT_EQ(planOf({"output.columns=[label, instance]"}).channels,
            Channel::Range | Channel::Semantic | Channel::Instance);
  EXPECT_EQ(planOf({"output.columns=[incidence]"}).channels, Channel::Range | Channel::Incidence);
  EXPECT_FALSE(planOf({}).channels.has(Channel::Incidence));
  const Channels lit = planOf({"output.columns=[intensity]", "effects=[intensity]"}).channels;
  EXPECT_TRUE(lit.has(Channel::Reflectance) && lit.has(Channel::Incidence));
  EXPECT_FALSE(lit.has(Channel::Semantic) || lit.has(Channel::Primitive));
}

TEST_F(PlanTest, TellsWhatIsLeftOutAndWhy) {
  EXPECT_THAT(linesOf(modelled(planOf({}), {})),
              AllOf(Contains(HasSubstr("channels: range, instance, semantic")),
                    Contains(HasSubstr("properties of hits that nothing reads: left out, normal")),
                    Contains(HasSubstr("intensity: left out, no effect sets it")), Contains(HasSubstr("effects: none")),
                    Contains(HasSubstr("one pose"))));
  EXPECT_THAT(linesOf(modelled(
                  planOf({"motion={steps: 9}", "output.layout=organised", "effects=[quantize: {step_m: 1}]"}), {})),
              AllOf(Contains(HasSubstr("9 poses per revolution")), Contains(HasSubstr("misses: written")),
                    Contains(HasSubstr("effect quantize {step_m: 1}: "))));
}

TEST_F(PlanTest, ShotsHaveTheirPosesAndAddresses) {
  const Plan p = planOf({"scenes.0.seeds=[1, 2]", "seed=77",
                         "sensors=[" + kTop +
                             ", {name: rear, columns: 4, rate_hz: 10, elevation_deg: [0], range_m: [1, 9], "
                             "mount: {position: [-1, 0, 1], yaw_deg: 180}}]"});
  const std::vector<Shot> shots = ShotSource(p).frame(1, 3).shots;
  ASSERT_EQ(shots.size(), 2u);
  EXPECT_EQ(shots[1].seed, 77u);
  EXPECT_EQ(shots[1].scene, 1u);
  EXPECT_EQ(shots[1].frame, 3u);
  EXPECT_EQ(shots[1].sensor, 1u);
  EXPECT_EQ(shots[1].sensorName, "rear");
  EXPECT_NEAR(shots[1].time, 0.3, 1e-12);
  // Driven along x from -10 at 20 m/s.
  EXPECT_NEAR(shots[0].worldFromSensor.at(0).translation.x, -4, 1e-9);
  EXPECT_NEAR(shots[1].worldFromSensor.at(0).translation.x, -5, 1e-9);
  EXPECT_NEAR((shots[1].worldFromSensor.at(0) * Vec3d{1, 0, 0}).x, -6, 1e-9);
}

TEST_F(PlanTest, MoreStepsThanColumnsAreRefused) {
  EXPECT_THAT(refusal({"motion={steps: 65}"}),
              AllOf(HasSubstr("--set motion"), HasSubstr("65 steps"), HasSubstr("64 columns"), HasSubstr("'top'")));
  const Plan steps = planOf({"motion={steps: 64}"});
  EXPECT_EQ(ShotSource(steps).frame(0, 0).shots.at(0).worldFromSensor.size(), 64u);
}

TEST_F(PlanTest, WhatTheMethodCannotDoIsRefused) {
  EXPECT_NO_THROW(planOf({"method=depth_camera"}).requirePasses());
  EXPECT_THAT(
      messageOf<InputError>([&] { planOf({}).requirePasses(); }),
      AllOf(HasSubstr("yard.yaml: the method ray_tracing draws no passes"), HasSubstr("take `method: depth_camera`")));
}

// 4096 x 65536 beams are within a sensor's limits, hundreds of such sensors are not within a machine's memory.
TEST_F(PlanTest, FramesThatNoMemoryHoldsAreRefusedWithTheArithmetic) {
  std::string sensors = "sensors=[";
  for (int i = 0; i < 300; ++i) {
    sensors += fmt::format(
        "{{name: s{}, columns: 65536, rate_hz: 10, elevation_deg: {{top: 9, bottom: -9, rings: 4096}}"
        ", range_m: [1, 9]}}, ",
        i);
  }
  EXPECT_THAT(refusal({sensors + "]", "trajectories.0.frames=1"}),
              AllOf(HasSubstr("yard.yaml: 80530636800 beams per frame x "), HasSubstr("GiB of memory")));
}

TEST_F(PlanTest, FramesInFlightFitTheThreadsAndTheMemory) {
  const ThreadLimit limit(2);
  EXPECT_EQ(planOf({}).framesInFlight(), 2u);
  const Plan wide = planOf({"sensors.0.columns=65536"});
  EXPECT_EQ(wide.bytesPerFrameInMemory(), 1024 * planOf({}).bytesPerFrameInMemory());
  EXPECT_GE(wide.framesInFlight(), 1u);
  // Half of what the program itself leaves.
  const std::uint64_t own = std::uint64_t{72} << 20;
  const std::uint64_t frame = wide.bytesPerFrameInMemory();
  for (const auto& [frames, expected] : {std::pair{5, 2u}, {4, 2u}, {3, 1u}, {1, 1u}}) {
    const MemoryLimit allowed(own + static_cast<std::uint64_t>(frames) * frame);
    EXPECT_EQ(wide.framesInFlight(), expected) << frames;
  }
}

TEST_F(PlanTest, ScenesAndFramesThatDoNotFitAreRefused) {
  const Plan fits = planOf({});
  ShotSource source(fits);
  const Scene scene = source.load(0);
  const std::unique_ptr<Method> method = source.method(scene);
  EXPECT_NO_THROW(fits.checkMemory(method->memoryBytes(), "the yard"));
  const MemoryLimit allowed((std::uint64_t{72} << 20) + method->memoryBytes());
  EXPECT_THAT(messageOf<InputError>([&] { fits.checkMemory(method->memoryBytes(), "the yard"); }),
              AllOf(HasSubstr("yard.yaml: the yard takes about "), HasSubstr("allow more, or take a smaller scene")));
}

TEST_F(PlanTest, ScenesMustShareTheirClassesBeforeAnythingIsTraced) {
  std::string other = yardScene();
  const std::string labels = "labels/scanmill.yaml";
  other.replace(other.find(labels), labels.size(), "labels/semantic_kitti.yaml");
  folder_.write("scenes/other.yaml", other);
  const std::vector<std::string> two{fmt::format("scenes=[{{scene: {0}/yard.yaml}}, {{scene: {0}/other.yaml}}]",
                                                 (folder_.path() / "scenes").string())};
  EXPECT_THAT(refusal(two), AllOf(HasSubstr("yard.yaml: the scenes"), HasSubstr("other.yaml"),
                                  HasSubstr("different classes"), HasSubstr("`labels`")));
  std::vector<std::string> agreed = two;
  agreed.push_back(fmt::format("labels={}/labels/scanmill.yaml", SCANMILL_SOURCE_DIR));
  EXPECT_NO_THROW(planOf(agreed));
}

TEST_F(PlanTest, AnAbsentSceneIsFoundAtOnce) {
  EXPECT_THAT(refusal({"scenes.0.scene=nowhere.yaml"}), HasSubstr("nowhere.yaml"));
}

TEST_F(PlanTest, MethodsThatStopObjectsRefuseScenesInWhichTheyMove) {
  std::string yard = yardScene();
  yard += "  - {primitive: box, size: [1, 1, 1], class: car, material: car_paint, moving: {velocity: [1, 0, 0]}}\n";
  folder_.write("scenes/yard.yaml", yard);
  const auto methodOf = [&](const std::string& name) {
    const Plan p = planOf({"method=" + name});
    ShotSource source(p);
    const Scene scene = source.load(0);
    source.method(scene);
  };
  EXPECT_NO_THROW(methodOf("ray_tracing"));
  for (const char* name : {"depth_camera", "particle"}) {
    EXPECT_THAT(messageOf<InputError>([&] { methodOf(name); }),
                AllOf(HasSubstr("yard.yaml"), HasSubstr("objects of this scene move"), HasSubstr("ray_tracing")));
  }
}

}  // namespace
}  // namespace scanmill
