#include "tests/commands/program.h"
#include "tests/support/shared_data.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

using FitSensorCommand = SmallWorld;

TEST_F(FitSensorCommand, WritesAFileThatIsASensor) {
  SKIP_WITHOUT_SHARED_DATA("lidar/ouster_os1_128");
  const std::string frame = (sharedData() / "lidar/ouster_os1_128/frame_1795.pcd").string();
  const Outcome fit = scanmill({"fit-sensor", frame, "-o", at("unit.yaml")});
  ASSERT_EQ(fit.code, 0) << fit.error;
  EXPECT_THAT(fit.out,
              AllOf(HasSubstr("fitted to 107,647 points of 1 scans: 128 rings x 1024 columns over a full turn"),
                    HasSubstr("fit-noise"), HasSubstr("origin_offset_m: 0.0158"),
                    HasSubstr("mount: {position: [0, 0, 1.99], pitch_deg: -0.")));
  EXPECT_THAT(scanmill({"info", at("unit.yaml")}).out, HasSubstr("128"));
  expectRefused(scanmill({"fit-sensor", frame, "-o", at("unit.yaml")}), "--overwrite");
}

}  // namespace
}  // namespace scanmill
