// What vendors and recordings say of sensors and poses.

#include <functional>
#include <vector>

#include "base/error.h"
#include "config/value.h"
#include "sensors/beam_patterns.h"
#include "sensors/calibration.h"
#include "sensors/recorded_poses.h"
#include "tests/fuzz/target.h"

namespace scanmill {
namespace {

struct Kind {
  const char* suffix;
  std::function<void(const std::filesystem::path&)> read;
};

FuzzTarget readersOf(const std::vector<Kind>& kinds) {
  return [kinds](std::string_view bytes) {
    const Kind& kind = kinds[kindOf(bytes, kinds.size())];
    kind.read(inputFile(bytes, kind.suffix));
  };
}

const AddFuzzTarget kBeams("beams", readersOf({{".csv", readBeamTable},
                                               {".csv", readFiringTable},
                                               {".csv", readListedBeams},
                                               {".json", readOusterMetadata},
                                               {".yaml", [](const std::filesystem::path& file) {
                                                  static_cast<void>(withCalibration(parseYaml(
                                                      "calibration: " + file.string() + "\n", "sensor.yaml")));
                                                }}}));

const AddFuzzTarget kPoses("poses", readersOf({{".txt", readKittiPoses},
                                               {".txt", readTimes},
                                               {".txt", readKittiCalibration},
                                               {".txt", readTumPoses},
                                               {".csv", readPoseTable},
                                               {".json", [](const std::filesystem::path& file) {
                                                  readNuScenesPoses(file, "");
                                                }}}));

}  // namespace
}  // namespace scanmill
