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

TEST_F(FitNoiseCommand, AFolderOfFramesStandsForThem) {
  ASSERT_EQ(fit({"--sensor", at("wall.yaml"), "-o", at("a.yaml")}).code, 0);
  const Outcome folder = scanmill({"fit-noise", at("."), "--sensor", at("wall.yaml"), "-o", at("b.yaml")});
  ASSERT_EQ(folder.code, 0) << folder.error;
  EXPECT_EQ(readFile(at("a.yaml")), readFile(at("b.yaml")));
}

}  // namespace
}  // namespace scanmill
