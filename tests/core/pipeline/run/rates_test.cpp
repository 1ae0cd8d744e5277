// Sensors that turn at different rates.

#include <set>

#include "dataset/scan_store.h"
#include "pipeline/checks/warnings.h"
#include "pipeline/scenes/shot_source.h"
#include "sensors/trajectory.h"
#include "tests/core/pipeline/small_world.h"

namespace scanmill {
namespace {

using testing::SizeIs;

class Rates : public Yard {
 protected:
  static std::string sensor(const std::string& name, double rate) {
    return fmt::format(
        "{{name: {}, columns: 16, rate_hz: {}, elevation_deg: {{top: 5, bottom: -25, rings: 4}}, range_m: [0.5, 100]}}",
        name, rate);
  }
  static std::string sensors(const std::vector<double>& rates) {
    std::string list;
    for (std::size_t s = 0; s < rates.size(); ++s)
      list += (s > 0 ? ", " : "") + sensor(fmt::format("s{}", s), rates[s]);
    return "sensors=[" + list + "]";
  }
};

// The revolutions of each sensor follow one another without gap and overlap from the start of the drive, each in the
// frame in which it ends, and each from where the vehicle is when it begins.
TEST_F(Rates, EachSensorTurnsOnItsOwnClock) {
  struct Case {
    std::vector<double> rates;
    double interval;
  };
  for (const Case& c : {Case{{10, 20, 5}, 0.1}, Case{{10, 20, 5}, 0.2}, Case{{25, 10}, 0.1}, Case{{10, 30}, 0.04}}) {
    const Plan planned = planOf({sensors(c.rates), fmt::format("trajectories.0.every_s={}", c.interval),
                                 "trajectories.0.frames=9", "trajectories.0.speed=10"});
    ShotSource source(planned);
    std::vector<double> turns(c.rates.size());
    double all = 0;
    for (std::uint32_t frame = 0; frame < 9; ++frame) {
      std::vector<std::uint32_t> inFrame(c.rates.size());
      for (const Shot& shot : source.frame(0, frame, Revolutions::All).shots) {
        const double period = 1 / c.rates[shot.sensor];
        EXPECT_NEAR(shot.time, turns[shot.sensor]++ * period, 1e-9);
        EXPECT_GT(shot.time + period, frame * c.interval + 1e-9);
        EXPECT_LT(shot.time + period, (frame + 1) * c.interval + 1e-9);
        EXPECT_NEAR(shot.worldFromSensor.front().translation.x, -10 + 10 * shot.time, 1e-9);
        EXPECT_EQ(shot.revolution, inFrame[shot.sensor]++);
        EXPECT_NEAR(shot.untilNext, period, 1e-12);
        all += static_cast<double>(shot.beams->size());
      }
    }
    for (std::size_t s = 0; s < c.rates.size(); ++s)
      EXPECT_EQ(turns[s], std::floor(9 * c.interval * c.rates[s] + 1e-6));
    EXPECT_EQ(planned.pipeline.rays(), all);
  }
}

// Frames that are farther apart than the slowest sensor's revolution each begin one of each sensor.
TEST_F(Rates, DistantFramesBeginRevolutions) {
  const Plan planned = planOf({sensors({10, 20}), "trajectories.0.every_s=0.3"});
  std::vector<double> times;
  std::vector<double> next;
  for (const Shot& shot : ShotSource(planned).frame(0, 1, Revolutions::All).shots) {
    times.push_back(std::round(shot.time * 1e6) / 1e6);
    next.push_back(std::round(shot.untilNext * 1e6) / 1e6);
  }
  EXPECT_THAT(times, ElementsAre(0.3, 0.3, 0.35));
  EXPECT_THAT(next, ElementsAre(0.3, 0.05, 0.25));
  EXPECT_THAT(ShotSource(planned).frame(0, 1).shots, SizeIs(2)) << "studies take one of each sensor";
  const Plan alone = planOf({sensors({10, 30}), "trajectories=[{name: stands, poses: [{position: [0, 0, 1]}]}]"});
  for (const Shot& shot : ShotSource(alone).frame(0, 0, Revolutions::All).shots) {
    EXPECT_NEAR(shot.untilNext, shot.sensor == 0 ? 0.1 : 1.0 / 30, 1e-9);
  }
}

// Frames closer than the fastest sensor's revolution have one of each sensor, so that no sensor's time goes backwards.
TEST_F(Rates, CloseFramesHaveOneOfEach) {
  const Plan planned = planOf({sensors({10, 20}), "trajectories.0.every_s=0.04"});
  ShotSource source(planned);
  for (std::uint32_t frame = 0; frame < 4; ++frame) {
    const std::vector<Shot> shots = source.frame(0, frame, Revolutions::All).shots;
    ASSERT_THAT(shots, SizeIs(2));
    for (const Shot& shot : shots) EXPECT_NEAR(shot.time, 0.04 * frame, 1e-12);
  }
  EXPECT_TRUE(planned.pipeline.oneRevolution());
}

TEST_F(Rates, FramesFollowTheSlowestSensor) {
  EXPECT_NEAR(
      planOf({sensors({100, 10}), "trajectories.0.every_s=null"}).pipeline.sequences[0].trajectory->frameTime(1), 0.1,
      1e-12);
}

TEST_F(Rates, FramesCloserThanARevolutionAreToldWithBoth) {
  const auto warnings = [&](const std::vector<double>& rates, double interval) {
    return driveWarnings(planOf({sensors(rates), fmt::format("trajectories.0.every_s={}", interval)}).pipeline);
  };
  EXPECT_THAT(warnings({10}, 0.04),
              ElementsAre(HasSubstr("frames of 'drive' are 0.04 s apart, but a revolution of 's0' takes 0.1 s: its "
                                    "revolutions overlap")));
  EXPECT_THAT(warnings({10, 5}, 0.1), ElementsAre(HasSubstr("0.1 s apart, but a revolution of 's1' takes 0.2 s: some "
                                                            "samples have no scan of it")));
  EXPECT_THAT(warnings({10, 20}, 0.1), IsEmpty());
  EXPECT_THAT(warnings({10}, 0.5), IsEmpty());
  const std::string drive = "waypoints: [[-10, 0, 0], [10, 0, 0]], speed: 20, every_s: 0.04, frames: 4}";
  EXPECT_THAT(
      driveWarnings(planOf({"trajectories=[{name: a, " + drive + ", {name: b, " + drive + ", {name: c, " + drive + "]"})
                        .pipeline),
      ElementsAre(HasSubstr("frames of 'a' and 2 more drives are 0.04 s apart")));
}

// A drive that ends before a slow sensor has turned once has no scan of it.
TEST_F(Rates, SensorsWithoutAScanAreTold) {
  const GenerateSummary summary = run({sensors({10, 5}), "trajectories.0.every_s=0.1", "trajectories.0.frames=1"});
  EXPECT_THAT(summary.warnings, Contains(HasSubstr("the sensor 's1' has no scan in 1 frames")));
  EXPECT_THAT(summary.warnings, Not(Contains(HasSubstr("the sensor 's0' has no scan"))));
}

TEST_F(Rates, DatasetsHoldEveryRevolution) {
  const Manifest manifest =
      sound({sensors({10, 20, 5}), "effects=[range_noise: {sigma_m: 0.01}]", "output.objects=true"});
  const std::vector<std::size_t> scans{3, 4, 3, 4};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_THAT(manifest.samples[i].scans, SizeIs(scans[i]));
  const ScanStore store(out());
  const std::vector<StoredScan> fast = store.scans(1, "s1");
  ASSERT_THAT(fast, SizeIs(2));
  EXPECT_THAT(fast[0].members, ElementsAre("yard-s1-drive-000001.s1.ray_tracing.pcd"));
  EXPECT_THAT(fast[1].members, ElementsAre("yard-s1-drive-000001.s1.1.ray_tracing.pcd"));
  EXPECT_NEAR(fast[1].record->time, 0.15, 1e-12);
  EXPECT_EQ(fast[1].record->points, store.decode(1, fast[1]).size());
  const std::optional<SampleObjects> listed = store.objects(1);
  ASSERT_THAT(listed->objects, Not(IsEmpty()));
  for (const ObjectRecord& object : listed->objects) {
    std::set<std::string> sensors;
    for (const ObjectView& view : object.views) EXPECT_TRUE(sensors.insert(view.sensor).second);
  }
}

// If the first sensor is slow, its revolution began before its frame: samples and objects have the time of the frame.
TEST_F(Rates, SamplesHaveTheTimesOfTheirFrames) {
  const Manifest manifest = sound({sensors({5, 10}), "trajectories.0.every_s=0.1", "output.objects=true"});
  const ScanStore store(out());
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(store.objects(i)->time, 0.1 * static_cast<double>(i), 1e-12);
    const SampleRecord& sample = manifest.samples[i];
    EXPECT_NEAR(sample.time.value_or(sample.scans.front().time), 0.1 * static_cast<double>(i), 1e-12);
  }
  EXPECT_NEAR(manifest.samples[1].scans.front().time, 0, 1e-12);
}

// A second revolution has noise of its own, even of a sensor at rest.
TEST_F(Rates, RevolutionsHaveTheirOwnNoise) {
  sound({sensors({10, 20}), "effects=[range_noise: {sigma_m: 0.01}]",
         "trajectories=[{name: stands, poses: [{position: [0, 0, 1]}]}]"});
  const ScanStore store(out());
  const std::vector<StoredScan> fast = store.scans(0, "s1");
  const Scan first = store.decode(0, fast.at(0));
  const Scan second = store.decode(0, fast.at(1));
  ASSERT_EQ(first.size(), second.size());
  EXPECT_EQ(first[kRangeTrue], second[kRangeTrue]);
  std::size_t same = 0;
  for (std::size_t i = 0; i < first.size(); ++i) same += first.position[i] == second.position[i] ? 1 : 0;
  EXPECT_EQ(same, 0u);
}

TEST_F(Rates, RecordingsAndTooManyRevolutionsAreRefused) {
  EXPECT_THAT(messageOf<InputError>([&] {
                planOf({sensors({10, 20})}).requireOneRay();
              }),
              HasSubstr("these sensors turn at different rates"));
  EXPECT_NO_THROW(planOf({sensors({10, 10})}).requireOneRay());
  EXPECT_THAT(refusal({sensors({1000, 1}), "trajectories.0.every_s=1"}),
              HasSubstr("a sample would hold 1000 revolutions of the sensor 's0'"));
}

}  // namespace
}  // namespace scanmill
