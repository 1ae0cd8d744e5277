#include "commands/command.h"

#include <array>

namespace scanmill {

std::span<const Command> commands() {
  static constexpr std::array kCommands{
      Command{"generate", "PIPELINE -o DIR", "make a dataset", runGenerate},
      Command{"merge", "DIR", "end a dataset whose shards were made by several processes", runMerge},
      Command{"render", "PIPELINE -o DIR", "only the images of the depth-camera method, as EXR", runRender},
      Command{"tradeoff", "PIPELINE -o DIR", "what each method and setting costs and how it errs, as a report",
              runTradeoff},
      Command{"repeatability", "PIPELINE -o DIR", "how well repeated scans of one object agree, as a report",
              runRepeatability},
      Command{"fit-noise", "SCAN... --sensor FILE|NAME -o FILE.yaml",
              "a real sensor's noise, measured on recorded scans, as effects of its sensor file", runFitNoise},
      Command{"fit-sensor", "SCAN... -o FILE.yaml", "a sensor's beams, recovered from recorded scans", runFitSensor},
      Command{"compare", "REAL SIMULATED -o DIR",
              "two sets of scans, and which features of local patches tell them apart, as a page", runCompare},
      Command{"draft", "ASSET... -o FILE.yaml",
              "a scene file of 3D files: units, axes, classes and materials are guessed, for you to check", runDraft},
      Command{"plan", "PIPELINE",
              "what a pipeline would do, what it leaves out and, with --costs, what its features cost", runPlan},
      Command{"verify", "DIR", "whether a dataset or a recording is whole: every file is decoded", runVerify},
      Command{"regenerate", "DIR", "damaged shards of a dataset, or a sample, made again byte for byte", runRegenerate},
      Command{"export", "DIR --to LAYOUT -o DIR",
              "a dataset as SemanticKITTI, KITTI, nuScenes, LAS, PLY, NumPy or MCAP", runExport},
      Command{"report", "DATASET [-o FILE.html]",
              "a page that shows a dataset: pictures, figures, warnings, points in 3D", runReport},
      Command{"view", "DATASET|SHARD|SCAN|EXR|SCENE",
              "a window on scans, images and scenes; pictures without a display", runView},
      Command{"info", "FILE|DIR", "a dataset, shard, scan, recording, scene, sensor or pipeline as tables", runInfo},
      Command{"list", "[KIND]", "methods, sensors, effects, formats ...; with KIND, their keys; devices", runList},
  };
  return kCommands;
}

}  // namespace scanmill
