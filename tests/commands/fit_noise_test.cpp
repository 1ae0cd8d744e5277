#include <fstream>

#include "base/file.h"
#include "config/value.h"
#include "formats/format.h"
#include "tests/commands/program.h"
#include "tests/support/noisy_walls.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// Scans of walls with a known noise, and the sensor that made them.
class FitNoiseCommand : public SmallWorld {
 protected:
  FitNoiseCommand() {
    folder_.write("wall.yaml", kWallSensor);
    const auto beams = wallBeams();
    Value none;
    Fields options(none, "format");
    const auto format = formatBySuffix("pcd")->make(options);
    const std::vector<Scan> scans =
        wallScans(beams, {11, 11.2, 16},
                  "[range_noise: {sigma_m: 0.012}, dropout: {probability: 0.02}, quantize: {step_m: 0.008}]");
    for (std::size_t i = 0; i < scans.size(); ++i) {
      files_.push_back(folder_.write("wall" + std::to_string(i) + ".pcd", format->encode(scans[i])).string());
    }
  }
  Outcome fit(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{"fit-noise"};
    arguments.insert(arguments.end(), files_.begin(), files_.end());
    arguments.insert(arguments.end(), more.begin(), more.end());
    return scanmill(arguments);
  }
  std::vector<std::string> files_;
};

TEST_F(FitNoiseCommand, WritesASensorThatPipelinesTake) {
  const Outcome fitted =
      scanmill({"fit-noise", files_[0], files_[1], "--sensor", at("wall.yaml"), "-o", at("fitted.yaml")});
  ASSERT_EQ(fitted.code, 0) << fitted.error;
  EXPECT_THAT(fitted.out, AllOf(HasSubstr("range step: 8 mm"), HasSubstr("10-12.5 m"), HasSubstr("range_noise"),
                                HasSubstr("wrote")));
  const std::string text = readFile(at("fitted.yaml"));
  EXPECT_THAT(text, testing::StartsWith(kWallSensor));
  EXPECT_THAT(text,
              AllOf(HasSubstr("# The stagger."), HasSubstr("wall0.pcd"), Not(HasSubstr(folder_.path().string()))));

  folder_.write("own.yaml",
                "scenes: [{scene: primitives}]\n"
                "trajectories: [{poses: [{position: [0, 0, 1.5]}]}]\n"
                "sensors: [{preset: fitted.yaml}]\n"
                "method: ray_tracing\n"
                "effects: sensor\n"
                "output: {formats: [pcd]}\n");
  const Outcome made = scanmill({"generate", at("own.yaml"), "-o", at("out")});
  EXPECT_EQ(made.code, 0) << made.error;
  EXPECT_THAT(scanmill({"plan", at("own.yaml")}).out, HasSubstr("effect range_noise of 'lidar0'"));
}

// A dash where nothing was measured, and words for what the columns are.
TEST_F(FitNoiseCommand, ItsTablesExplainThemselves) {
  const Outcome fitted = fit({"--sensor", at("wall.yaml"), "-o", at("a.yaml")});
  ASSERT_EQ(fitted.code, 0) << fitted.error;
  EXPECT_THAT(fitted.out,
              AllOf(HasSubstr("\nwith step: "), HasSubstr("\nabout planes: "), HasSubstr("left out: beyond 60 deg")));
  EXPECT_THAT(fitted.error, AllOf(HasSubstr("warning: Measured up to "), HasSubstr("to 120 m")));
  EXPECT_THAT(readFile(at("a.yaml")), HasSubstr("  # Measured up to "));
}

TEST_F(FitNoiseCommand, AFolderOfFramesStandsForThem) {
  ASSERT_EQ(fit({"--sensor", at("wall.yaml"), "-o", at("a.yaml")}).code, 0);
  const Outcome folder = scanmill({"fit-noise", at("."), "--sensor", at("wall.yaml"), "-o", at("b.yaml")});
  ASSERT_EQ(folder.code, 0) << folder.error;
  EXPECT_EQ(readFile(at("a.yaml")), readFile(at("b.yaml")));
  std::filesystem::create_directory(at("empty"));
  expectRefused(scanmill({"fit-noise", at("empty"), "--sensor", at("wall.yaml"), "-o", at("c.yaml")}),
                "is not a dataset");
}

TEST_F(FitNoiseCommand, NamesAnAbsentSensorOnce) {
  const Outcome refused = fit({"--sensor", "os1_12", "-o", at("a.yaml")});
  expectRefused(refused, "did you mean 'os1_128', which comes with the program?");
  EXPECT_EQ(refused.error.find("os1_12'"), refused.error.rfind("os1_12'"));
}

TEST_F(FitNoiseCommand, KeepsWhatIsThere) {
  folder_.write("there.yaml", "mine");
  expectRefused(fit({"--sensor", at("wall.yaml"), "-o", at("there.yaml")}), "--overwrite");
  EXPECT_EQ(readFile(at("there.yaml")), "mine");
  EXPECT_EQ(fit({"--sensor", at("wall.yaml"), "-o", at("there.yaml"), "--overwrite"}).code, 0);
  EXPECT_THAT(readFile(at("there.yaml")), HasSubstr("effects:"));
}

// The response is found beside the noise, and alone where the scans are not on the sensor's beams.
TEST_F(FitNoiseCommand, FindsTheResponseByTowns) {
  const auto make = [&](const std::string& seeds, const std::string& out) {
    const std::string place =
        std::string("{scene: ") + SCANMILL_SOURCE_DIR + "/scenes/street.yaml, seeds: [" + seeds + "]}";
    folder_.write(out + ".yaml", "scenes: [" + place +
                                     "]\n"
                                     "trajectories: [{poses: [{position: [-30, -1.75, 2]}, {position: [0, -1.75, 2]},"
                                     " {position: [30, -1.75, 2]}]}]\n"
                                     "sensors: [{preset: wall.yaml}]\n"
                                     "method: ray_tracing\n"
                                     "effects: [intensity: {model: reflectivity, output: u8, floor: 0.01,"
                                     " table: [[0.01, 40], [1, 140], [300, 255]]}, range_noise: {sigma_m: 0.01}]\n"
                                     "output: {formats: [pcd], columns: [intensity, power, ring, column]}\n");
    ASSERT_EQ(scanmill({"generate", at(out + ".yaml"), "-q", "-o", at(out)}).code, 0);
  };
  make("1, 2", "recorded");
  make("3, 4, 5, 6", "towns");
  const Outcome fitted = scanmill(
      {"fit-noise", at("recorded"), "--sensor", at("wall.yaml"), "--simulated", at("towns"), "-o", at("fitted.yaml")});
  ASSERT_EQ(fitted.code, 0) << fitted.error;
  EXPECT_THAT(fitted.out, AllOf(HasSubstr("response: "), HasSubstr("model: reflectivity"), HasSubstr("range_noise")));
  EXPECT_THAT(readFile(at("fitted.yaml")),
              AllOf(HasSubstr("output: u8"), HasSubstr("table: [["), HasSubstr("floor: 0.0")));

  const Outcome sensor = scanmill({"fit-sensor", at("recorded"), "--simulated", at("towns"), "-o", at("sensor.yaml")});
  ASSERT_EQ(sensor.code, 0) << sensor.error;
  EXPECT_THAT(readFile(at("sensor.yaml")), AllOf(HasSubstr("effects:\n"), HasSubstr("model: reflectivity")));

  const Outcome alone = scanmill(
      {"fit-noise", at("recorded"), "--sensor", "os1_128", "--simulated", at("towns"), "-o", at("alone.yaml")});
  ASSERT_EQ(alone.code, 0) << alone.error;
  EXPECT_THAT(alone.error, HasSubstr("only the response was found, not the noise"));
  EXPECT_THAT(readFile(at("alone.yaml")), AllOf(HasSubstr("output: u8"), HasSubstr("range_noise: {table")));
  expectRefused(fit({"--sensor", at("wall.yaml"), "-o", at("c.yaml"), "--simulated", files_[0]}), "has no manifest");
}

TEST_F(FitNoiseCommand, RefusesWhatItCannotUse) {
  expectRefused(scanmill({"fit-noise", "--sensor", "os1_128", "-o", at("a.yaml")}), "SCAN is missing");
  expectRefused(fit({"-o", at("a.yaml")}), "--sensor is missing");
  expectRefused(fit({"--sensor", at("wall.yaml")}), "--out is missing");
  expectRefused(fit({"--sensor", at("wall.yaml"), "-o", at("a.yaml"), "--max-incidence", "95"}), "--max-incidence");
  expectRefused(fit({"--sensor", "os1_129", "-o", at("a.yaml")}), "os1_128");
  const Outcome wrong = fit({"--sensor", "os1_128", "-o", at("a.yaml")});
  expectRefused(wrong, "128 rings x 1024 columns");
  EXPECT_THAT(wrong.error, HasSubstr("wall0.pcd"));
  expectRefused(scanmill({"fit-noise", at("absent.pcd"), "--sensor", at("wall.yaml"), "-o", at("a.yaml")}),
                "absent.pcd");
  expectRefused(scanmill({"fit-noise", at("wall.yaml"), "--sensor", at("wall.yaml"), "-o", at("a.yaml")}), "wall.yaml");
  expectRefused(scanmill({"fit-noise", files_[0], "--sensor", pipeline_, "-o", at("a.yaml")}), "pipeline");
  EXPECT_FALSE(std::filesystem::exists(at("a.yaml")));
}

}  // namespace
}  // namespace scanmill
