// What vendors and recordings say of sensors and poses.

#include "base/error.h"
#include "config/value.h"
#include "sensors/beam_files.h"
#include "sensors/beam_patterns.h"
#include "sensors/calibration.h"
#include "sensors/ouster_metadata.h"
#include "sensors/pose_files.h"
#include "tests/fuzz/target.h"

namespace scanmill {
namespace {

const AddFuzzTarget kBeams("beams", [](std::string_view bytes) {
  switch (kindOf(bytes, 5)) {
    case 0:
      readBeamTable(inputFile(bytes, ".csv"));
      break;
    case 1:
      readFiringTable(inputFile(bytes, ".csv"));
      break;
    case 2:
      readListedBeams(inputFile(bytes, ".csv"));
      break;
    case 3:
      readOusterMetadata(inputFile(bytes, ".json"));
      break;
    default:
      withCalibration(parseYaml("calibration: " + inputFile(bytes, ".yaml").string() + "\n", "sensor.yaml"));
  }
});

const AddFuzzTarget kPoses("poses", [](std::string_view bytes) {
  switch (kindOf(bytes, 6)) {
    case 0:
      readKittiPoses(inputFile(bytes, ".txt"));
      break;
    case 1:
      readTimes(inputFile(bytes, ".txt"));
      break;
    case 2:
      readKittiCalibration(inputFile(bytes, ".txt"));
      break;
    case 3:
      readTumPoses(inputFile(bytes, ".txt"));
      break;
    case 4:
      readPoseTable(inputFile(bytes, ".csv"));
      break;
    default:
      readNuScenesPoses(inputFile(bytes, ".json"), "");
  }
});

}  // namespace
}  // namespace scanmill
