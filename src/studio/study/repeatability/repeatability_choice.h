#pragma once

// The choices of a repeatability study: the key `repeatability:` of a pipeline. All of its parts are optional.
//
//   repeatability:
//     scans: 5                      # scans from each pose, with the seeds seed, seed + 1, ...
//     noise:                        # noise levels (default: one, the pipeline's own effects)
//       - {name: 1 cm, effects: [{shell: {scale_m: 0.01}}]}
//       - {name: fitted, effects: sensor}      # the effects of the sensor's own file
//     reference: 1 cm               # the level of the first charts (default: the first)
//     methods: [ray_tracing, {depth_camera: {resolution: 512}}]   # default: the pipeline's own
//     object: crate                 # name of an object in the scene (default: the object nearest to the sensor)
//     margin_m: 0.1                 # points farther from the object's box are cropped away
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
  std::vector<std::shared_ptr<const Effects>> effects;  // the effects of each sensor
  bool named = true;                                    // false: the pipeline's own effects
};

struct RepeatabilityChoice {
  std::uint32_t scans = 5;
  std::vector<NoiseLevel> levels;
  std::size_t reference = 0;  // index into levels
  std::vector<MethodSetting> methods;
  std::string object;   // empty: the object nearest to the sensor
  double margin = 0.1;  // m
  IcpOptions icp;
};

// Reads the key, and checks the options of the pipeline's own method if that is `method: auto`. Throws InputError that
// names the place in the pipeline.
RepeatabilityChoice readRepeatabilityChoice(const Pipeline& pipeline);

// Columns that compared scans keep: the positions of the points, and the columns that fired them.
ScanLayout repeatabilityLayout();
// Returns the channels that the noise levels read. A plan made with them loads the textures that they need.
Channels repeatabilityChannels(const Pipeline& pipeline);

}  // namespace scanmill
