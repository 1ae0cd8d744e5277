#pragma once

// What a repeatability study compares: the key `repeatability:` of a pipeline, every part of which may be left out.
//
//   repeatability:
//     scans: 5                      # so many from each pose, with the seeds seed, seed + 1, ...
//     noise:                        # noise levels (default: one, the pipeline's own effects)
//       - {name: 1 cm, effects: [{shell: {scale_m: 0.01}}]}
//       - {name: fitted, effects: sensor}      # those of the sensor's own file
//     reference: 1 cm               # the level of the first charts (default: the first)
//     methods: [ray_tracing, {depth_camera: {resolution: 512}}]   # default: the pipeline's own
//     object: crate                 # name of the thing in the scene (default: the one nearest to the sensor)
//     margin_m: 0.1                 # points farther from the thing's box are cropped away
//     icp: {iterations: 10, reach_m: 0.5, fitness_within_m: 0.5}  # default: as PCL's, 10 and no limits

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "evaluate/registration.h"
#include "evaluate/settings.h"
#include "pipeline/read/pipeline.h"
#include "sense/sense.h"

namespace scanmill {

struct NoiseLevel {
  std::string name;
  std::vector<std::shared_ptr<const Effects>> effects;  // of each sensor
  bool named = true;                                    // false: these are the pipeline's own
};

struct RepeatabilityChoice {
  std::uint32_t scans = 5;
  std::vector<NoiseLevel> levels;
  std::size_t reference = 0;  // index into levels
  std::vector<MethodSetting> methods;
  std::string object;   // empty where it is the thing nearest to the sensor
  double margin = 0.1;  // m
  IcpOptions icp;
};

// Reads the key, and checks the options of the pipeline's own `method: auto`, where it says so. Throws InputError with
// the place.
RepeatabilityChoice readRepeatabilityChoice(const Pipeline& pipeline);

// What is kept of the scans that are compared: where the points are, and which column fired them.
ScanLayout repeatabilityLayout();
// The channels that the noise levels read. The plan is made with them, so that it loads the textures that they need.
Channels repeatabilityChannels(const Pipeline& pipeline);

}  // namespace scanmill
