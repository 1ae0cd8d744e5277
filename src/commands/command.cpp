#include "commands/command.h"

#include <array>

namespace scanmill {

std::span<const Command> commands() {
  static constexpr std::array kCommands{
      Command{"generate", "PIPELINE -o DIR", "make a dataset", runGenerate},
      Command{"render", "PIPELINE -o DIR", "only the images of the depth-camera method, as EXR", runRender},
      Command{"plan", "PIPELINE", "what a pipeline would do, and what it would leave out; traces nothing", runPlan},
      Command{"verify", "DIR", "whether a dataset or a recording is whole: every file is decoded", runVerify},
      Command{"info", "FILE|DIR", "a dataset, shard, scan, recording, scene, sensor or pipeline as tables", runInfo},
      Command{"picture", "DATASET|SHARD|SCAN|EXR -o FILE.png", "a look at a scan or at passes, without a display",
              runPicture},
      Command{"list", "[KIND]", "methods, sensors, effects, formats, ontologies; with KIND, their keys", runList},
  };
  return kCommands;
}

}  // namespace scanmill
