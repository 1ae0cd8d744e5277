#include "commands/command.h"

#include <array>

namespace scanmill {

std::span<const Command> commands() {
  static constexpr std::array kCommands{
      Command{"generate", "PIPELINE -o DIR", "make a dataset", runGenerate},
      Command{"merge", "DIR", "complete a dataset whose shards several processes have made", runMerge},
      Command{"render", "PIPELINE -o DIR", "write only the images that the depth-camera method draws, as EXR",
              runRender},
      Command{"tradeoff", "PIPELINE -o DIR", "compare the speed and the errors of methods and settings, as a report",
              runTradeoff},
      Command{"repeatability", "PIPELINE -o DIR", "measure how well repeated scans of one object agree, as a report",
              runRepeatability},
      Command{"fit-noise", "SCAN... --sensor FILE|NAME -o FILE.yaml",
              "measure a real sensor's noise and intensity curve on recorded scans, as effects for its file",
              runFitNoise},
      Command{"fit-sensor", "SCAN... -o FILE.yaml", "recover a sensor's beams from recorded scans", runFitSensor},
      Command{"compare", "REAL SIMULATED -o DIR", "compare real scans with simulated ones, as a page", runCompare},
      Command{"draft", "ASSET... -o FILE.yaml",
              "write a scene file for 3D files; units, axes, classes and materials are guesses to check", runDraft},
      Command{"plan", "PIPELINE", "show what a pipeline makes, what it models and what it leaves out", runPlan},
      Command{"verify", "DIR", "check that a dataset is complete and undamaged", runVerify},
      Command{"export", "DIR --to LAYOUT -o DIR",
              "convert a dataset to SemanticKITTI, KITTI, nuScenes, LAS, PLY or MCAP", runExport},
      Command{"report", "DATASET [-o FILE.html]",
              "write a page that shows a dataset: pictures, figures, warnings, points in 3D", runReport},
      Command{"view", "DATASET|SHARD|SCAN|EXR|SCENE",
              "show scans and scenes in a window, or write pictures of them and of EXR images", runView},
      Command{"info", "FILE|DIR", "describe a dataset, shard, scan, recording, scene, sensor or pipeline", runInfo},
      Command{"example", "[NAME]", "copy an example and print its commands; without NAME: list all (docs/gallery.md)",
              runExample},
      Command{
          "list", "[KIND]",
          "list methods, sensors, effects, formats ...; with KIND, such as effects, or the name of an effect: the keys",
          runList},
  };
  return kCommands;
}

}  // namespace scanmill
